"""7.3: misalignment by whole turns forward and back, eq. (7) to (9) and (17).

The angle of a turn and how fast it was: by the table's encoders, else by the label.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import AXES, Axis, Recording, Segment
from schemas.text import Remark
from tasks.motion.table import mean_rate
from tasks.specifications.estimate import (
    DEG,
    OFF_DIAGONAL_ELEMENTS,
    ClauseResult,
    Estimate,
    Estimates,
    ItemEstimate,
    item_by_axis,
    linear_estimate,
    scaled,
    u_of_means,
    undetermined,
)
from tasks.specifications.jjf1536.evidence import AhrsEvidence, reads_another_rate
from tasks.specifications.unit_model import weights_about
from tasks.uncertainty.budget import observed
from tasks.words import Message, message, remark

MISALIGNMENT = "ahrs_misalignment"
CLAUSE = "JJF 1536-2015, 7.3.2 eq. (17)"
TURN = 2 * np.pi
WHOLE_TURN = np.radians(1.0)  # rad: what may be missing of a whole number of turns
LABELLED = np.radians(1.0)  # rad: an encoder that shows more or less contradicts the label
TURNED = 2e-3  # of the angle, within which unit and label agree; of a misalignment less than U
COVERED = 3.0  # standard uncertainties
TURNS_ASKED, RATE_ASKED = 10, 100.0  # 7.3.1 b), where no agreement says otherwise
READINGS = ("jjf1536.turns_divisor", "jjf1536.l_yz", "jjf1536.index_order", "jjf1536.turned_angle")


@dataclass(frozen=True)
class WholeTurns:
    """Whole turns about one axis.

    index: the segments; angle: (n,) rad, turned about the axis, positive forward.
    """

    axis: Axis
    index: tuple[int, ...]
    angle: np.ndarray


def misalignment_items(
    evidence: AhrsEvidence, rate: np.ndarray, scale: Estimates, offset: Estimates
) -> ClauseResult:
    """L (3, 3) of eq. (17), degrees; the first index reads, the second turns.

    rate: (n, 3) rad/s of each segment in the unit's axes.
    scale: K of 7.1 by axis, by which the turned axis itself shows whether the angle is right.
    offset: B of 7.2 by axis, deg/s; it counts only where forward and back took different times.
    """
    zero = scaled(offset, 1.0 / DEG)
    every = {axis: _turns(evidence, axis) for axis in AXES}
    why = {axis: _not_determined(evidence, turns) for axis, turns in every.items()}
    runs = {axis: turns.index for axis, turns in every.items() if why[axis] is None}

    def of_axis(j: int, axis: Axis) -> tuple[Estimates, Iterable[Remark]] | Message:
        turns, reason = every[axis], why[axis]
        if reason is not None:
            return reason
        ratios = list[Estimate]()
        for i in range(3):
            readings = {a: _ratio(evidence, i, every[a], zero[AXES[i]]) for a in runs}
            weights = weights_about(evidence, axis, rate, runs, readings)
            if weights is None:
                return message("jjf1536-crooked", axis=axis)
            ratio = linear_estimate(evidence, i, weights)
            # N/(2π·n) of each direction, as if it alone gave the result
            each = np.zeros((2, len(weights)))
            own = readings[axis][list(turns.index)]
            each[:, turns.index] = np.clip(own, 0.0, None), np.clip(own, None, 0.0)
            repeated = tuple(map(float, 2.0 * u_of_means(evidence, i, each)))
            ratios.append(replace(ratio, repeated=repeated).scaled(DEG))
        wrong = tuple(_wrong_angle(axis, scale[axis], ratios[j].scaled(1.0 / DEG)))
        if wrong:  # by how much each turn nobody knows
            ratios = [replace(ratio, lines=(observed(math.nan, ""),)) for ratio in ratios]
        elements = {AXES[i] + axis: ratios[i] for i in range(3) if i != j}
        return elements, (*wrong, *_remarks(evidence, turns))

    item = ItemEstimate(undetermined(OFF_DIAGONAL_ELEMENTS), CLAUSE, READINGS)
    return item_by_axis(MISALIGNMENT, item, of_axis)


def _wrong_angle(axis: Axis, scale: Estimate, turned: Estimate) -> Iterator[Remark]:
    """Turns of which the turned axis reads another angle than its scale factor makes of it.

    scale, turned: what the axis reads per rate by 7.1, per angle in the turns. Their ratio is one
    whatever the unit, but for a part that is missing from the label or from the turn.
    """
    if not scale.determined:
        return
    u = [one.quantity.u * one.sensitivity for one in (*scale.lines, *turned.lines)]
    off = turned.value / scale.value - 1.0
    if abs(off) > TURNED + COVERED * float(np.linalg.norm(u)):
        text = message("jjf1536-turned-angle-wrong", axis=axis, percent=f"{100.0 * off:+.2f}")
        yield remark("turned_angle_wrong", text, blocks_pass=True)


def _turns(evidence: AhrsEvidence, axis: Axis) -> WholeTurns:
    index = evidence.turns[axis]
    angle = [_turned_angle(evidence.recording, evidence.labels[i]) for i in index]
    return WholeTurns(axis, index, np.array(angle, float))


def _not_determined(evidence: AhrsEvidence, turns: WholeTurns) -> Message | None:
    """Why eq. (17) cannot be taken of these turns, None where it can."""
    forward, back = (turns.angle > 0).any(), (turns.angle < 0).any()
    if not (forward and back):
        which = "no-turns" if not (forward or back) else "no-back" if forward else "no-forward"
        return message(f"jjf1536-{which}", axis=turns.axis)
    for i, angle in zip(turns.index, turns.angle, strict=True):
        segment = evidence.segments[i]
        if reads_another_rate(segment, angle / segment.seconds):
            return message("jjf1536-turn-not-read", axis=turns.axis)
    return None


def _ratio(evidence: AhrsEvidence, channel: int, turns: WholeTurns, zero: Estimate) -> np.ndarray:
    """Weights (n,) of (N₊ − N₋)/(2·2π·n), rad.

    N₊, N₋: angle gained by the axis that reads, the mean over the turns each way. 2·2π·n: the
    angle turned forward plus the angle turned back. Where one direction took longer, the zero
    offset does not cancel and is taken away.
    """
    share = _shares(turns)
    gain = np.zeros(len(evidence.segments))
    for i, per_angle in zip(turns.index, share / (share @ turns.angle), strict=True):
        gain[i] += evidence.segments[i].seconds * per_angle
    longer = float(gain.sum())
    return gain if zero.operator is None else gain - longer * zero.operator[channel]


def _shares(turns: WholeTurns) -> np.ndarray:
    """Weight (n,) of each turn: the mean over those forward less the mean over those back."""
    forward, back = turns.angle > 0, turns.angle < 0
    return forward / forward.sum() - back / back.sum()


def _remarks(evidence: AhrsEvidence, turns: WholeTurns) -> Iterator[Remark]:
    for i, angle in zip(turns.index, turns.angle, strict=True):
        yield from _angle_remarks(evidence, i, float(angle))
    count = (np.abs(turns.angle) / TURN).round().min()
    seconds = np.array([evidence.segments[i].seconds for i in turns.index])
    rate = max(_rate_in_the_middle(evidence.recording, evidence.labels[i]) for i in turns.index)
    if count < TURNS_ASKED or rate < 0.8 * RATE_ASKED:
        text = message(
            "jjf1536-turns-as-agreed", axis=turns.axis, count=f"{count:.0f}", rate=f"{rate:.0f}",
            turns_asked=TURNS_ASKED, rate_asked=f"{RATE_ASKED:.0f}",
        )  # fmt: skip
        yield remark("turns_as_agreed", text)
    longer = abs(_shares(turns) @ seconds)
    if longer > 0.01 * seconds.max():
        text = message("jjf1536-turn-times-differ", axis=turns.axis, seconds=f"{longer:.1f}")
        yield remark("turn_times_differ", text, blocks_pass=True)


def _angle_remarks(evidence: AhrsEvidence, i: int, angle: float) -> Iterator[Remark]:
    """A turn that the encoders contradict, or that is not a whole number of turns."""
    label = evidence.segments[i].segment
    labelled, turned = _label_angle(label), f"{np.degrees(angle):+.2f}"
    if abs(angle - labelled) > LABELLED:
        text = message(
            "jjf1536-turned-angle-contradicted", segment=label.name, axis=label.axis or "",
            label=f"{np.degrees(labelled):+.2f}", table=turned,
        )  # fmt: skip
        yield remark("turned_angle_contradicted", text, (label.name,), blocks_pass=True)
    over = angle - TURN * round(angle / TURN)
    if abs(over) > WHOLE_TURN or abs(angle) < WHOLE_TURN:
        text = message("jjf1536-not-whole-turns", segment=label.name, angle=turned)
        yield remark("not_whole_turns", text, (label.name,), blocks_pass=True)


def _turned_angle(recording: Recording, segment: Segment) -> float:
    """Angle (rad) turned about the segment's axis: by the encoders, else by the label."""
    if recording.table is not None and segment.axis is not None:
        t = recording.table.t
        interval = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
        # The reading at the very end is the one that closes the turn.
        whole = segment.model_copy(update={"t_end": segment.t_end + 0.5 * interval})
        rate, rows = mean_rate(recording, whole), recording.table.rows(whole.t_start, whole.t_end)
        if rate is not None:
            turned = np.copysign(np.linalg.norm(rate), rate[AXES.index(segment.axis)])
            return float(turned * (t[rows.stop - 1] - t[rows.start]))
    return _label_angle(segment)


def _label_angle(segment: Segment) -> float:
    """Angle (rad) that the label says was turned."""
    if segment.angle_deg is not None:
        return float(np.radians(segment.angle_deg))
    return float(np.radians(segment.rate_deg_s or 0.0)) * (segment.t_end - segment.t_start)


def _rate_in_the_middle(recording: Recording, turn: Segment) -> float:
    """Rate (deg/s) in the middle third of a turn by the encoders, else over the whole of it."""
    third = (turn.t_end - turn.t_start) / 3.0
    edges = {"t_start": turn.t_start + third, "t_end": turn.t_end - third}
    by_table = mean_rate(recording, turn.model_copy(update=edges))
    if by_table is not None:
        return float(np.degrees(np.linalg.norm(by_table)))
    return float(np.degrees(abs(_label_angle(turn)))) / (turn.t_end - turn.t_start)
