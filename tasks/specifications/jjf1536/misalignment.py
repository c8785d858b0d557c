"""7.3: misalignment by whole turns forward and back, eq. (7) to (9) and (17)."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from schemas.calibration import Remark
from schemas.recording import AXES, Axis, Recording, Segment
from schemas.uncertainty import Distribution
from tasks.motion.table import mean_rate
from tasks.specifications.evaluation import Evaluation, make_item
from tasks.specifications.jjf1536.evidence import AhrsEvidence, is_unread
from tasks.specifications.measured import UNDETERMINED, Measured, measured, u_of_means
from tasks.specifications.parts import DEG, OFF_DIAGONAL, Part
from tasks.uncertainty.budget import Contribution, InputQuantity, combine
from tasks.uncertainty.equipment import Equipment
from tasks.uncertainty.type_b import ahrs_misalignment
from tasks.words import message

CLAUSE = "JJF 1536-2015, 7.3.2 eq. (17)"
TURN = 2 * np.pi
WHOLE = np.radians(1.0)  # rad: what may be missing of a whole number of turns
SAID = np.radians(1.0)  # rad: an encoder that says more or less contradicts the label
TURNS_ASKED, RATE_ASKED = 10, 100.0  # 7.3.1 b), where no agreement says otherwise

Reason = tuple[str, str]


@dataclass(frozen=True)
class Turns:
    """Whole turns about one axis.

    index: the segments; angle: (n,) rad, turned about the axis, positive forward.
    """

    axis: Axis
    index: tuple[int, ...]
    angle: np.ndarray


def misalignment_items(
    evidence: AhrsEvidence, offset: Mapping[str, Measured], evaluation: Evaluation
) -> Part:
    """L (3, 3) of eq. (17), degrees; the first index reads, the second turns.

    offset: B of 7.2 by axis, rad/s; it counts only where forward and back took different times.
    """
    found = {AXES[i] + AXES[j]: UNDETERMINED for i, j in OFF_DIAGONAL}
    zero = np.array([offset[axis].value for axis in AXES])
    missing: list[Reason] = []
    remarks: list[Remark] = []
    for j, axis in enumerate(AXES):
        turns = _turns(evidence, axis)
        sides = [s for s in (1, -1) if (turns.angle * s > 0).any()]
        if len(sides) < 2:
            missing.append(_one_sided(axis, sides))
            continue
        if any(_is_unread(evidence, i, a) for i, a in zip(turns.index, turns.angle, strict=True)):
            missing.append((
                f"{axis}: in turns about {axis} its own angle says otherwise; check the labels "
                "and the mount",
                f"{axis}：绕 {axis} 轴转动时该轴读数与转角不符，请核对标注和安装",
            ))  # fmt: skip
            continue
        for i in range(3):
            if i != j:
                ratio = _ratio(evidence, i, turns, offset[AXES[i]], evaluation.equipment)
                found[AXES[i] + AXES[j]] = ratio.scaled(DEG)
        remarks += _remarks(evidence, turns, zero)
    readings = ("jjf1536.turns_divisor", "jjf1536.l_yz", "jjf1536.index_order",
                "jjf1536.turned_angle")  # fmt: skip
    name = "ahrs_misalignment"
    item = make_item(evaluation, name, found, "deg", CLAUSE, readings)
    told = ("; ".join(en for en, _ in missing), "；".join(zh for _, zh in missing))
    return Part({name: item}, {name: told} if missing else {}, tuple(remarks))


def _is_unread(evidence: AhrsEvidence, i: int, angle: float) -> bool:
    return is_unread(evidence.segments[i], angle / evidence.segments[i].seconds)


def _turns(evidence: AhrsEvidence, axis: Axis) -> Turns:
    index = evidence.turns[axis]
    segments = (evidence.segments[i].segment for i in index)
    angle = np.array([turned_angle(evidence.recording, segment) for segment in segments])
    return Turns(axis, index, angle.reshape(-1))


def turned_angle(recording: Recording, segment: Segment) -> float:
    """Angle (rad) turned about the segment's axis: by the encoders, else by the label."""
    if recording.table is not None and segment.axis is not None:
        t = recording.table.t
        interval = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
        # The reading at the very end is the one that closes the turn.
        whole = segment.model_copy(update={"t_end": segment.t_end + 0.5 * interval})
        rate, rows = mean_rate(recording, whole), recording.table.rows(whole.t_start, whole.t_end)
        if rate is not None:
            return float(rate[AXES.index(segment.axis)] * (t[rows.stop - 1] - t[rows.start]))
    return label_angle(segment)


def label_angle(segment: Segment) -> float:
    """Angle (rad) that the label says was turned."""
    if segment.angle_deg is not None:
        return float(np.radians(segment.angle_deg))
    return float(np.radians(segment.rate_deg_s or 0.0)) * (segment.t_end - segment.t_start)


def _ratio(
    evidence: AhrsEvidence, channel: int, turns: Turns, zero: Measured, equipment: Equipment
) -> Measured:
    """(N₊ − N₋)/(2·2π·n), rad, with the lines of its budget.

    N₊, N₋: angle gained by the axis that reads, the mean over the turns each way. 2·2π·n: the
    angle turned forward plus the angle turned back.
    """
    share = _shares(turns)
    gain = np.zeros(len(evidence.segments))
    for i, each in zip(turns.index, share / (share @ turns.angle), strict=True):
        gain[i] += evidence.segments[i].seconds * each
    found = measured(evidence, channel, gain)
    longer = float(gain.sum()) if math.isfinite(zero.value) else 0.0
    lines = ahrs_misalignment(equipment, found.value, share, turns.angle)
    if longer:
        found = Measured(found.value - longer * zero.value, found.lines)
        lines = (*lines, _zero_line(zero, longer))
    forward, back = np.clip(gain, 0.0, None), np.clip(gain, None, 0.0)
    # N/(2π·n) of each direction, as if it alone gave the result
    apart = 2.0 * u_of_means(evidence, channel, np.array([forward, back]))
    return Measured(found.value, (*found.lines, *lines), tuple(map(float, apart)))


def _zero_line(zero: Measured, longer: float) -> Contribution:
    """The zero offset that does not cancel, where one direction took longer by `longer` s/rad."""
    known = combine("zero offset", "rad/s", zero.value, zero.lines_in("rad/s"))
    shape: Distribution = "normal" if math.isinf(known.dof) else "t"
    quantity = InputQuantity(
        "B",
        message("uncertainty-zero-offset"),
        "rad/s",
        known.u_c,
        "A",
        shape,
        zero.value,
        known.dof,
    )
    return Contribution(quantity, -longer)


def _shares(turns: Turns) -> np.ndarray:
    """Weight (n,) of each turn: the mean over those forward less the mean over those back."""
    forward, back = turns.angle > 0, turns.angle < 0
    return forward / forward.sum() - back / back.sum()


def _one_sided(axis: str, sides: list[int]) -> Reason:
    if not sides:
        return f"{axis}: no turns about {axis}", f"{axis}：没有绕 {axis} 轴的整周转动"
    en, zh = ("backward", "反转") if sides == [1] else ("forward", "正转")
    return (
        f"{axis}: no {en} turns about {axis}; eq. (17) takes the difference of both directions",
        f"{axis}：缺少绕 {axis} 轴{zh}数据；式(17)取正、反转之差",
    )


def _remarks(evidence: AhrsEvidence, turns: Turns, zero: np.ndarray) -> Iterator[Remark]:
    for i, angle in zip(turns.index, turns.angle, strict=True):
        segment = evidence.segments[i]
        yield from _angle_remarks(segment.segment, float(angle))
    counts = np.abs(turns.angle) / TURN
    seconds = np.array([evidence.segments[i].seconds for i in turns.index])
    rate = max(_fastest(evidence.recording, evidence.segments[i].segment) for i in turns.index)
    if counts.round().min() < TURNS_ASKED or rate < 0.8 * RATE_ASKED:
        yield Remark(
            code="turns_as_agreed",
            en=f"{turns.axis} axis: {counts.round().min():.0f} turns at {rate:.0f} deg/s; "
            f"7.3.1 has {TURNS_ASKED} turns at a high rate, {RATE_ASKED:.0f} deg/s for "
            "example, where no agreement says otherwise.",
            zh=f"{turns.axis} 轴：{counts.round().min():.0f} 周，{rate:.0f} °/s；"
            f"技术协议未另行规定时，7.3.1 为 {TURNS_ASKED} 周、高角速率"
            f"（如 {RATE_ASKED:.0f} °/s）。",
        )
    longer = abs(_shares(turns) @ seconds)
    if longer > 0.01 * seconds.max() and not np.isfinite(zero).all():
        yield Remark(
            code="turn_times_differ",
            en=f"{turns.axis} axis: turning forward and back took times that differ by "
            f"{longer:.1f} s; where the zero offset is not known it does not cancel.",
            zh=f"{turns.axis} 轴：正、反转时间相差 {longer:.1f} s；零偏未知处其影响未抵消。",
            blocks_pass=True,
        )


def _fastest(recording: Recording, turn: Segment) -> float:
    """Rate (deg/s) in the middle of a turn by the encoders, else over the whole of it."""
    third = (turn.t_end - turn.t_start) / 3.0
    edges = {"t_start": turn.t_start + third, "t_end": turn.t_end - third}
    shown = mean_rate(recording, turn.model_copy(update=edges))
    if shown is not None:
        return float(np.degrees(np.linalg.norm(shown)))
    return float(np.degrees(abs(label_angle(turn)))) / (turn.t_end - turn.t_start)


def _angle_remarks(label: Segment, angle: float) -> Iterator[Remark]:
    """A turn that the encoders contradict, or that is not a whole number of turns."""
    said = label_angle(label)
    if abs(angle - said) > SAID:
        yield Remark(
            code="turned_angle_contradicted",
            en=f"{label.name}: labelled {np.degrees(said):+.2f} deg about {label.axis}, but the "
            f"table shows {np.degrees(angle):+.2f} deg: the table's angle was used.",
            zh=f"{label.name}：标注绕 {label.axis} 轴 {np.degrees(said):+.2f}°，但转台显示 "
            f"{np.degrees(angle):+.2f}°：已按转台角度取用。",
            segments=(label.name,),
            blocks_pass=True,
        )
    over = angle - TURN * round(angle / TURN)
    if abs(over) > WHOLE or abs(angle) < WHOLE:
        yield Remark(
            code="not_whole_turns",
            en=f"{label.name}: turned by {np.degrees(angle):+.2f} deg, not by whole turns as 7.3.1 "
            "asks; Earth's rotation does not cancel.",
            zh=f"{label.name}：转过 {np.degrees(angle):+.2f}°，非 7.3.1 要求的整周，"
            "地球自转未抵消。",
            segments=(label.name,),
            blocks_pass=True,
        )
