"""7.2.2 and 7.2.4: biases, g-sensitivity, accelerometer scale factor and cross coupling."""

from collections.abc import Mapping

import numpy as np

from schemas.calibration import Item, Remark
from schemas.recording import Recording
from tasks.items.evidence import UPS, Evidence
from tasks.items.jjf2003.earth import earth_remarks, without_earth
from tasks.items.jjf2003.positions import (
    averages,
    input_matrix,
    position_remarks,
    usable_positions,
)
from tasks.items.linear import solve
from tasks.items.parts import (
    DEG,
    MATRIX,
    OFF_DIAGONAL,
    Estimate,
    Part,
    elements,
    excess_scatter,
    joined,
    make_item,
)
from tasks.segments.summarise import CHANNELS

CLAUSE_GYRO = "JJF 2003-2022, 7.2.2.2 eq. (6)-(8)"
CLAUSE_ACCEL = "JJF 2003-2022, 7.2.4.2 eq. (9)-(11)"
TRIADS_ZH = {"gyro": "陀螺", "accel": "加速度计"}


def tumble_items(recording: Recording, evidence: Evidence, gyro_k: np.ndarray) -> Part:
    """All items of the twelve positions.

    gyro_k: (3, 3) scales Earth's rotation, NaN where it is not known.
    """
    gyro = usable_positions(evidence, lambda segment: segment.has_gyro)
    accel = usable_positions(evidence, lambda segment: segment.has_accel)
    return joined(
        (
            Part(remarks=tuple(position_remarks(evidence, {**accel, **gyro}))),
            _gyro_part(recording, evidence, gyro, gyro_k),
            _accel_part(recording, evidence, accel),
        )
    )


def _estimate(
    evidence: Evidence, positions: dict[str, tuple[int, ...]], first: int
) -> tuple[Estimate, tuple[Remark, ...]]:
    """Eq. (7), (10): (3, 4) matrix and bias column for channels first, first+1, first+2."""
    design = input_matrix(tuple(positions))
    solution, operator = solve(design), averages(evidence, positions)
    value, u, factors = np.empty((3, 4)), np.empty((3, 4)), np.ones(3)
    for i in range(3):
        used = operator.any(axis=0)
        weights = operator[:, used]
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
    still, why_not = without_earth(recording, evidence, positions, estimate.value, gyro_k)
    items = _gyro_items(estimate, still)
    unavailable = _undetermined(items, positions)
    if why_not:
        before = unavailable.get("gyro_g_sensitivity")
        unavailable["gyro_g_sensitivity"] = _both_reasons(before, why_not)
    return Part(items, unavailable, (*earth_remarks(recording, gyro_k), *remarks))


def _gyro_items(estimate: Estimate, still: np.ndarray) -> dict[str, Item]:
    """g-sensitivity in (deg/s)/g and bias in deg/s from eq. (8)."""
    sensitivity = Estimate(estimate.value[:, :3], estimate.u[:, :3]).scaled(DEG)
    bias = Estimate(estimate.value[:, 3], estimate.u[:, 3]).scaled(DEG)
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
            unavailable[name] = _both_reasons(unavailable.get(name), why)
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


def _both_reasons(before: tuple[str, str] | None, more: tuple[str, str]) -> tuple[str, str]:
    if before is None:
        return more
    return f"{before[0]}; {more[0]}", f"{before[1]}；{more[1]}"


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
