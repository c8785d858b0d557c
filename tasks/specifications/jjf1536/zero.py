"""7.2: zero offset by four positions or by positions at equal angles, eq. (16)."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from schemas.calibration import Remark
from schemas.recording import AXES, Axis
from tasks.specifications.evaluation import Evaluation, make_item
from tasks.specifications.jjf1536.attitudes import COMPONENTS, VERTICAL, points_contradicted
from tasks.specifications.jjf1536.evidence import AhrsEvidence, is_zero_position
from tasks.specifications.linear import solve
from tasks.specifications.measured import UNDETERMINED, Measured, measured, u_of_means
from tasks.specifications.parts import BLOCKING_EXCESS, DEG, Excess, Part, excess_scatter
from tasks.uncertainty.equipment import Equipment
from tasks.uncertainty.type_b import ahrs_zero_offset

CLAUSE = "JJF 1536-2015, 7.2.3 eq. (16)"
CANCELS = 0.005  # of Earth's rotation that positions at equal angles may leave, 0.3° of placing
ALIKE = 0.02  # rad: attitudes closer than this are one position held twice
FEWEST = 4  # positions that may be taken by their label alone
ASKED = {4: 1800.0, 12: 1200.0}  # s for each position of the two methods, 7.2.1 and 7.2.2

Reason = tuple[str, str]


@dataclass(frozen=True)
class Positions:
    """The positions that serve one axis.

    groups: indices of the rests, those of one position together.
    direction: (positions, 15) where the axis points; None where no label and no table tells.
    up: (positions, 3) how much of each axis points up.
    """

    axis: Axis
    groups: tuple[tuple[int, ...], ...]
    direction: np.ndarray | None
    up: np.ndarray

    @property
    def rests(self) -> list[int]:
        return [i for group in self.groups for i in group]


def zero_items(evidence: AhrsEvidence, evaluation: Evaluation) -> tuple[Part, dict[str, Measured]]:
    """B (3,) of eq. (16): the mean over the positions of the angle gained per second.

    As an item in deg/s, and as what was measured in rad/s.
    """
    found: dict[str, Measured] = dict.fromkeys(AXES, UNDETERMINED)
    missing: list[Reason] = []
    remarks: list[Remark] = []
    for channel, axis in enumerate(AXES):
        positions = _positions(evidence, channel)
        why = _not_determined(positions)
        if why is not None:
            missing.append((f"{axis}: {why[0]}", f"{axis}：{why[1]}"))
            continue
        found[axis], factor = _mean(evidence, channel, positions, evaluation.equipment)
        remarks += [*_remarks(evidence, positions), *_scatter_remark(axis, factor)]
    name, readings = "ahrs_zero_offset", ("jjf1536.zero_time", "jjf1536.earth_cancels")
    printed = {axis: each.scaled(DEG) for axis, each in found.items()}
    item = make_item(evaluation, name, printed, "deg/s", CLAUSE, readings)
    told = ("; ".join(en for en, _ in missing), "；".join(zh for _, zh in missing))
    return Part({name: item}, {name: told} if missing else {}, tuple(remarks)), found


def _positions(evidence: AhrsEvidence, channel: int) -> Positions:
    """The rests of 7.2 whose label names the axis; where no label names one, all of them."""
    held = [i for i, segment in enumerate(evidence.segments) if is_zero_position(segment)]
    axis = AXES[channel]
    if any(evidence.segments[i].segment.axis for i in held):
        held = [i for i in held if evidence.segments[i].segment.axis == axis]
    groups: list[list[int]] = []
    first: list[np.ndarray] = []
    for i in held:
        points = evidence.pointing[i]
        if points is None:
            return Positions(axis, tuple((i,) for i in held), None, np.zeros((len(held), 3)))
        same = [g for g, p in enumerate(first) if np.abs(p - points).max() < ALIKE]
        if same:
            groups[same[0]].append(i)
        else:
            groups.append([i])
            first.append(points)
    exact = np.array(first).reshape(-1, 3, COMPONENTS).round(9)  # the cosine of 90° is nothing
    direction, up = exact[:, channel], exact[:, :, VERTICAL]
    return Positions(axis, tuple(tuple(group) for group in groups), direction, up)


def _not_determined(positions: Positions) -> Reason | None:
    """Why eq. (16) cannot be taken of these positions, None where it can."""
    count = len(positions.groups)
    if not count:
        return "no rest that serves the zero offset", "没有用于零偏的静止数据"
    if positions.direction is None:
        if count >= FEWEST:
            return None
        return (
            f"{count} positions, four are needed, and where the axis pointed is not recorded",
            f"仅 {count} 个位置（需四个），且未记录该轴指向",
        )
    left = float(np.linalg.norm(positions.direction.mean(axis=0)))
    if left <= CANCELS:
        return None
    who = "1 position leaves" if count == 1 else f"{count} positions leave"
    return (
        f"{who} up to {100 * left:.0f} % of Earth's rotation; eq. (16) needs positions at equal "
        "angles, each axis as often one way as the other",
        f"{count} 个位置不能抵消地球自转（最多残留 {100 * left:.0f}%）；式(16)要求等角度间隔的位置",
    )


def _mean(
    evidence: AhrsEvidence, channel: int, positions: Positions, equipment: Equipment
) -> tuple[Measured, float]:
    """B (rad/s) with the lines of its budget, and how much more than the noise positions differ.

    Every position counts once, so that Earth's rotation cancels; with one time T for all this is
    ΣN/(n·T).
    """
    rests = positions.rests
    groups = np.array([[i in group for i in rests] for group in positions.groups], float)
    average = np.zeros((len(groups), len(evidence.segments)))
    average[:, rests] = groups / groups.sum(axis=1, keepdims=True)
    excess = Excess()
    if positions.direction is not None:
        readings = average[:, rests] @ evidence.means[rests, channel]
        covariance = average @ evidence.covariance(channel) @ average.T
        # What gravity does to a gyro follows the attitude, too, and cancels as Earth's rotation.
        design = np.column_stack([np.ones(len(readings)), positions.direction, positions.up])
        excess = excess_scatter(solve(design), design, readings, covariance)
    found = measured(evidence, channel, average.mean(axis=0), excess)
    seconds = float(np.mean([evidence.segments[i].seconds for i in rests]))
    lines = ahrs_zero_offset(equipment, seconds, len(groups))
    apart = excess.factor * u_of_means(evidence, channel, average)
    return Measured(found.value, (*found.lines, *lines), tuple(map(float, apart))), excess.factor


def _remarks(evidence: AhrsEvidence, positions: Positions) -> Iterator[Remark]:
    """Conditions of 7.2.1 and 7.2.2: number of positions, time at each."""
    axis, count = positions.axis, len(positions.groups)
    yield from _contradicted(evidence, positions)
    if positions.direction is None:
        yield Remark(
            code="pointing_not_recorded",
            en=f"{axis} axis: neither encoders nor labels tell where it pointed; that its "
            f"{count} positions cancel Earth's rotation was not checked.",
            zh=f"{axis} 轴：未记录其指向；{count} 个位置是否抵消地球自转未经核实。",
            blocks_pass=True,
        )
    if count < FEWEST:
        yield Remark(
            code="number_of_positions",
            en=f"{axis} axis: {count} positions; 7.2.1 asks for four, 7.2.2 recommends twelve.",
            zh=f"{axis} 轴：{count} 个位置；7.2.1 要求四个，7.2.2 推荐十二个。",
            blocks_pass=True,
        )
    asked = ASKED[4] if count <= FEWEST else ASKED[12]
    seconds = [evidence.segments[i].seconds for i in positions.rests]
    interval = max(
        evidence.segments[i].seconds / evidence.segments[i].rows for i in positions.rests
    )
    if min(seconds) < asked - 2 * interval:
        yield Remark(
            code="short_position",
            en=f"{axis} axis: positions held for {min(seconds) / 60:.1f} min; 7.2 has "
            f"{asked / 60:.0f} min, or what the unit's working time makes of it.",
            zh=f"{axis} 轴：各位置最短 {min(seconds) / 60:.1f} min；7.2 为 {asked / 60:.0f} min，"
            "校准时间可根据被校航姿仪工作时间确定。",
            segments=tuple(
                evidence.segments[i].segment.name
                for i, held in zip(positions.rests, seconds, strict=True)
                if held < asked - 2 * interval
            ),
        )


def _contradicted(evidence: AhrsEvidence, positions: Positions) -> Iterator[Remark]:
    """Labels that say another attitude than table and mount do."""
    names = tuple(
        evidence.segments[i].segment.name
        for i in positions.rests
        if points_contradicted(evidence.recording, evidence.segments[i].segment)
    )
    if names:
        yield Remark(
            code="pointing_contradicted",
            en=f"{positions.axis} axis: the labels of {', '.join(names)} point the axes otherwise "
            "than table and mount do: table and mount were used.",
            zh=f"{positions.axis} 轴：{'、'.join(names)} 标注的指向与转台及安装不符："
            "已按转台及安装取用。",
            segments=names,
            blocks_pass=True,
        )


def _scatter_remark(axis: str, factor: float) -> Iterator[Remark]:
    if factor > 1.0:
        yield Remark(
            code="excess_scatter",
            en=f"{axis} axis: the positions differ {factor:.1f} times more than Earth's rotation "
            "and the noise explain; the uncertainty was enlarged by as much.",
            zh=f"{axis} 轴：各位置之差为地球自转与噪声所能解释的 {factor:.1f} 倍，"
            "不确定度已按此放大。",
            blocks_pass=factor > BLOCKING_EXCESS,
        )
