"""The joint method with gravity as the only reference: rests by hand, at any attitude."""

import numpy as np

from schemas.recording import AXES
from tasks.motion.table import EARTH_RATE
from tasks.segments.summarise import ACCEL_COLUMNS
from tasks.specifications.estimate import (
    DEG,
    MATRIX,
    OFF_DIAGONAL,
    UNDETERMINED,
    ClauseResult,
    Estimate,
    Estimates,
    ItemEstimate,
    diagonal,
    linear_estimate,
    off_diagonal,
    scaled,
    undetermined_matrix,
    undetermined_vector,
)
from tasks.specifications.evidence import Evidence
from tasks.specifications.joint.gravity_fit import UPPER, GravityFit, fit_gravity
from tasks.specifications.joint.moves import MovesFit, fit_moves, gather_moves
from tasks.specifications.joint.reasons import gravity_reasons
from tasks.specifications.joint.remarks import gravity_remarks
from tasks.specifications.joint.zero_correction import least_squares
from tasks.uncertainty.budget import Contribution, observed
from tasks.uncertainty.equipment import Equipment

ACCEL_CLAUSE = "JJF 2003-2022, 5.2 eq. (2), joint method with gravity alone"
GYRO_CLAUSE = "JJF 2003-2022, 5.1 eq. (1), joint method with gravity alone"
METHOD, MOVES = "joint.gravity_alone", "joint.gravity_moves"


def joint_by_gravity(evidence: Evidence, equipment: Equipment) -> ClauseResult:
    """Every item that rests at unknown attitudes, and the moves between them, determine."""
    gravity = evidence.gravity
    rests = [i for i in evidence.of_kind("static") if evidence.segments[i].has_accel]
    fitted = None
    if gravity is not None:
        noise = np.array([evidence.covariance(c)[np.ix_(rests, rests)] for c in range(3, 6)])
        fitted = fit_gravity(evidence.means[rests, ACCEL_COLUMNS], gravity, noise)
    bias, sensitivity = undetermined_vector(), undetermined_matrix()
    matrix, moved = undetermined_matrix(), None
    if fitted is not None and gravity is not None:
        up = fitted.felt / np.linalg.norm(fitted.felt, axis=1)[:, None]
        segments = [evidence.segments[i] for i in rests]
        if all(segment.has_gyro for segment in segments):
            moved = fit_moves(gather_moves(evidence.recording.imu, segments, up))
            matrix = matrix if moved is None else _of_moves(moved)
            k = np.eye(3) if moved is None else moved.matrix
            bias, sensitivity = _zero(evidence, rests, up, k)
    items = {
        **_gyro_items(evidence, matrix, bias, sensitivity),
        **_accel_items(equipment, evidence, rests, fitted),
    }
    reasons = gravity_reasons(evidence, items, fitted is not None, len(rests))
    return ClauseResult(items, reasons, tuple(gravity_remarks(evidence, fitted, moved)))


def _zero(
    evidence: Evidence, rests: list[int], up: np.ndarray, k: np.ndarray
) -> tuple[Estimates, Estimates]:
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
    bias, sensitivity = undetermined_vector(), undetermined_matrix()
    for i, axis in enumerate(AXES):
        solved = least_squares(design, used, evidence.means[:, i], evidence.covariance(i))
        found = [linear_estimate(evidence, i, row, solved.excess[0]) for row in solved.operator]
        bias[axis] = found[0]
        for j, other in enumerate(AXES):
            seen = found[1 + j]
            sensitivity[axis + other] = Estimate(seen.value - k[i, j] * earth, seen.lines)
    return bias, sensitivity


def _of_moves(moved: MovesFit) -> Estimates:
    return {
        AXES[i] + AXES[j]: Estimate(
            float(moved.matrix[i, j]), (observed(float(moved.u[i, j]), "", moved.dof),)
        )
        for i, j in MATRIX
    }


def _accel_items(
    equipment: Equipment, evidence: Evidence, rests: list[int], fitted: GravityFit | None
) -> dict[str, ItemEstimate]:
    bias, matrix = undetermined_vector(), undetermined_matrix()
    if fitted is not None:
        values = [*(fitted.matrix[i, j] for i, j in UPPER), *fitted.bias]
        found = [
            _parameter(equipment, evidence, rests, fitted, p, float(v))
            for p, v in enumerate(values)
        ]
        matrix |= {AXES[i] + AXES[j]: found[p] for p, (i, j) in enumerate(UPPER)}
        bias = dict(zip(AXES, found[len(UPPER) :], strict=True))
    every = {
        "accel_scale_factor": diagonal(matrix),
        "accel_cross_coupling": off_diagonal(matrix),
        "accel_bias": bias,
        "accel_rate_sensitivity": {AXES[i] + AXES[j]: UNDETERMINED for i, j in OFF_DIAGONAL},
    }
    return {key: ItemEstimate(found, ACCEL_CLAUSE, (METHOD,)) for key, found in every.items()}


def _parameter(
    equipment: Equipment,
    evidence: Evidence,
    rests: list[int],
    fitted: GravityFit,
    p: int,
    value: float,
) -> Estimate:
    """One accelerometer parameter with its lines: scatter of the rests, and gravity."""
    block = np.ix_(rests, rests)
    variance = sum(
        float(o @ evidence.covariance(3 + c)[block] @ o) for c, o in enumerate(fitted.operator[p].T)
    )
    u = fitted.excess.factor * float(np.sqrt(variance))
    gravity = Contribution(equipment.gravity.quantity(), float(fitted.by_gravity[p]))
    return Estimate(value, (observed(u, "", fitted.excess.dof), gravity))


def _gyro_items(
    evidence: Evidence, matrix: Estimates, bias: Estimates, sensitivity: Estimates
) -> dict[str, ItemEstimate]:
    by_rests = scaled(sensitivity, DEG)
    without_earth = undetermined_matrix() if evidence.latitude_deg is None else by_rests
    return {
        "gyro_scale_factor": ItemEstimate(diagonal(matrix), GYRO_CLAUSE, (MOVES,)),
        "gyro_cross_coupling": ItemEstimate(off_diagonal(matrix), GYRO_CLAUSE, (MOVES,)),
        "gyro_fit_offset": ItemEstimate(undetermined_vector(), GYRO_CLAUSE, (METHOD,)),
        "gyro_bias": ItemEstimate(scaled(bias, DEG), GYRO_CLAUSE, (METHOD,)),
        "gyro_g_sensitivity": ItemEstimate(by_rests, GYRO_CLAUSE, (METHOD,), without_earth),
    }
