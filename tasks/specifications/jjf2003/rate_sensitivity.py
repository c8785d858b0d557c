"""7.2.5: rate sensitivity of the accelerometers, p by eq. (12) and (13)."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import AXES, Axis
from schemas.text import Remark
from tasks.segments.summarise import ACCEL_COLUMNS
from tasks.specifications.estimate import (
    ClauseResult,
    Estimate,
    Estimates,
    ItemEstimate,
    item_by_axis,
    linear_estimate,
    u_of_means,
    undetermined,
)
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.items import OFF_DIAGONAL_ELEMENTS
from tasks.specifications.rates import direction
from tasks.words import Message, message, remark

CLAUSE = "JJF 2003-2022, 7.2.5.2 eq. (12), (13)"
READINGS = (
    "jjf2003.p_turning",
    "jjf2003.p_sign",
    "jjf2003.p_lever_arm",
    "jjf2003.p_rates",
    "jjf2003.p_unit",
)
SQUARE = 9  # decimals of a direction cosine: what rounding leaves of a right angle
SAME_RATE = 0.99  # points within 1 % of the largest rate count as the largest


@dataclass(frozen=True)
class TurningWithRests:
    """Turning at the largest rate with one axis up, and the rests with the same axis up."""

    turning: tuple[int, ...]
    rests: tuple[int, ...]


def rate_sensitivity_item(evidence: ClauseEvidence, rate: np.ndarray) -> ClauseResult:
    """p (3, 3, metres; diagonal not defined): rest minus turning over ω², eq. (12), (13).

    rate: (n, 3) rad/s of each segment in the unit's axes, along which ω² counts.
    """
    runs_about = {axis: _runs(evidence, axis) for axis in AXES}
    known = {a: runs for a, runs in runs_about.items() if not isinstance(runs, Message)}
    part = {}  # (3,) of ω² that is about each axis of the unit
    for axis, runs in known.items():
        turning = [i for run in runs for i in run.turning]
        part[axis] = (direction(evidence, axis, rate, turning) ** 2).round(SQUARE)

    def of_axis(j: int, axis: Axis) -> tuple[Estimates, Iterable[Remark]] | Message:
        runs = runs_about[axis]
        if isinstance(runs, Message):
            return message("specifications-of-axis", axis=axis, reason=runs)
        elements = {}
        for i in (k for k in range(3) if k != j):
            about = [k for k, other in enumerate(AXES) if other in known and k != i]
            squares = np.array([part[AXES[k]][about] for k in about])
            shares = np.linalg.inv(squares)[about.index(j)]
            each = [(share, known[AXES[k]]) for share, k in zip(shares, about, strict=True)]
            elements[AXES[i] + axis] = _difference(evidence, i, each)
        return elements, _one_sided(evidence, axis, runs)

    item = ItemEstimate(undetermined(OFF_DIAGONAL_ELEMENTS), CLAUSE, READINGS)
    return item_by_axis("accel_rate_sensitivity", item, of_axis)


def _runs(evidence: ClauseEvidence, axis: Axis) -> tuple[TurningWithRests, ...] | Message:
    """The runs about each vertical direction of an axis that has rests, or why there are none."""
    points = [i for i in evidence.points[axis] if evidence.segments[i].has_accel]
    if not points:
        return message("jjf2003-no-rate", axis=axis)
    vertical = [i for i in points if (evidence.up[i] or "")[1:] == axis]
    if not vertical:
        return message("jjf2003-not-vertical", axis=axis)
    largest = max(abs(evidence.rate[i]) for i in vertical)
    fast = [i for i in vertical if abs(evidence.rate[i]) >= SAME_RATE * largest]
    runs = []
    for up in sorted({str(evidence.up[i]) for i in fast}):
        rests = [i for i in evidence.rests.get(up, ()) if evidence.segments[i].has_accel]
        beside = [i for i in rests if evidence.segments[i].segment.item == "rate_sensitivity"]
        turning = tuple(i for i in fast if evidence.up[i] == up)
        if rests:
            runs.append(TurningWithRests(turning, tuple(beside or rests)))
    if not runs:
        return message("jjf2003-no-rest-beside", axis=axis)
    return tuple(runs)


def _difference(
    evidence: ClauseEvidence,
    channel: int,
    weighted: list[tuple[float, tuple[TurningWithRests, ...]]],
) -> Estimate:
    """Rest minus turning over ω² for one accelerometer (m), of the runs about each axis a share.

    Each run has its own rests, because gravity reads differently up and down. Each direction of
    turning counts once, so that what changes its sign with the direction cancels.
    """
    rest, turning = np.zeros((2, len(evidence.segments)))
    for run, part in ((run, part / len(runs)) for part, runs in weighted if part for run in runs):
        directions = _directions(evidence, run)
        square = np.mean([np.mean(evidence.rate[each] ** 2) for each in directions])
        share = part / square
        for i in run.rests:
            rest[i] += share / len(run.rests)
        for each in directions:
            for i in each:
                turning[i] += share / len(directions) / len(each)
    column = ACCEL_COLUMNS.start + channel
    difference = linear_estimate(evidence, column, rest - turning)
    repeated = u_of_means(evidence, column, np.array([rest, turning]))
    return replace(difference, repeated=tuple(map(float, repeated)))


def _directions(evidence: ClauseEvidence, run: TurningWithRests) -> list[list[int]]:
    both = [[i for i in run.turning if evidence.rate[i] * sign > 0] for sign in (1, -1)]
    return [each for each in both if each]


def _one_sided(
    evidence: ClauseEvidence, axis: Axis, runs: tuple[TurningWithRests, ...]
) -> Iterator[Remark]:
    """Where a run has one direction only, or rests on one side of it only."""
    if any(len(_directions(evidence, run)) < 2 for run in runs):
        text = message("jjf2003-p-one-direction", axis=axis)
        yield remark("p_one_direction", text, blocks_pass=True)
    start = [segment.t_start for segment in evidence.segments]
    for run in runs:
        first, last = min(start[i] for i in run.turning), max(start[i] for i in run.turning)
        before = any(start[i] < first for i in run.rests)
        after = any(start[i] > last for i in run.rests)
        if not (before and after):
            text = message(f"jjf2003-p-no-rest-{'after' if before else 'before'}", axis=axis)
            yield remark("p_rest_on_one_side", text, blocks_pass=True)
