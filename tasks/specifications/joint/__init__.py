"""The joint method (patent, claims 1 to 4): one fit over all dynamic and static samples."""

from dataclasses import replace
from functools import partial

import numpy as np

from schemas.recording import AXES, UPS
from tasks.motion.table import EARTH_RATE
from tasks.motion.whole import attitude_stream
from tasks.segments.summarise import ACCEL_COLUMNS
from tasks.specifications.estimate import (
    MATRIX,
    MATRIX_ELEMENTS,
    MIMU_ITEMS,
    OFF_DIAGONAL_ELEMENTS,
    UNDETERMINED,
    ClauseResult,
    Estimate,
    Estimates,
    ItemEstimate,
    excess_remarks,
    linear_estimate,
    undetermined,
)
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.jjf2003 import JJF2003, check_imu_columns
from tasks.specifications.jjf2003.positions import position_remarks
from tasks.specifications.joint.moves import (
    UPPER,
    GravityFit,
    MovesFit,
    fit_gravity,
    fit_moves,
    gather_moves,
)
from tasks.specifications.joint.remarks import (
    earth_remarks,
    gravity_reasons,
    gravity_remarks,
    joint_items,
    level_unknown,
    procedure_remarks,
    table_reasons,
)
from tasks.specifications.joint.solution import (
    Joint,
    SegmentMotion,
    least_squares,
    segment_motion,
    solve_jointly,
)
from tasks.uncertainty.budget import Contribution, observed
from tasks.uncertainty.equipment import Equipment

# The joint method with gravity as the only reference: rests by hand, at any attitude.

GRAVITY_METHOD = "joint method with gravity alone"
GRAVITY_READINGS = {item.key: ("joint.gravity_alone",) for item in MIMU_ITEMS} | dict.fromkeys(
    ("gyro_scale_factor", "gyro_cross_coupling"), ("joint.gravity_moves",)
)
NOTHING_DETERMINED = {
    "gyro_matrix": undetermined(MATRIX_ELEMENTS),
    "gyro_fit_offset": undetermined(AXES),
    "gyro_bias": undetermined(AXES),
    "gyro_g_sensitivity": undetermined(MATRIX_ELEMENTS),
    "accel_matrix": undetermined(MATRIX_ELEMENTS),
    "accel_bias": undetermined(AXES),
    "accel_rate_sensitivity": undetermined(OFF_DIAGONAL_ELEMENTS),
}


def joint_by_gravity(evidence: ClauseEvidence, equipment: Equipment) -> ClauseResult:
    """Every item that rests at unknown attitudes, and the moves between them, determine."""
    rests = [i for i in evidence.of_kind("static") if evidence.segments[i].has_accel]
    parameters, fitted, moved = dict(NOTHING_DETERMINED), None, None
    if evidence.gravity is not None:
        noise = np.array([evidence.covariance(c)[np.ix_(rests, rests)] for c in range(3, 6)])
        fitted = fit_gravity(evidence.means[rests, ACCEL_COLUMNS], evidence.gravity, noise)
    if fitted is not None:
        parameters |= _accelerometers(equipment, evidence, rests, fitted)
        up = fitted.felt / np.linalg.norm(fitted.felt, axis=1)[:, None]
        segments = [evidence.segments[i] for i in rests]
        if all(segment.has_gyro for segment in segments):
            moved = fit_moves(gather_moves(evidence.recording.imu, segments, up))
            if moved is not None:
                parameters["gyro_matrix"] = _of_moves(moved)
            k = np.eye(3) if moved is None else moved.matrix
            parameters |= _zero(evidence, rests, up, k)
    items = joint_items(evidence, parameters, GRAVITY_METHOD, GRAVITY_READINGS)
    reasons = gravity_reasons(evidence, items, fitted is not None, len(rests))
    return ClauseResult(items, reasons, tuple(gravity_remarks(evidence, fitted, moved)))


def _zero(
    evidence: ClauseEvidence, rests: list[int], up: np.ndarray, k: np.ndarray
) -> dict[str, Estimates]:
    """Gyro bias (rad/s) and g-sensitivity (rad/s per g) from the rests: the zero correction.

    up: (rests, 3) verticals in the body; k: (3, 3) reads the vertical part of Earth's rotation.
    """
    latitude = evidence.latitude_deg
    used = np.zeros(len(evidence.segments), bool)
    used[rests] = True
    design = np.zeros((len(used), 4))
    design[:, 0] = 1.0
    design[rests, 1:] = up
    earth = 0.0 if latitude is None else EARTH_RATE * np.sin(np.radians(latitude))
    bias, sensitivity = Estimates(), Estimates()
    for i, axis in enumerate(AXES):
        solved = least_squares(design, used, evidence.means[:, i], evidence.covariance(i))
        bias[axis], *by_gravity = (
            linear_estimate(evidence, i, row, solved.excess[0]) for row in solved.operator
        )
        for j, estimate in enumerate(by_gravity):
            value = estimate.value - k[i, j] * earth
            sensitivity[axis + AXES[j]] = Estimate(value, estimate.lines)
    return {"gyro_bias": bias, "gyro_g_sensitivity": sensitivity}


def _of_moves(moved: MovesFit) -> Estimates:
    return {
        AXES[i] + AXES[j]: Estimate(
            float(moved.matrix[i, j]), (observed(float(moved.u[i, j]), "", moved.dof),)
        )
        for i, j in MATRIX
    }


def _accelerometers(
    equipment: Equipment, evidence: ClauseEvidence, rests: list[int], fitted: GravityFit
) -> dict[str, Estimates]:
    """Matrix and bias (m/s²), their lines the scatter of the rests, and gravity."""
    values = [*(fitted.matrix[i, j] for i, j in UPPER), *fitted.bias]
    block = np.ix_(rests, rests)
    covariances = [evidence.covariance(channel)[block] for channel in range(3, 6)]
    estimates = []
    for value, follow, by_gravity in zip(values, fitted.operator, fitted.by_gravity, strict=True):
        variance = sum(float(o @ c @ o) for o, c in zip(follow.T, covariances, strict=True))
        u = fitted.excess.factor * float(np.sqrt(variance))
        gravity = Contribution(equipment.gravity.quantity, float(by_gravity))
        estimates.append(Estimate(float(value), (observed(u, "", fitted.excess.dof), gravity)))
    upper = {AXES[i] + AXES[j]: estimates[p] for p, (i, j) in enumerate(UPPER)}
    return {
        "accel_matrix": undetermined(MATRIX_ELEMENTS) | upper,
        "accel_bias": dict(zip(AXES, estimates[len(UPPER) :], strict=True)),
    }


# The joint method for a recording with known attitudes and rates: items and remarks.

TABLE_METHOD = "joint method"
TABLE_READINGS = {item.key: ("joint.method",) for item in MIMU_ITEMS} | {
    "gyro_fit_offset": ("joint.method", "joint.fit_offset"),
    "gyro_g_sensitivity": ("joint.method", "joint.g_earth"),
    "accel_rate_sensitivity": (
        "joint.method", "jjf2003.p_sign", "jjf2003.p_lever_arm", "jjf2003.p_unit",
    ),
}  # fmt: skip


def joint_on_table(evidence: ClauseEvidence, equipment: Equipment) -> ClauseResult:
    """Every item that the segments of a recording determine, by the joint method."""
    motion = segment_motion(evidence)
    joint = solve_jointly(evidence, motion, equipment)
    items = _items(joint, motion, evidence)
    remarks = (
        *position_remarks(evidence),
        *procedure_remarks(evidence),
        *earth_remarks(evidence, joint, motion),
        *joint.remarks,
        *excess_remarks("joint-scatter", joint.excess.tolist()),
    )
    return ClauseResult(items, table_reasons(items, motion, evidence), remarks, joint.errors)


def _items(
    joint: Joint, motion: SegmentMotion, evidence: ClauseEvidence
) -> dict[str, ItemEstimate]:
    """The items, without what the local gravity or the heading would have to be known for."""
    parameters = {**joint.estimates, "gyro_fit_offset": joint.offset}
    if evidence.latitude_deg is not None:
        unknown = {up[1] for up in UPS if level_unknown(motion, evidence, up)}
        parameters["gyro_g_sensitivity"] = {
            e: UNDETERMINED if e[0] != e[1] and e[1] in unknown else estimate
            for e, estimate in parameters["gyro_g_sensitivity"].items()
        }
    if evidence.gravity is None:
        parameters["accel_matrix"] = undetermined(parameters["accel_matrix"])
    return joint_items(evidence, parameters, TABLE_METHOD, TABLE_READINGS)


def estimate(evidence: ClauseEvidence, equipment: Equipment) -> ClauseResult:
    """The items of JJF 2003-2022 by fitting models (1) and (2) to everything at once."""
    recording = evidence.recording
    gravity_alone = not recording.manifest.segments and attitude_stream(recording) is None
    return (joint_by_gravity if gravity_alone else joint_on_table)(evidence, equipment)


JOINT = replace(
    JJF2003,
    method="joint",
    procedure="JJF 2003-2022, 5.1, 5.2, joint least squares with zero correction",
    printed_once=("gyro_g_sensitivity",),  # the fit removes Earth's rotation from it
    check=partial(
        check_imu_columns,
        use="the joint method fits; calibrate a recording of accumulated angles with "
        "--method jjf1536",
    ),
    estimate=estimate,
)
