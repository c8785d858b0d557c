"""7.2.1 and 7.2.3: gyro scale factor, cross coupling and fit offset from steady turning."""

from dataclasses import dataclass

import numpy as np

from schemas.calibration import Remark
from schemas.recording import AXES, Recording
from tasks.segments.summarise import CHANNELS
from tasks.specifications.evaluation import Evaluation, make_item
from tasks.specifications.evidence import Evidence
from tasks.specifications.linear import solve
from tasks.specifications.measured import UNDETERMINED, Measured, measured
from tasks.specifications.parts import BLOCKING_EXCESS, DEG, OFF_DIAGONAL, Part, excess_scatter
from tasks.uncertainty import type_b
from tasks.uncertainty.equipment import Equipment

FEWEST_RATES, MOST_RATES = 7, 11
CLAUSE_SCALE = "JJF 2003-2022, 7.2.1.2 eq. (3)-(5)"
CLAUSE_CROSS = "JJF 2003-2022, 7.2.3.2"


@dataclass(frozen=True)
class Column:
    """What turning about one axis gives: a column of K, and b of the axis's own gyro (rad/s)."""

    scale: tuple[Measured, ...] = (UNDETERMINED,) * 3
    offset: Measured = UNDETERMINED
    by_angle: bool = False
    remarks: tuple[Remark, ...] = ()


def turning_items(recording: Recording, evidence: Evidence, evaluation: Evaluation) -> Part:
    """Scale factor matrix K (3, 3) and fit offset b (3,) of the gyro, eq. (3) to (5).

    Where an axis has no rate points but turns by a known angle, those give its column of K.
    """
    columns, reasons = [], []
    for j, axis in enumerate(AXES):
        points = [i for i in evidence.points[axis] if evidence.segments[i].has_gyro]
        rates = np.round(np.degrees(evidence.rate[points]), 1)
        column = Column()
        if len(set(rates)) >= 2:
            remarks = _rate_remarks(axis, rates)
            column = _fit_rates(evidence, j, points, remarks, evaluation.equipment)
        elif evidence.turns[axis]:
            column = _fit_turns(evidence, j, evaluation.equipment)
        if not np.isfinite(column.scale[j].value):
            reasons.append(
                (
                    f"{axis}: {len(set(rates))} rates about {axis}, two are needed",
                    f"{axis}：绕 {axis} 轴仅 {len(set(rates))} 个角速率，至少需 2 个",
                )
            )
        columns.append(column)
    return _as_part(tuple(columns), tuple(reasons), recording.table is not None, evaluation)


def _fit_rates(
    evidence: Evidence,
    j: int,
    points: list[int],
    remarks: tuple[Remark, ...],
    equipment: Equipment,
) -> Column:
    """Eq. (5) for the rate points about axis j."""
    rates = evidence.rate[points]
    seconds = np.array([evidence.segments[i].seconds for i in points])
    design = np.column_stack([rates, np.ones(len(points))])
    solution = solve(design)
    weights = np.zeros((2, len(evidence.segments)))
    weights[:, points] = np.where(solution.estimable[:, None], solution.operator, np.nan)
    scale, factors, offset = [], np.ones(3), UNDETERMINED
    for i in range(3):
        readings = evidence.means[points, i]
        covariance = evidence.covariance(i)[np.ix_(points, points)]
        excess = excess_scatter(solution, design, readings, covariance)
        factors[i] = excess.factor
        found = measured(evidence, i, weights[0], excess)
        table = (equipment, found.value)
        lines = type_b.turning_rate(*table, solution.operator[0], rates, seconds)
        scale.append(found.with_lines(*lines))
        if i == j:
            lines = type_b.turning_rate(*table, solution.operator[1], rates, seconds)
            offset = measured(evidence, i, weights[1], excess).with_lines(*lines)
    remarks = (*remarks, *_scatter_remarks(AXES[j], factors))
    return Column(tuple(scale), offset, remarks=remarks)


def _fit_turns(evidence: Evidence, j: int, equipment: Equipment) -> Column:
    """Column j of K from turns by a known angle: (∫ω′dt − B·T)/angle, B from the rests."""
    everything = enumerate(evidence.segments)
    rests = [i for i, s in everything if s.segment.kind == "static" and s.has_gyro]
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
    scale = [measured(evidence, i, weights) for i in range(3)]
    return Column(
        tuple(m.with_lines(*type_b.turned_angle(equipment, m.value, angles)) for m in scale),
        by_angle=True,
    )


def _as_part(
    columns: tuple[Column, ...],
    reasons: tuple[tuple[str, str], ...],
    has_table: bool,
    evaluation: Evaluation,
) -> Part:
    by_angle = any(column.by_angle for column in columns)
    readings: tuple[str, ...] = ("jjf2003.table_rate",) if has_table else ()
    readings += ("jjf2003.turned_angle",) if by_angle else ()
    matrix = np.array([[column.scale[i].value for column in columns] for i in range(3)])
    lines = type_b.turning_axis
    scale = {
        (i, j): columns[j].scale[i].with_lines(*lines(evaluation.equipment, *_across(matrix, i, j)))
        for i in range(3)
        for j in range(3)
    }
    diagonal: dict[str, Measured] = {a: scale[i, i] for i, a in enumerate(AXES)}
    coupling = {AXES[i] + AXES[j]: scale[i, j] for i, j in OFF_DIAGONAL}
    offset: dict[str, Measured] = {
        a: c.offset.scaled(DEG) for a, c in zip(AXES, columns, strict=True)
    }
    name, cross = "gyro_scale_factor", "gyro_cross_coupling"
    items = {
        name: make_item(evaluation, name, diagonal, "1", CLAUSE_SCALE, readings),
        cross: make_item(
            evaluation, cross, coupling, "1", CLAUSE_CROSS, (*readings, "jjf2003.k_gzy")
        ),
        "gyro_fit_offset": make_item(evaluation, "gyro_fit_offset", offset, "deg/s", CLAUSE_SCALE),
    }
    unavailable = {}
    if reasons:
        told = ("; ".join(en for en, _ in reasons), "；".join(zh for _, zh in reasons))
        unavailable = {"gyro_scale_factor": told, "gyro_cross_coupling": told}
    without = [axis for axis, found in offset.items() if not np.isfinite(found.value)]
    if without:
        listed = ", ".join(without)
        unavailable["gyro_fit_offset"] = (
            f"{listed}: eq. (4) needs at least two held rates about the axis",
            f"{listed}：式(4)要求绕该轴至少两个恒定角速率",
        )
    remarks = [remark for column in columns for remark in column.remarks]
    return Part(items, unavailable, (*remarks, *([_by_angle_remark()] if by_angle else [])))


def _across(matrix: np.ndarray, i: int, j: int) -> list[float]:
    """K_ik of row i over the axes k ≠ j; where it is not determined, that of an ideal unit."""
    row = np.where(np.isfinite(matrix[i]), matrix[i], np.eye(3)[i])
    return [float(row[k]) for k in range(3) if k != j]


def _rate_remarks(axis: str, rates: np.ndarray) -> tuple[Remark, ...]:
    """Conditions of 7.2.1.1 c): 7 to 11 points, in both directions."""
    remarks = []
    count = len(set(rates))
    if not FEWEST_RATES <= count <= MOST_RATES:
        remarks.append(
            Remark(
                code="number_of_rates",
                en=f"{axis} axis: {count} rates ({_listed(rates)} deg/s); 7.2.1.1 c) asks for "
                f"{FEWEST_RATES} to {MOST_RATES}.",
                zh=f"{axis} 轴：{count} 个角速率点（{_listed(rates)} °/s）；7.2.1.1 c) 要求 "
                f"{FEWEST_RATES}~{MOST_RATES} 个。",
                blocks_pass=True,
            )
        )
    if rates.min() >= 0 or rates.max() <= 0:
        remarks.append(
            Remark(
                code="one_direction",
                en=f"{axis} axis: all rates have the same sign; the other direction is missing.",
                zh=f"{axis} 轴：所有角速率同号，缺少另一方向。",
                blocks_pass=True,
            )
        )
    return tuple(remarks)


def _listed(rates: np.ndarray) -> str:
    return ", ".join(f"{rate:+g}" for rate in sorted(set(rates)))


def _scatter_remarks(axis: str, factors: np.ndarray) -> tuple[Remark, ...]:
    """One remark on the gyros whose points lie off the line by more than the noise."""
    listed = ", ".join(f"{CHANNELS[i]} {factors[i]:.1f}" for i in np.flatnonzero(factors > 1.0))
    if not listed:
        return ()
    remark = Remark(
        code="excess_scatter",
        en=f"Turning about {axis}, the points scatter about the line of eq. (4) more than the "
        f"noise explains ({listed} times); the uncertainties were enlarged by as much.",
        zh=f"绕 {axis} 轴转动时，各点对式(4)直线的离散超过噪声（{listed} 倍），"
        "不确定度已按此放大。",
        blocks_pass=bool(factors.max() > BLOCKING_EXCESS),
    )
    return (remark,)


def _by_angle_remark() -> Remark:
    return Remark(
        code="turned_angle",
        en="The scale factor comes from turns by a known angle, not from held rates as 7.2.1 has "
        "it.",
        zh="标度因数由已知转角得到，而非 7.2.1 的恒定角速率法。",
        blocks_pass=True,
    )


def gyro_matrix(part: Part) -> np.ndarray:
    """K (3, 3) of a turning part, NaN where an element is missing."""
    matrix = np.full((3, 3), np.nan)
    for i, a in enumerate(AXES):
        for j, b in enumerate(AXES):
            name, key = ("gyro_scale_factor", a) if i == j else ("gyro_cross_coupling", a + b)
            value = part.items[name].value[key]
            matrix[i, j] = np.nan if value is None else value
    return matrix
