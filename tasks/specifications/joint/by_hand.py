"""The joint method with gravity as the only reference: rests by hand, at any attitude."""

from collections.abc import Mapping

import numpy as np

from schemas.calibration import Item
from schemas.recording import AXES, Recording
from tasks.motion.table import EARTH_RATE
from tasks.segments.summarise import ACCEL_COLUMNS
from tasks.specifications.evaluation import Evaluation, make_item
from tasks.specifications.evidence import Evidence
from tasks.specifications.joint.gravity_fit import UPPER, GravityFit, fit_gravity
from tasks.specifications.joint.moves import MovesFit, fit_moves, gather_moves
from tasks.specifications.joint.reasons import hand_reasons
from tasks.specifications.joint.remarks import fit_remarks, hand_earth_remark, reference_remark
from tasks.specifications.joint.zero_correction import least_squares
from tasks.specifications.measured import UNDETERMINED, Measured, measured
from tasks.specifications.parts import DEG, MATRIX, OFF_DIAGONAL, Part
from tasks.uncertainty.budget import Contribution, observed

ACCEL_CLAUSE = "JJF 2003-2022, 5.2 eq. (2), joint method with gravity alone"
GYRO_CLAUSE = "JJF 2003-2022, 5.1 eq. (1), joint method with gravity alone"
METHOD, MOVES = "joint.gravity_alone", "joint.gravity_moves"

Elements = dict[str, Measured]


def joint_by_hand(recording: Recording, evidence: Evidence, evaluation: Evaluation) -> Part:
    """Every item that rests at unknown attitudes, and the moves between them, determine."""
    gravity = recording.manifest.station.gravity_m_s2
    rests = [i for i, s in enumerate(evidence.segments) if s.segment.kind == "static"]
    rests = [i for i in rests if evidence.segments[i].has_accel]
    fitted = None
    if gravity is not None:
        noise = np.array([evidence.covariance(c)[np.ix_(rests, rests)] for c in range(3, 6)])
        fitted = fit_gravity(evidence.means[rests, ACCEL_COLUMNS], gravity, noise)
    bias, sensitivity, matrix = _nothing()
    moved = None
    if fitted is not None and gravity is not None:
        up = fitted.felt / np.linalg.norm(fitted.felt, axis=1)[:, None]
        segments = [evidence.segments[i] for i in rests]
        if all(segment.has_gyro for segment in segments):
            moved = fit_moves(gather_moves(recording.imu, segments, up))
            matrix = matrix if moved is None else _of_moves(moved)
            k = np.eye(3) if moved is None else moved.matrix
            bias, sensitivity = _zero(recording, evidence, rests, up, k)
    items = {
        **_gyro_items(evaluation, matrix, bias, sensitivity, recording),
        **_accel_items(evaluation, evidence, rests, fitted),
    }
    remarks = [
        reference_remark(),
        *fit_remarks(fitted, moved),
        *hand_earth_remark(recording),
    ]
    return Part(
        items, hand_reasons(recording, items, fitted is not None, len(rests)), tuple(remarks)
    )


def _zero(
    recording: Recording, evidence: Evidence, rests: list[int], up: np.ndarray, k: np.ndarray
) -> tuple[Elements, Elements]:
    """Gyro bias (rad/s) and g-sensitivity (rad/s per g) from the rests: the zero correction.

    up: (rests, 3) verticals in the body; k: (3, 3) reads the vertical part of Earth's rotation.
    """
    latitude = recording.manifest.station.latitude_deg
    used = np.zeros(len(evidence.segments), bool)
    used[rests] = True
    design = np.zeros((len(used), 4))
    design[:, 0] = 1.0
    design[rests, 1:] = up
    earth = 0.0 if latitude is None else EARTH_RATE * np.sin(np.radians(latitude))
    bias, sensitivity, _ = _nothing()
    for i, axis in enumerate(AXES):
        solved = least_squares(design, used, evidence.means[:, i], evidence.covariance(i))
        found = [measured(evidence, i, row, solved.excess[0]) for row in solved.operator]
        bias[axis] = found[0]
        for j, other in enumerate(AXES):
            seen = found[1 + j]
            sensitivity[axis + other] = Measured(seen.value - k[i, j] * earth, seen.lines)
    return bias, sensitivity


def _of_moves(moved: MovesFit) -> Elements:
    return {
        AXES[i] + AXES[j]: Measured(
            float(moved.matrix[i, j]), (observed(float(moved.u[i, j]), "", moved.dof),)
        )
        for i, j in MATRIX
    }


def _accel_items(
    evaluation: Evaluation, evidence: Evidence, rests: list[int], fitted: GravityFit | None
) -> dict[str, Item]:
    bias, _, matrix = _nothing()
    if fitted is not None:
        values = [*(fitted.matrix[i, j] for i, j in UPPER), *fitted.bias]
        found = [
            _parameter(evaluation, evidence, rests, fitted, p, float(v))
            for p, v in enumerate(values)
        ]
        matrix |= {AXES[i] + AXES[j]: found[p] for p, (i, j) in enumerate(UPPER)}
        bias = dict(zip(AXES, found[len(UPPER) :], strict=True))
    coupling = {AXES[i] + AXES[j]: matrix[AXES[i] + AXES[j]] for i, j in OFF_DIAGONAL}
    diagonal: Elements = {axis: matrix[axis * 2] for axis in AXES}
    none = dict.fromkeys(coupling, UNDETERMINED)
    every: dict[str, tuple[Elements, str]] = {
        "accel_scale_factor": (diagonal, "1"),
        "accel_cross_coupling": (coupling, "1"),
        "accel_bias": (bias, "m/s2"),
        "accel_rate_sensitivity": (none, "m"),
    }
    items = {
        name: make_item(evaluation, name, found, unit, ACCEL_CLAUSE, (METHOD,))
        for name, (found, unit) in every.items()
    }
    model = {"value_model": dict.fromkeys(none)}
    rate = items["accel_rate_sensitivity"].model_copy(update=model)
    return {**items, "accel_rate_sensitivity": rate}


def _parameter(
    evaluation: Evaluation,
    evidence: Evidence,
    rests: list[int],
    fitted: GravityFit,
    p: int,
    value: float,
) -> Measured:
    """One accelerometer parameter with its lines: scatter of the rests, and gravity."""
    block = np.ix_(rests, rests)
    variance = sum(
        float(o @ evidence.covariance(3 + c)[block] @ o) for c, o in enumerate(fitted.operator[p].T)
    )
    u = fitted.excess.factor * float(np.sqrt(variance))
    gravity = Contribution(evaluation.equipment.gravity.quantity(), float(fitted.by_gravity[p]))
    return Measured(value, (observed(u, "", fitted.excess.dof), gravity))


def _gyro_items(
    evaluation: Evaluation,
    matrix: Elements,
    bias: Elements,
    sensitivity: Elements,
    recording: Recording,
) -> dict[str, Item]:
    diagonal: Elements = {axis: matrix[axis * 2] for axis in AXES}
    coupling = {AXES[i] + AXES[j]: matrix[AXES[i] + AXES[j]] for i, j in OFF_DIAGONAL}
    offset: Elements = dict.fromkeys(AXES, UNDETERMINED)
    every: dict[str, tuple[Elements, str, str]] = {
        "gyro_scale_factor": (diagonal, "1", MOVES),
        "gyro_cross_coupling": (coupling, "1", MOVES),
        "gyro_fit_offset": (offset, "deg/s", METHOD),
        "gyro_bias": (_scaled(bias), "deg/s", METHOD),
        "gyro_g_sensitivity": (_scaled(sensitivity), "(deg/s)/g", METHOD),
    }
    items = {
        name: make_item(evaluation, name, found, unit, GYRO_CLAUSE, (reading,))
        for name, (found, unit, reading) in every.items()
    }
    item = items["gyro_g_sensitivity"]
    told = recording.manifest.station.latitude_deg is not None
    nothing = dict.fromkeys(item.value)
    still = {
        "value_without_earth_rotation": item.value if told else nothing,
        "u_without_earth_rotation": item.u if told else nothing,
        "U_without_earth_rotation": item.U if told else nothing,
    }
    return {**items, "gyro_g_sensitivity": item.model_copy(update=still)}


def _scaled(found: Mapping[str, Measured]) -> Elements:
    return {element: each.scaled(DEG) for element, each in found.items()}


def _nothing() -> tuple[Elements, Elements, Elements]:
    """Bias, g-sensitivity and a matrix of which nothing is determined."""
    matrix = {AXES[i] + AXES[j]: UNDETERMINED for i, j in MATRIX}
    return dict.fromkeys(AXES, UNDETERMINED), dict(matrix), dict(matrix)
