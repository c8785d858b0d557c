"""7.2.1 and 7.2.3: gyro scale factor, cross coupling and fit offset from steady turning."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from schemas.recording import AXES, Axis
from schemas.text import Remark
from tasks.segments.summarise import ACCEL_COLUMNS
from tasks.specifications.equipment_errors import EquipmentErrors
from tasks.specifications.estimate import (
    DEG,
    MATRIX_ELEMENTS,
    NO_EXCESS,
    OFF_DIAGONAL_ELEMENTS,
    ClauseResult,
    Estimate,
    Estimates,
    ItemEstimate,
    diagonal,
    excess_remarks,
    item_by_axis,
    linear_estimate,
    off_diagonal,
    u_of_means,
    undetermined,
)
from tasks.specifications.evidence import BirgeRatio, ClauseEvidence
from tasks.specifications.unit_model import (
    direction,
    distinct_rates,
    fit_line,
    rate_remarks,
    weights_about,
)
from tasks.words import Message, Sayable, clauses, message, remark

CLAUSE_SCALE = "JJF 2003-2022, 7.2.1.2 eq. (3)-(5)"
CLAUSE_CROSS = "JJF 2003-2022, 7.2.3.2"
Responses = list[tuple[Estimate, BirgeRatio]]  # of the three gyros, per rate about one axis


def turning_items(
    evidence: ClauseEvidence, rate: np.ndarray, errors: EquipmentErrors
) -> ClauseResult:
    """Scale factor matrix K (3, 3) and fit offset b (3,) of the gyro, eq. (3) to (5).

    rate: (n, 3) rad/s of each segment in the unit's axes. Where an axis has no rate points but
    turns by a known angle, those give its column of K.
    """
    lines_about, offset = dict[Axis, Responses](), undetermined(AXES)
    missing, remarks, by_angle = list[Sayable](), list[Remark](), False
    for j, axis in enumerate(AXES):
        points = [i for i in evidence.points[axis] if evidence.segments[i].has_gyro]
        rates = distinct_rates(evidence.rate[points])
        if len(rates) >= 2:
            lines = [fit_line(evidence, i, points, errors) for i in range(3)]
            lines_about[axis] = [(line.estimates[0], line.excess) for line in lines]
            offset[axis] = lines[j].estimates[1].scaled(DEG)
            factors = [line.excess.factor for line in lines]
            remarks += rate_remarks(axis, evidence.rate[points], "7.2.1.1 c)")
            remarks += excess_remarks("jjf2003-line-scatter", factors, axis=axis)
        elif column := _fit_turns(evidence, axis):
            lines_about[axis] = [(estimate, NO_EXCESS) for estimate in column]
            by_angle = True
    scale = undetermined(MATRIX_ELEMENTS)
    runs = {axis: evidence.points[axis] or evidence.turns[axis] for axis in lines_about}
    for i, axis in product(range(3), lines_about):
        read = {a: o[i] for a, by in lines_about.items() if (o := by[i][0].operator) is not None}
        weights = weights_about(evidence, axis, rate, runs, read)
        if weights is not None:
            excess = lines_about[axis][i][1]
            scale[AXES[i] + axis] = linear_estimate(evidence, i, weights, excess)
    for axis in AXES:
        if not scale[axis * 2].determined:
            points = [i for i in evidence.points[axis] if evidence.segments[i].has_gyro]
            count = len(distinct_rates(evidence.rate[points]))
            missing.append(message("specifications-rates-needed", axis=axis, count=count))
    readings: tuple[str, ...] = ("jjf2003.table_rate",) if evidence.has_table else ()
    if by_angle:
        readings += ("jjf2003.turned_angle",)
        remarks.append(remark("turned_angle", message("jjf2003-turned-angle"), blocks_pass=True))
    return _as_result(scale, offset, readings, missing, remarks)


def _fit_turns(evidence: ClauseEvidence, axis: Axis) -> list[Estimate]:
    """A column of K from turns by a known angle: (∫ω′dt − B·T)/angle, B from the rests.

    Empty without turns or without rests.
    """
    rests = [i for i in evidence.of_kind("static") if evidence.segments[i].has_gyro]
    turns = [i for i in evidence.turns[axis] if evidence.segments[i].has_gyro]
    if not rests or not turns:
        return []
    angles = np.radians([evidence.labels[i].angle_deg or np.nan for i in turns])
    weights = np.zeros(len(evidence.segments))
    for turn, angle in zip(turns, angles, strict=True):
        gain = evidence.segments[turn].seconds / angle / len(turns)
        weights[turn] += gain
        weights[rests] -= gain / len(rests)
    return [linear_estimate(evidence, i, weights) for i in range(3)]


def _as_result(
    scale: Estimates,
    offset: Estimates,
    readings: tuple[str, ...],
    missing: list[Sayable],
    remarks: list[Remark],
) -> ClauseResult:
    crossed = (*readings, "jjf2003.k_gzy")
    items = {
        "gyro_scale_factor": ItemEstimate(diagonal(scale), CLAUSE_SCALE, readings),
        "gyro_cross_coupling": ItemEstimate(off_diagonal(scale), CLAUSE_CROSS, crossed),
        "gyro_fit_offset": ItemEstimate(offset, CLAUSE_SCALE),
    }
    unavailable: dict[str, Sayable] = {}
    if missing:
        why = clauses(missing)
        unavailable = {"gyro_scale_factor": why, "gyro_cross_coupling": why}
    if without := items["gyro_fit_offset"].undetermined:
        unavailable["gyro_fit_offset"] = message("jjf2003-no-line", axes=", ".join(without))
    return ClauseResult(items, unavailable, tuple(remarks))


def gyro_matrix(turning: ClauseResult) -> np.ndarray:
    """K (3, 3) of the turning items, NaN where an element is missing."""
    scale = turning.items["gyro_scale_factor"].elements
    coupling = turning.items["gyro_cross_coupling"].elements
    return np.array([[(scale[a] if a == b else coupling[a + b]).value for b in AXES] for a in AXES])


# 7.2.5: rate sensitivity of the accelerometers, p by eq. (12) and (13).

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
