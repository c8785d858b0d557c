"""7.2.2 and 7.2.4: biases, g-sensitivity, accelerometer scale factor and cross coupling."""

from collections.abc import Callable, Collection, Iterator, Mapping

import numpy as np

from schemas.calibration import Item, Remark
from schemas.recording import AXES, Recording
from tasks.items.evidence import UPS, Evidence
from tasks.items.linear import solve
from tasks.items.parts import (
    MATRIX,
    OFF_DIAGONAL,
    Estimate,
    Part,
    elements,
    excess_scatter,
    make_item,
)
from tasks.motion.table import EARTH_RATE
from tasks.segments.summarise import CHANNELS, SegmentMean

CLAUSE_GYRO = "JJF 2003-2022, 7.2.2.2 eq. (6)-(8)"
CLAUSE_ACCEL = "JJF 2003-2022, 7.2.4.2 eq. (9)-(11)"
DEG = float(np.degrees(1.0))
TRIADS_ZH = {"gyro": "陀螺", "accel": "加速度计"}


def input_matrix(ups: tuple[str, ...]) -> np.ndarray:
    """Transposed Ā of 7.2.2.2: a row (aₓ, a_y, a_z, 1) in local g for each position."""
    rows = np.zeros((len(ups), 4))
    for row, up in enumerate(ups):
        rows[row, AXES.index(up[1])] = 1.0 if up[0] == "+" else -1.0
        rows[row, 3] = 1.0
    return rows


def tumble_items(recording: Recording, evidence: Evidence, gyro_k: np.ndarray) -> Part:
    """All items of the twelve positions.

    gyro_k: (3, 3) scales Earth's rotation, NaN where it is not known.
    """
    gyro = _positions(evidence, lambda segment: segment.has_gyro)
    accel = _positions(evidence, lambda segment: segment.has_accel)
    parts = (
        _gyro_part(recording, evidence, gyro, gyro_k),
        _accel_part(recording, evidence, accel),
    )
    remarks = tuple(_position_remarks(evidence, {**accel, **gyro}))
    return Part(
        {name: item for part in parts for name, item in part.items.items()},
        {name: reason for part in parts for name, reason in part.unavailable.items()},
        (*remarks, *parts[0].remarks, *parts[1].remarks),
    )


def _positions(
    evidence: Evidence, serves: Callable[[SegmentMean], bool]
) -> dict[str, tuple[int, ...]]:
    """The positions with at least one usable rest, by axis up, in the order of the clause."""
    usable = {
        up: tuple(i for i in evidence.positions[up] if serves(evidence.segments[i])) for up in UPS
    }
    return {up: indices for up, indices in usable.items() if indices}


def _averages(evidence: Evidence, positions: dict[str, tuple[int, ...]]) -> np.ndarray:
    """Operator (positions, segments) that gives U_i, the mean over headings (7.2.2.1 a).

    Every heading counts once. Where some are 180° apart, only those pairs count: a third
    heading would bring back what the pair cancels.
    """
    operator = np.zeros((len(positions), len(evidence.segments)))
    for row, indices in enumerate(positions.values()):
        headings = _headings(evidence, indices)
        counted = [h for h in headings if _opposite(h, headings)] or list(headings)
        for heading in counted:
            same = headings[heading]
            operator[row, same] = 1.0 / len(counted) / len(same)
    return operator


def _headings(evidence: Evidence, indices: tuple[int, ...]) -> dict[float | None, list[int]]:
    """The rests of a position by heading, degrees modulo 360 to the nearest one."""
    by_heading: dict[float | None, list[int]] = {}
    for i in indices:
        turn = evidence.segments[i].segment.turn_deg
        heading = None if turn is None else float(round(turn) % 360)
        by_heading.setdefault(heading, []).append(i)
    return by_heading


def _opposite(heading: float | None, headings: Collection[float | None]) -> bool:
    """Whether another heading lies 180° from this one, within 1°."""
    if heading is None:
        return False
    known = [other for other in headings if other is not None]
    return any(abs((heading - other) % 360 - 180) <= 1 for other in known)


def is_paired(evidence: Evidence, indices: tuple[int, ...]) -> bool:
    """Whether a position was held at two headings 180° apart, as 7.2.2.1 a) asks."""
    headings = _headings(evidence, indices)
    return any(_opposite(heading, headings) for heading in headings)


def _estimate(
    evidence: Evidence, positions: dict[str, tuple[int, ...]], first: int
) -> tuple[Estimate, tuple[Remark, ...]]:
    """Eq. (7), (10): (3, 4) matrix and bias column for channels first, first+1, first+2."""
    design = input_matrix(tuple(positions))
    solution, averages = solve(design), _averages(evidence, positions)
    value, u, factors = np.empty((3, 4)), np.empty((3, 4)), np.ones(3)
    for i in range(3):
        used = averages.any(axis=0)
        weights = averages[:, used]
        readings = weights @ evidence.means[used, first + i]
        covariance = weights @ evidence.covariance(first + i)[np.ix_(used, used)] @ weights.T
        factors[i] = excess_scatter(solution, design, readings, covariance)
        value[i] = solution.of(readings)
        u[i] = factors[i] * solution.uncertainty(covariance)
    return Estimate(value, u), _scatter_remarks(first, factors)


def _gyro_part(
    recording: Recording,
    evidence: Evidence,
    positions: dict[str, tuple[int, ...]],
    gyro_k: np.ndarray,
) -> Part:
    if not positions:
        reason = _no_rest("gyro")
        empty = Estimate(np.full((3, 4), np.nan), np.full((3, 4), np.nan))
        items = _gyro_items(empty, np.full((3, 3), np.nan))
        return Part(items, dict.fromkeys(items, reason))
    estimate, remarks = _estimate(evidence, positions, 0)
    still, why_not = _without_earth(recording, evidence, positions, estimate.value, gyro_k)
    items = _gyro_items(estimate, still)
    unavailable = _undetermined(items, positions)
    if why_not:
        before = unavailable.get("gyro_g_sensitivity")
        unavailable["gyro_g_sensitivity"] = _joined(before, why_not)
    return Part(items, unavailable, (*_earth_remarks(recording, gyro_k), *remarks))


def _gyro_items(estimate: Estimate, still: np.ndarray) -> dict[str, Item]:
    """g-sensitivity in (deg/s)/g and bias in deg/s from eq. (8)."""
    sensitivity = Estimate(DEG * estimate.value[:, :3], DEG * estimate.u[:, :3])
    bias = Estimate(DEG * estimate.value[:, 3], DEG * estimate.u[:, 3])
    readings = ("jjf2003.positions", "jjf2003.input_matrix")
    sensitivity_item = make_item(
        sensitivity, "(deg/s)/g", CLAUSE_GYRO, MATRIX, (*readings, "jjf2003.g_earth")
    )
    return {
        "gyro_bias": make_item(bias, "deg/s", CLAUSE_GYRO, readings=readings),
        "gyro_g_sensitivity": sensitivity_item.model_copy(
            update={"value_without_earth_rotation": elements(DEG * still)}
        ),
    }


def _without_earth(
    recording: Recording,
    evidence: Evidence,
    positions: dict[str, tuple[int, ...]],
    value: np.ndarray,
    gyro_k: np.ndarray,
) -> tuple[np.ndarray, tuple[str, str] | None]:
    """G (3, 3) with the vertical part of Earth's rotation removed, and why elements are null.

    The vertical part reads K·ωe·sin φ along the axis up. The horizontal part cancels in
    positions held at two headings 180° apart; in others it is not known, and reaches the gyros
    that are not vertical.
    """
    latitude = recording.manifest.station.latitude_deg
    still = value[:, :3].copy()
    if latitude is None:
        why = (
            "without Earth rotation: the latitude is not told",
            "扣除地球自转的值：未给出纬度",
        )
        return np.full((3, 3), np.nan), why
    k = np.where(np.isfinite(gyro_k), gyro_k, np.eye(3))
    still -= k * EARTH_RATE * np.sin(np.radians(latitude))
    single = [up for up, indices in positions.items() if not is_paired(evidence, indices)]
    for axis in {AXES.index(up[1]) for up in single}:
        others = [i for i in range(3) if i != axis]
        still[others, axis] = np.nan
    if not single:
        return still, None
    return still, (
        f"without Earth rotation, off the diagonal: {', '.join(single)} held at one heading only, "
        "so its horizontal part is not known",
        f"扣除地球自转的非对角元：{', '.join(single)} 仅在一个方位测量，水平分量未知",
    )


def _accel_part(
    recording: Recording, evidence: Evidence, positions: dict[str, tuple[int, ...]]
) -> Part:
    gravity = recording.manifest.station.gravity_m_s2
    if not positions:
        empty = Estimate(np.full((3, 4), np.nan), np.full((3, 4), np.nan))
        items = _accel_items(empty, None)
        return Part(items, dict.fromkeys(items, _no_rest("accel")))
    estimate, remarks = _estimate(evidence, positions, 3)
    items = _accel_items(estimate, gravity)
    unavailable = _undetermined(items, positions)
    if gravity is None:
        why = ("the local gravity is not told", "未给出当地重力加速度")
        for name in ("accel_scale_factor", "accel_cross_coupling"):
            unavailable[name] = _joined(unavailable.get(name), why)
    return Part(items, unavailable, remarks)


def _accel_items(estimate: Estimate, gravity: float | None) -> dict[str, Item]:
    """Scale factor and cross coupling (ratio to local gravity) and bias (m/s²), eq. (11)."""
    g = float("nan") if gravity is None else gravity
    matrix = Estimate(estimate.value[:, :3] / g, estimate.u[:, :3] / g)
    diagonal = Estimate(np.diag(matrix.value), np.diag(matrix.u))
    bias = Estimate(estimate.value[:, 3], estimate.u[:, 3])
    readings = ("jjf2003.positions", "jjf2003.input_matrix")
    return {
        "accel_scale_factor": make_item(diagonal, "1", CLAUSE_ACCEL, readings=readings),
        "accel_cross_coupling": make_item(
            matrix, "1", CLAUSE_ACCEL, OFF_DIAGONAL, (*readings, "jjf2003.k_azx")
        ),
        "accel_bias": make_item(bias, "m/s2", CLAUSE_ACCEL, readings=readings),
    }


def _undetermined(
    items: Mapping[str, Item], positions: dict[str, tuple[int, ...]]
) -> dict[str, tuple[str, str]]:
    """Why elements of these items are null: the positions that would determine them."""
    absent = ", ".join(up for up in UPS if up not in positions)
    reasons = {}
    for name, item in items.items():
        null = [element for element, value in item.value.items() if value is None]
        if null:
            reasons[name] = (
                f"{', '.join(null)}: no rest with {absent} up",
                f"{', '.join(null)}：缺少 {absent} 朝天的静止位置",
            )
    return reasons


def _no_rest(triad: str) -> tuple[str, str]:
    return (
        f"no usable rest with an axis up or down that has the {triad} triad",
        f"没有{TRIADS_ZH[triad]}数据可用且有轴朝天或朝地的静止位置",
    )


def _joined(before: tuple[str, str] | None, more: tuple[str, str]) -> tuple[str, str]:
    if before is None:
        return more
    return f"{before[0]}; {more[0]}", f"{before[1]}；{more[1]}"


def _position_remarks(
    evidence: Evidence, positions: dict[str, tuple[int, ...]]
) -> Iterator[Remark]:
    """Conditions of 7.2.2.1 a): six axes up, each at two headings."""
    absent = [up for up in UPS if up not in positions]
    if absent:
        yield Remark(
            code="positions_missing",
            en=f"No usable rest with {', '.join(absent)} up; 7.2.2.1 asks for all six.",
            zh=f"缺少 {', '.join(absent)} 朝天的可用静止位置；7.2.2.1 要求六个方向齐全。",
            blocks_pass=True,
        )
    single = [up for up, indices in positions.items() if not is_paired(evidence, indices)]
    if single:
        yield Remark(
            code="one_heading",
            en=f"{', '.join(single)} up: not held at two headings 180° apart as 7.2.2.1 asks; the "
            "horizontal part of Earth's rotation and of the table's tilt does not cancel.",
            zh=f"{', '.join(single)} 朝天：未按 7.2.2.1 在相差 180° 的两个方位测量，"
            "地球自转及转台倾斜的水平分量未抵消。",
            blocks_pass=True,
        )


def _earth_remarks(recording: Recording, gyro_k: np.ndarray) -> Iterator[Remark]:
    """Says what Earth's rotation does to the diagonal by eq. (7), in numbers where known."""
    latitude = recording.manifest.station.latitude_deg
    if latitude is None:
        return
    rate = DEG * EARTH_RATE * np.sin(np.radians(latitude))
    yield Remark(
        code="earth_rotation",
        en=f"By eq. (7) the diagonal of the g-sensitivity contains Earth's rotation, "
        f"{rate:.5f} (deg/s)/g at {latitude:g}° latitude; the value without it stands beside.",
        zh=f"按式(7)，g 敏感系数对角元含地球自转 {rate:.5f} (°/s)/g（纬度 {latitude:g}°）；"
        "旁列扣除后的值。",
    )
    if not np.isfinite(gyro_k).all():
        yield Remark(
            code="scale_factor_assumed",
            en="Where this run gives no gyro scale factor, 1 was taken to remove Earth's rotation.",
            zh="本次未得陀螺标度因数处，扣除地球自转时取 1。",
        )


def _scatter_remarks(first: int, factors: np.ndarray) -> tuple[Remark, ...]:
    """One remark on the channels whose positions disagree by more than the noise."""
    exceeding = np.flatnonzero(factors > 1.0)
    listed = ", ".join(f"{CHANNELS[first + i]} {factors[i]:.1f}" for i in exceeding)
    if not listed:
        return ()
    remark = Remark(
        code="excess_scatter",
        en=f"The positions disagree with the model more than the noise explains ({listed} times); "
        "the uncertainties were enlarged by as much.",
        zh=f"各位置与模型的偏差超过噪声（{listed} 倍），不确定度已按此放大。",
    )
    return (remark,)
