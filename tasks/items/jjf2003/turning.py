"""7.2.1 and 7.2.3: gyro scale factor, cross coupling and fit offset from steady turning."""

import numpy as np

from schemas.calibration import Remark
from schemas.recording import AXES, Recording
from tasks.items.evidence import Evidence
from tasks.items.linear import solve
from tasks.items.parts import OFF_DIAGONAL, Estimate, Part, excess_scatter, make_item
from tasks.segments.summarise import CHANNELS

FEWEST_RATES, MOST_RATES = 7, 11
CLAUSE_SCALE = "JJF 2003-2022, 7.2.1.2 eq. (3)-(5)"
CLAUSE_CROSS = "JJF 2003-2022, 7.2.3.2"
DEG = float(np.degrees(1.0))


def turning_items(recording: Recording, evidence: Evidence) -> Part:
    """Scale factor matrix K (3, 3) and fit offset b (3,) of the gyro, eq. (3) to (5).

    Where an axis has no rate points but turns by a known angle, those give its column of K.
    """
    scale = Estimate(np.full((3, 3), np.nan), np.full((3, 3), np.nan))
    offset = Estimate(np.full(3, np.nan), np.full(3, np.nan))
    remarks: list[Remark] = []
    reasons: dict[str, tuple[str, str]] = {}
    by_angle = False
    for j, axis in enumerate(AXES):
        points = [i for i in evidence.points[axis] if evidence.segments[i].has_gyro]
        rates = np.round(np.degrees(evidence.rate[points]), 1)
        if len(set(rates)) >= 2:
            remarks.extend(_fit_rates(evidence, j, points, scale, offset))
            remarks.extend(_rate_remarks(axis, rates))
        elif evidence.turns[axis]:
            by_angle = _fit_turns(recording, evidence, j, scale) or by_angle
        if not np.isfinite(scale.value[j, j]):
            reasons[axis] = (
                f"{axis}: {len(set(rates))} rates about {axis}, two are needed",
                f"{axis}：绕 {axis} 轴仅 {len(set(rates))} 个角速率，至少需 2 个",
            )
    if by_angle:
        remarks.append(_by_angle_remark())
    return _as_part(scale, offset, reasons, tuple(remarks), by_angle, recording.table is not None)


def _fit_rates(
    evidence: Evidence, j: int, points: list[int], scale: Estimate, offset: Estimate
) -> list[Remark]:
    """Eq. (5) for the rate points about axis j: fills column j of K and b_j."""
    design = np.column_stack([evidence.rate[points], np.ones(len(points))])
    solution = solve(design)
    remarks = []
    for i in range(3):
        readings = evidence.means[points, i]
        covariance = evidence.covariance(i)[np.ix_(points, points)]
        factor = excess_scatter(solution, design, readings, covariance)
        value, u = solution.of(readings), factor * solution.uncertainty(covariance)
        scale.value[i, j], scale.u[i, j] = value[0], u[0]
        if i == j:
            offset.value[j], offset.u[j] = value[1], u[1]
        if factor > 1.0:
            remarks.append(_scatter_remark(CHANNELS[i], AXES[j], factor))
    return remarks


def _fit_turns(recording: Recording, evidence: Evidence, j: int, scale: Estimate) -> bool:
    """Column j of K from turns by a known angle: (∫ω′dt − B·T)/angle, B from the rests."""
    rests = [
        i
        for i, segment in enumerate(evidence.segments)
        if segment.segment.kind == "static" and segment.has_gyro
    ]
    turns = [i for i in evidence.turns[AXES[j]] if evidence.segments[i].has_gyro]
    if not rests or not turns:
        return False
    indices = [*turns, *rests]
    for i in range(3):
        operator = np.zeros(len(indices))
        for place, turn in enumerate(turns):
            segment = evidence.segments[turn]
            angle = np.radians(segment.segment.angle_deg or np.nan)
            gain = segment.seconds / angle / len(turns)
            operator[place] += gain
            operator[len(turns) :] -= gain / len(rests)
        covariance = evidence.covariance(i)[np.ix_(indices, indices)]
        scale.value[i, j] = operator @ evidence.means[indices, i]
        scale.u[i, j] = np.sqrt(operator @ covariance @ operator)
    return True


def _as_part(
    scale: Estimate,
    offset: Estimate,
    reasons: dict[str, tuple[str, str]],
    remarks: tuple[Remark, ...],
    by_angle: bool,
    has_table: bool,
) -> Part:
    readings = ("jjf2003.table_rate",) if has_table else ()
    if by_angle:
        readings = (*readings, "jjf2003.turned_angle")
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
        english = "; ".join(reason for reason, _ in reasons.values())
        chinese = "；".join(reason for _, reason in reasons.values())
        unavailable = {name: (english, chinese) for name in list(items)[:2]}
    if not np.isfinite(offset.value).all():
        axes = ", ".join(a for a, v in zip(AXES, offset.value, strict=True) if not np.isfinite(v))
        unavailable["gyro_fit_offset"] = (
            f"{axes}: eq. (4) needs at least two held rates about the axis",
            f"{axes}：式(4)要求绕该轴至少两个恒定角速率",
        )
    return Part(items, unavailable, remarks)


def _rate_remarks(axis: str, rates: np.ndarray) -> list[Remark]:
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
    return remarks


def _listed(rates: np.ndarray) -> str:
    return ", ".join(f"{rate:+g}" for rate in sorted(set(rates)))


def _scatter_remark(channel: str, axis: str, factor: float) -> Remark:
    return Remark(
        code="excess_scatter",
        en=f"{channel}, turning about {axis}: the points scatter about the line of eq. (4) "
        f"{factor:.1f} times more than the noise; the uncertainty was enlarged by as much.",
        zh=f"{channel}，绕 {axis} 轴转动：各点对式(4)直线的离散为噪声的 {factor:.1f} 倍，"
        "不确定度已按此放大。",
    )


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
