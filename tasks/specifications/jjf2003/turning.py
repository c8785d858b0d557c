"""7.2.1 and 7.2.3: gyro scale factor, cross coupling and fit offset from steady turning."""

from itertools import product

import numpy as np

from schemas.recording import AXES, Axis
from schemas.text import Remark
from tasks.specifications.error_sources import EquipmentErrors
from tasks.specifications.estimate import (
    DEG,
    NO_EXCESS,
    ClauseResult,
    Estimate,
    Estimates,
    ItemEstimate,
    diagonal,
    excess_remarks,
    linear_estimate,
    off_diagonal,
    undetermined,
)
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.items import MATRIX_ELEMENTS
from tasks.specifications.linear import BirgeRatio
from tasks.specifications.rates import distinct_rates, fit_line, rate_remarks, weights_about
from tasks.words import Sayable, clauses, message, remark

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
