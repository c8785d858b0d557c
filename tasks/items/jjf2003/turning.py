"""7.2.1 and 7.2.3: gyro scale factor, cross coupling and fit offset from steady turning."""

from dataclasses import dataclass

import numpy as np

from schemas.calibration import Remark
from schemas.recording import AXES, Recording
from tasks.items.evidence import Evidence
from tasks.items.linear import solve
from tasks.items.parts import DEG, OFF_DIAGONAL, Estimate, Part, excess_scatter, make_item
from tasks.segments.summarise import CHANNELS

FEWEST_RATES, MOST_RATES = 7, 11
CLAUSE_SCALE = "JJF 2003-2022, 7.2.1.2 eq. (3)-(5)"
CLAUSE_CROSS = "JJF 2003-2022, 7.2.3.2"


@dataclass(frozen=True)
class Column:
    """What turning about one axis gives: a column of K, and b of the axis's own gyro (rad/s)."""

    scale: Estimate
    offset: float = float("nan")
    u_offset: float = float("nan")
    by_angle: bool = False
    remarks: tuple[Remark, ...] = ()


NOTHING = Column(Estimate(np.full(3, np.nan), np.full(3, np.nan)))


def turning_items(recording: Recording, evidence: Evidence) -> Part:
    """Scale factor matrix K (3, 3) and fit offset b (3,) of the gyro, eq. (3) to (5).

    Where an axis has no rate points but turns by a known angle, those give its column of K.
    """
    columns, reasons = [], []
    for j, axis in enumerate(AXES):
        points = [i for i in evidence.points[axis] if evidence.segments[i].has_gyro]
        rates = np.round(np.degrees(evidence.rate[points]), 1)
        column = NOTHING
        if len(set(rates)) >= 2:
            column = _fit_rates(evidence, j, points, _rate_remarks(axis, rates))
        elif evidence.turns[axis]:
            column = _fit_turns(evidence, j)
        if not np.isfinite(column.scale.value[j]):
            reasons.append(
                (
                    f"{axis}: {len(set(rates))} rates about {axis}, two are needed",
                    f"{axis}：绕 {axis} 轴仅 {len(set(rates))} 个角速率，至少需 2 个",
                )
            )
        columns.append(column)
    return _as_part(tuple(columns), tuple(reasons), recording.table is not None)


def _fit_rates(
    evidence: Evidence, j: int, points: list[int], remarks: tuple[Remark, ...]
) -> Column:
    """Eq. (5) for the rate points about axis j."""
    design = np.column_stack([evidence.rate[points], np.ones(len(points))])
    solution = solve(design)
    value, u, factors = np.empty((3, 2)), np.empty((3, 2)), np.ones(3)
    for i in range(3):
        readings = evidence.means[points, i]
        covariance = evidence.covariance(i)[np.ix_(points, points)]
        factors[i] = excess_scatter(solution, design, readings, covariance)
        value[i], u[i] = solution.of(readings), factors[i] * solution.uncertainty(covariance)
    return Column(
        scale=Estimate(value[:, 0], u[:, 0]),
        offset=float(value[j, 1]),
        u_offset=float(u[j, 1]),
        remarks=(*remarks, *_scatter_remarks(AXES[j], factors)),
    )


def _fit_turns(evidence: Evidence, j: int) -> Column:
    """Column j of K from turns by a known angle: (∫ω′dt − B·T)/angle, B from the rests."""
    everything = enumerate(evidence.segments)
    rests = [i for i, s in everything if s.segment.kind == "static" and s.has_gyro]
    turns = [i for i in evidence.turns[AXES[j]] if evidence.segments[i].has_gyro]
    if not rests or not turns:
        return NOTHING
    indices = [*turns, *rests]
    operator = np.zeros(len(indices))
    for place, turn in enumerate(turns):
        segment = evidence.segments[turn]
        angle = np.radians(segment.segment.angle_deg or np.nan)
        gain = segment.seconds / angle / len(turns)
        operator[place] += gain
        operator[len(turns) :] -= gain / len(rests)
    covariances = [evidence.covariance(i)[np.ix_(indices, indices)] for i in range(3)]
    value = np.array([operator @ evidence.means[indices, i] for i in range(3)])
    u = np.sqrt([operator @ covariance @ operator for covariance in covariances])
    return Column(Estimate(value, u), by_angle=True)


def _as_part(
    columns: tuple[Column, ...], reasons: tuple[tuple[str, str], ...], has_table: bool
) -> Part:
    scale = Estimate(
        np.column_stack([column.scale.value for column in columns]),
        np.column_stack([column.scale.u for column in columns]),
    )
    offset = Estimate(
        np.array([column.offset for column in columns]),
        np.array([column.u_offset for column in columns]),
    )
    by_angle = any(column.by_angle for column in columns)
    readings: tuple[str, ...] = ("jjf2003.table_rate",) if has_table else ()
    readings += ("jjf2003.turned_angle",) if by_angle else ()
    diagonal = Estimate(np.diag(scale.value), np.diag(scale.u))
    items = {
        "gyro_scale_factor": make_item(diagonal, "1", CLAUSE_SCALE, readings=readings),
        "gyro_cross_coupling": make_item(
            scale, "1", CLAUSE_CROSS, OFF_DIAGONAL, (*readings, "jjf2003.k_gzy")
        ),
        "gyro_fit_offset": make_item(offset.scaled(DEG), "deg/s", CLAUSE_SCALE),
    }
    unavailable = {}
    if reasons:
        told = ("; ".join(en for en, _ in reasons), "；".join(zh for _, zh in reasons))
        unavailable = {"gyro_scale_factor": told, "gyro_cross_coupling": told}
    without = [a for a, b in zip(AXES, offset.value, strict=True) if not np.isfinite(b)]
    if without:
        listed = ", ".join(without)
        unavailable["gyro_fit_offset"] = (
            f"{listed}: eq. (4) needs at least two held rates about the axis",
            f"{listed}：式(4)要求绕该轴至少两个恒定角速率",
        )
    remarks = [remark for column in columns for remark in column.remarks]
    return Part(items, unavailable, (*remarks, *([_by_angle_remark()] if by_angle else [])))


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
