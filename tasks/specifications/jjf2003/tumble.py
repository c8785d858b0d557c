"""7.2.2 and 7.2.4: biases, g-sensitivity, accelerometer scale factor and cross coupling."""

from collections.abc import Mapping

import numpy as np

from schemas.calibration import Item, Remark
from schemas.recording import AXES, Recording
from tasks.segments.summarise import CHANNELS
from tasks.specifications.evaluation import Evaluation, make_item
from tasks.specifications.evidence import UPS, Evidence
from tasks.specifications.jjf2003.earth import earth_remarks, without_earth
from tasks.specifications.jjf2003.positions import position_remarks, usable_positions
from tasks.specifications.jjf2003.twelve import Twelve, twelve_positions
from tasks.specifications.measured import UNDETERMINED, Measured
from tasks.specifications.parts import (
    BLOCKING_EXCESS,
    DEG,
    MATRIX,
    NOMINAL_GRAVITY,
    OFF_DIAGONAL,
    Part,
    joined,
)
from tasks.uncertainty import type_b

CLAUSE_GYRO = "JJF 2003-2022, 7.2.2.2 eq. (6)-(8)"
CLAUSE_ACCEL = "JJF 2003-2022, 7.2.4.2 eq. (9)-(11)"
READINGS = ("jjf2003.positions", "jjf2003.input_matrix")
TRIADS_ZH = {"gyro": "陀螺", "accel": "加速度计"}

Elements = dict[str, Measured]


def tumble_items(
    recording: Recording, evidence: Evidence, gyro_k: np.ndarray, evaluation: Evaluation
) -> Part:
    """All items of the twelve positions.

    gyro_k: (3, 3) scales Earth's rotation, NaN where it is not known.
    """
    gyro = usable_positions(evidence, lambda segment: segment.has_gyro)
    accel = usable_positions(evidence, lambda segment: segment.has_accel)
    return joined(
        (
            Part(remarks=tuple(position_remarks(evidence))),
            _gyro_part(recording, evidence, gyro, gyro_k, evaluation),
            _accel_part(recording, evidence, accel, evaluation),
        )
    )


def _gyro_part(
    recording: Recording,
    evidence: Evidence,
    positions: dict[str, tuple[int, ...]],
    gyro_k: np.ndarray,
    evaluation: Evaluation,
) -> Part:
    if not positions:
        matrix, bias = _nothing()
        items = _gyro_items(evaluation, matrix, bias)
        return Part(items, dict.fromkeys(items, _no_rest("gyro")))
    twelve = twelve_positions(evidence, positions, 0)
    k = np.where(np.isfinite(gyro_k), gyro_k, np.eye(3)).diagonal()
    matrix, bias = _gyro_elements(twelve, k, evaluation)
    still, why_not = without_earth(recording, evidence, positions, matrix, gyro_k, evaluation)
    items = _gyro_items(evaluation, matrix, bias, still)
    unavailable = _undetermined(items, positions)
    if why_not:
        before = unavailable.get("gyro_g_sensitivity")
        unavailable["gyro_g_sensitivity"] = _both_reasons(before, why_not)
    remarks = (*earth_remarks(recording, evidence, gyro_k), *_scatter_remarks(0, twelve.factors))
    return Part(items, unavailable, remarks)


def _gyro_elements(
    twelve: Twelve, k: np.ndarray, evaluation: Evaluation
) -> tuple[Elements, Elements]:
    """g-sensitivity (rad/s per g) and bias (rad/s) with their budgets' lines; k: (3,) K_ii."""
    matrix, bias = _nothing()
    for i, j in MATRIX:
        weights, across = twelve.weights(j), twelve.across(i, j)
        lines = type_b.gyro_g_sensitivity(evaluation.equipment, weights, k[i], across)
        matrix[AXES[i] + AXES[j]] = twelve.found[i][j].with_lines(*lines)
    for i, axis in enumerate(AXES):
        lines = type_b.gyro_bias(evaluation.equipment, twelve.weights(3), k[i])
        bias[axis] = twelve.found[i][3].with_lines(*lines)
    return matrix, bias


def _gyro_items(
    evaluation: Evaluation, matrix: Elements, bias: Elements, still: Elements | None = None
) -> dict[str, Item]:
    """g-sensitivity in (deg/s)/g and bias in deg/s from eq. (8); still: without Earth's rate."""
    name, unit = "gyro_g_sensitivity", "(deg/s)/g"
    readings = (*READINGS, "jjf2003.g_earth")
    item = make_item(evaluation, name, _scaled(matrix, DEG), unit, CLAUSE_GYRO, readings)
    less = make_item(
        evaluation, name, _scaled(still or _nothing()[0], DEG), unit, CLAUSE_GYRO, readings
    )
    return {
        "gyro_bias": make_item(
            evaluation, "gyro_bias", _scaled(bias, DEG), "deg/s", CLAUSE_GYRO, READINGS
        ),
        name: item.model_copy(
            update={
                "value_without_earth_rotation": less.value,
                "u_without_earth_rotation": less.u,
                "U_without_earth_rotation": {
                    e: None if u is None else item.k * u for e, u in less.u.items()
                },
            }
        ),
    }


def _accel_part(
    recording: Recording,
    evidence: Evidence,
    positions: dict[str, tuple[int, ...]],
    evaluation: Evaluation,
) -> Part:
    gravity = recording.manifest.station.gravity_m_s2
    if not positions:
        items = _accel_items(evaluation, *_nothing())
        return Part(items, dict.fromkeys(items, _no_rest("accel")))
    tilt = type_b.tilt_of_a_face(evaluation.equipment, evidence.mounted_once)
    tilts = (gravity or 0.0) ** 2 * tilt
    twelve = twelve_positions(evidence, positions, 3, tilts)
    items = _accel_items(evaluation, *_accel_elements(twelve, gravity, evaluation))
    unavailable = _undetermined(items, positions)
    if gravity is None:
        why = ("the local gravity is not told", "未给出当地重力加速度")
        for name in ("accel_scale_factor", "accel_cross_coupling"):
            unavailable[name] = _both_reasons(unavailable.get(name), why)
    return Part(items, unavailable, _scatter_remarks(3, twelve.factors))


def _accel_elements(
    twelve: Twelve, gravity: float | None, evaluation: Evaluation
) -> tuple[Elements, Elements]:
    """K (ratio to local gravity) and bias (m/s²) with their budgets' lines, eq. (11).

    Without a gravity the bias stands, with what the accelerometer reads of it for the
    sensitivity to a tilt.
    """
    equipment = evaluation.equipment
    matrix, bias = _nothing()
    reads = [abs(twelve.found[i][i].value) for i in range(3)]  # K_ii·g, m/s²
    for i, axis in enumerate(AXES):
        level = reads[i] if np.isfinite(reads[i]) else NOMINAL_GRAVITY
        lines = type_b.accel_bias(equipment, twelve.weights(3, lying=axis), 1.0, level)
        bias[axis] = twelve.found[i][3].with_lines(*lines)
    if gravity is None:
        return matrix, bias
    for i, j in MATRIX:
        found, weights = twelve.found[i][j].scaled(1.0 / gravity), twelve.weights(j)
        if i == j:
            across = twelve.across(i, j) / gravity
            lines = type_b.accel_scale_factor(equipment, weights, found.value, gravity, across)
        else:
            k = reads[i] / gravity if np.isfinite(reads[i]) else 1.0
            lines = type_b.accel_cross_coupling(equipment, weights, k, found.value, gravity)
        alone = Measured(found.value, found.lines)  # A.1 and A.4 add nothing up
        matrix[AXES[i] + AXES[j]] = alone.with_lines(*lines)
    return matrix, bias


def _accel_items(evaluation: Evaluation, matrix: Elements, bias: Elements) -> dict[str, Item]:
    """Scale factor and cross coupling (ratio to local gravity) and bias (m/s²), eq. (11)."""
    diagonal: Elements = {axis: matrix[axis + axis] for axis in AXES}
    coupling = {AXES[i] + AXES[j]: matrix[AXES[i] + AXES[j]] for i, j in OFF_DIAGONAL}
    name, cross = "accel_scale_factor", "accel_cross_coupling"
    azx = (*READINGS, "jjf2003.k_azx")
    return {
        name: make_item(evaluation, name, diagonal, "1", CLAUSE_ACCEL, READINGS),
        cross: make_item(evaluation, cross, coupling, "1", CLAUSE_ACCEL, azx),
        "accel_bias": make_item(evaluation, "accel_bias", bias, "m/s2", CLAUSE_ACCEL, READINGS),
    }


def _nothing() -> tuple[Elements, Elements]:
    """A matrix and a bias of which no element is determined."""
    matrix = {AXES[i] + AXES[j]: UNDETERMINED for i, j in MATRIX}
    bias: Elements = dict.fromkeys(AXES, UNDETERMINED)
    return matrix, bias


def _scaled(found: Elements, factor: float) -> Elements:
    return {element: each.scaled(factor) for element, each in found.items()}


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
        blocks_pass=bool(factors.max() > BLOCKING_EXCESS),
    )
    return (remark,)
