"""7.1: scale factor by least squares over the rate points, eq. (10) to (15)."""

from collections.abc import Iterator

import numpy as np

from schemas.calibration import Remark
from schemas.recording import AXES, Axis
from tasks.specifications.evaluation import Evaluation, make_item
from tasks.specifications.jjf1536.evidence import AhrsEvidence, is_unread
from tasks.specifications.linear import solve
from tasks.specifications.measured import UNDETERMINED, Measured, measured
from tasks.specifications.parts import BLOCKING_EXCESS, Part, excess_scatter
from tasks.uncertainty.equipment import Equipment
from tasks.uncertainty.type_b import turning_rate

CLAUSE = "JJF 1536-2015, 7.1.2 eq. (10)-(15)"
FEWEST_RATES, MOST_RATES = 7, 11


def scale_items(evidence: AhrsEvidence, evaluation: Evaluation) -> Part:
    """K (3,) of eq. (14): the output of each point less the rests, against the input rate."""
    found: dict[str, Measured] = dict.fromkeys(AXES, UNDETERMINED)
    missing: list[tuple[str, str]] = []
    remarks: list[Remark] = []
    for channel, axis in enumerate(AXES):
        points = list(evidence.points[axis])
        rates = np.round(np.degrees(evidence.rate[points]), 1)
        count = len(set(rates))
        if count < 2:
            missing.append((
                f"{axis}: {count} rates about {axis}, two are needed",
                f"{axis}：绕 {axis} 轴仅 {count} 个角速率，至少需 2 个",
            ))  # fmt: skip
            continue
        rests = _rests(evidence, points, axis)
        found[axis], factor = _fit(evidence, channel, points, rests, evaluation.equipment)
        remarks += [*_rate_remarks(axis, rates), *_rest_remarks(axis, rests)]
        remarks += _scatter_remark(axis, factor)
    remarks += _unread_remarks(evidence)
    readings: tuple[str, ...] = ("jjf1536.output_rate",) if evidence.by_angle else ()
    readings += ("jjf1536.table_rate",) if evidence.recording.table is not None else ()
    told = ("; ".join(en for en, _ in missing), "；".join(zh for _, zh in missing))
    name = "ahrs_scale_factor"
    item = make_item(evaluation, name, found, "1", CLAUSE, readings)
    return Part({name: item}, {name: told} if missing else {}, tuple(remarks))


def _rests(
    evidence: AhrsEvidence, points: list[int], axis: Axis
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """The rest at the beginning and the one at the end of a rate run, eq. (11); empty if none.

    They are the nearest ones with the same axis up.
    """
    segments = evidence.segments
    first = min(segments[i].t_start for i in points)
    last = max(segments[i].t_end for i in points)
    known = {str(evidence.up[i]) for i in points if evidence.up[i]}
    ups = sorted(known or {f"+{axis}", f"-{axis}"})
    rests = [i for up in ups for i in evidence.rests[up]]
    before = [i for i in rests if segments[i].t_end <= first + 1e-6]
    after = [i for i in rests if segments[i].t_start >= last - 1e-6]
    start = (max(before, key=lambda i: segments[i].t_end),) if before else ()
    end = (min(after, key=lambda i: segments[i].t_start),) if after else ()
    return start, end


def _fit(
    evidence: AhrsEvidence,
    channel: int,
    points: list[int],
    rests: tuple[tuple[int, ...], tuple[int, ...]],
    equipment: Equipment,
) -> tuple[Measured, float]:
    """K with the lines of its budget, and how much more than the noise the points scatter."""
    held = [i for side in rests for i in side]
    indices = [*points, *held]
    outputs = np.hstack([  # F_j = F̄_j − F̄_r, eq. (12), F̄_r the mean of the rests, eq. (11)
        np.eye(len(points)),
        np.full((len(points), len(held)), -1.0 / max(1, len(held))),
    ])  # fmt: skip
    F = outputs @ evidence.means[indices, channel]
    covariance = outputs @ evidence.covariance(channel)[np.ix_(indices, indices)] @ outputs.T
    rates = evidence.rate[points]
    seconds = np.array([evidence.segments[i].seconds for i in points])
    design = np.column_stack([rates, np.ones(len(points))])  # eq. (13)
    solution = solve(design)
    excess = excess_scatter(solution, design, F, covariance)
    slope = np.where(solution.estimable[0], solution.operator[0], np.nan)
    weights = np.zeros(len(evidence.segments))
    np.add.at(weights, indices, slope @ outputs)
    found = measured(evidence, channel, weights, excess)
    lines = turning_rate(equipment, found.value, solution.operator[0], rates, seconds)
    return found.with_lines(*lines), excess.factor


def _rate_remarks(axis: str, rates: np.ndarray) -> Iterator[Remark]:
    """Conditions of 7.1.1 c): 7 to 11 points; of 3.1: over the whole range."""
    distinct = sorted(set(rates))
    if not FEWEST_RATES <= len(distinct) <= MOST_RATES:
        listed = ", ".join(f"{rate:+g}" for rate in distinct)
        yield Remark(
            code="number_of_rates",
            en=f"{axis} axis: {len(distinct)} rates ({listed} deg/s); 7.1.1 c) asks for "
            f"{FEWEST_RATES} to {MOST_RATES}.",
            zh=f"{axis} 轴：{len(distinct)} 个角速率点（{listed} °/s）；7.1.1 c) 要求 "
            f"{FEWEST_RATES}~{MOST_RATES} 个。",
            blocks_pass=True,
        )
    if distinct[0] >= 0 or distinct[-1] <= 0:
        yield Remark(
            code="one_direction",
            en=f"{axis} axis: all rates have the same sign; the other direction is missing.",
            zh=f"{axis} 轴：所有角速率同号，缺少另一方向。",
            blocks_pass=True,
        )


def _unread_remarks(evidence: AhrsEvidence) -> Iterator[Remark]:
    """Rate points about an axis that did not read them: another one was turned."""
    for i, segment in enumerate(evidence.segments):
        name, axis, rate = segment.segment.name, segment.segment.axis, evidence.rate[i]
        if axis is None or not np.isfinite(rate) or not is_unread(segment, rate):
            continue
        said, shown = np.degrees(rate), np.degrees(segment.mean[AXES.index(axis)])
        yield Remark(
            code="rate_not_read",
            en=f"{name}: turned at {said:+.2f} deg/s about {axis} by label, mount and table, but "
            f"{axis} reads {shown:+.2f} deg/s: it was left out; tell which axis was turned.",
            zh=f"{name}：按标注、安装及转台绕 {axis} 轴以 {said:+.2f} °/s 转动，但该轴读数为 "
            f"{shown:+.2f} °/s：未取用。",
            segments=(name,),
            blocks_pass=True,
        )


def _rest_remarks(axis: str, rests: tuple[tuple[int, ...], tuple[int, ...]]) -> Iterator[Remark]:
    """Eq. (11) takes a rest at the beginning and one at the end."""
    sides = (("before", "前"), ("after", "后"))
    absent = [side for side, held in zip(sides, rests, strict=True) if not held]
    if absent:
        en, zh = " or ".join(s for s, _ in absent), "、".join(s for _, s in absent)
        yield Remark(
            code="rest_missing",
            en=f"{axis} axis: no rest {en} the rate points, of which eq. (11) takes the mean; the "
            "scale factor does not depend on it, its fit offset does.",
            zh=f"{axis} 轴：角速率点{zh}缺少式(11)所需的静止数据；"
            "标度因数不受影响，拟合零位受影响。",
            blocks_pass=True,
        )


def _scatter_remark(axis: str, factor: float) -> Iterator[Remark]:
    if factor > 1.0:
        yield Remark(
            code="excess_scatter",
            en=f"{axis} axis: the rate points scatter about the line of eq. (13) {factor:.1f} "
            "times more than the noise explains; the uncertainty was enlarged by as much.",
            zh=f"{axis} 轴：各角速率点对式(13)直线的离散为噪声的 {factor:.1f} 倍，"
            "不确定度已按此放大。",
            blocks_pass=factor > BLOCKING_EXCESS,
        )
