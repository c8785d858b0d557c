"""7.2.1 and 7.2.3: gyro scale factor, cross coupling and fit offset from steady turning."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.recording import AXES
from schemas.text import Remark
from tasks.specifications.estimate import (
    DEG,
    MATRIX,
    UNDETERMINED,
    ClauseResult,
    Estimate,
    Estimates,
    ItemEstimate,
    diagonal,
    excess_remarks,
    linear_estimate,
    off_diagonal,
)
from tasks.specifications.evidence import Evidence
from tasks.specifications.rates import distinct_rates, fit_line, rate_remarks
from tasks.uncertainty import type_b
from tasks.uncertainty.equipment import Equipment
from tasks.words import Sayable, clauses, message, remark

CLAUSE_SCALE = "JJF 2003-2022, 7.2.1.2 eq. (3)-(5)"
CLAUSE_CROSS = "JJF 2003-2022, 7.2.3.2"


@dataclass(frozen=True)
class Column:
    """What turning about one axis gives: a column of K, and b of the axis's own gyro (rad/s)."""

    scale: tuple[Estimate, ...] = (UNDETERMINED,) * 3
    offset: Estimate = UNDETERMINED
    by_angle: bool = False
    remarks: tuple[Remark, ...] = ()


def turning_items(evidence: Evidence, equipment: Equipment) -> ClauseResult:
    """Scale factor matrix K (3, 3) and fit offset b (3,) of the gyro, eq. (3) to (5).

    Where an axis has no rate points but turns by a known angle, those give its column of K.
    """
    columns, missing = [], []
    for j, axis in enumerate(AXES):
        points = [i for i in evidence.points[axis] if evidence.segments[i].has_gyro]
        rates = distinct_rates(evidence.rate[points])
        column = Column()
        if len(rates) >= 2:
            column = _fit_rates(evidence, j, points, equipment)
        elif evidence.turns[axis]:
            column = _fit_turns(evidence, j, equipment)
        if not column.scale[j].determined:
            missing.append(message("specifications-rates-needed", axis=axis, count=len(rates)))
        columns.append(column)
    return _as_result(columns, missing, evidence.has_table, equipment)


def _fit_rates(evidence: Evidence, j: int, points: list[int], equipment: Equipment) -> Column:
    """Eq. (5) for the rate points about axis j."""
    lines = [fit_line(evidence, i, points, equipment) for i in range(3)]
    factors = [line.excess.factor for line in lines]
    remarks = (
        *rate_remarks(AXES[j], evidence.rate[points], "7.2.1.1 c)"),
        *excess_remarks("jjf2003-line-scatter", factors, axis=AXES[j]),
    )
    return Column(tuple(line.slope for line in lines), lines[j].offset, remarks=remarks)


def _fit_turns(evidence: Evidence, j: int, equipment: Equipment) -> Column:
    """Column j of K from turns by a known angle: (∫ω′dt − B·T)/angle, B from the rests."""
    rests = [i for i in evidence.of_kind("static") if evidence.segments[i].has_gyro]
    turns = [i for i in evidence.turns[AXES[j]] if evidence.segments[i].has_gyro]
    if not rests or not turns:
        return Column()
    labels = [evidence.segments[i].segment for i in turns]
    angles = np.radians([label.angle_deg or np.nan for label in labels])
    weights = np.zeros(len(evidence.segments))
    for turn, angle in zip(turns, angles, strict=True):
        gain = evidence.segments[turn].seconds / angle / len(turns)
        weights[turn] += gain
        weights[rests] -= gain / len(rests)
    scale = [linear_estimate(evidence, i, weights) for i in range(3)]
    return Column(
        tuple(m.with_lines(*type_b.turned_angle(equipment, m.value, angles)) for m in scale),
        by_angle=True,
    )


def _as_result(
    columns: Sequence[Column], missing: Sequence[Sayable], has_table: bool, equipment: Equipment
) -> ClauseResult:
    by_angle = any(column.by_angle for column in columns)
    readings: tuple[str, ...] = ("jjf2003.table_rate",) if has_table else ()
    readings += ("jjf2003.turned_angle",) if by_angle else ()
    matrix = np.array([[column.scale[i].value for column in columns] for i in range(3)])
    scale = {
        AXES[i] + AXES[j]: columns[j]
        .scale[i]
        .with_lines(*type_b.turning_axis(equipment, *_across(matrix, i, j)))
        for i, j in MATRIX
    }
    offset: Estimates = {a: c.offset.scaled(DEG) for a, c in zip(AXES, columns, strict=True)}
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
    remarks = [remark for column in columns for remark in column.remarks]
    if by_angle:
        text = message("jjf2003-turned-angle")
        remarks.append(remark("turned_angle", text, blocks_pass=True))
    return ClauseResult(items, unavailable, tuple(remarks))


def _across(matrix: np.ndarray, i: int, j: int) -> list[float]:
    """K_ik of row i over the axes k ≠ j; where it is not determined, that of an ideal unit."""
    row = np.where(np.isfinite(matrix[i]), matrix[i], np.eye(3)[i])
    return [float(row[k]) for k in range(3) if k != j]


def gyro_matrix(turning: ClauseResult) -> np.ndarray:
    """K (3, 3) of the turning items, NaN where an element is missing."""
    scale = turning.items["gyro_scale_factor"].elements
    coupling = turning.items["gyro_cross_coupling"].elements
    return np.array([[(scale[a] if a == b else coupling[a + b]).value for b in AXES] for a in AXES])
