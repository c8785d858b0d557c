"""The joint method on a recording whose attitudes and rates are known: items and remarks."""

from collections.abc import Mapping

from schemas.calibration import Item
from schemas.recording import AXES, Recording
from tasks.specifications.evaluation import Evaluation, make_item
from tasks.specifications.evidence import UPS, Evidence
from tasks.specifications.jjf2003.positions import position_remarks
from tasks.specifications.joint.claims import claim_remarks
from tasks.specifications.joint.reasons import level_unknown, table_reasons
from tasks.specifications.joint.remarks import earth_remarks, scatter_remarks
from tasks.specifications.joint.solution import Joint, solve_jointly
from tasks.specifications.joint.stretches import Stretches, stretches
from tasks.specifications.measured import UNDETERMINED, Measured
from tasks.specifications.parts import DEG, OFF_DIAGONAL, Part

GYRO_CLAUSE = "JJF 2003-2022, 5.1 eq. (1), joint method"
ACCEL_CLAUSE = "JJF 2003-2022, 5.2 eq. (2), joint method"
READINGS = ("joint.method",)
COUPLINGS = tuple(AXES[i] + AXES[j] for i, j in OFF_DIAGONAL)

Elements = dict[str, Measured]


def joint_on_table(recording: Recording, evidence: Evidence, evaluation: Evaluation) -> Part:
    """Every item that the segments of a recording determine, by the joint method."""
    taken = stretches(recording, evidence)
    joint = solve_jointly(recording, evidence, taken, evaluation.equipment)
    items = {
        **_gyro_items(recording, joint, taken, evidence, evaluation),
        **_accel_items(recording, joint, evaluation),
    }
    remarks = (
        *position_remarks(evidence),
        *claim_remarks(evidence),
        *earth_remarks(recording, joint, taken),
        *scatter_remarks(joint),
    )
    return Part(items, table_reasons(recording, items, taken, evidence), remarks)


def _gyro_items(
    recording: Recording,
    joint: Joint,
    taken: Stretches,
    evidence: Evidence,
    evaluation: Evaluation,
) -> dict[str, Item]:
    diagonal, couplings = _split(joint.found["gyro_matrix"])
    sensitivity = joint.found["gyro_g_sensitivity"]
    told = recording.manifest.station.latitude_deg is not None
    if told:
        unknown = {UPS[k][1] for k in range(len(UPS)) if level_unknown(taken, evidence, UPS[k])}
        sensitivity = {
            e: UNDETERMINED if e[0] != e[1] and e[1] in unknown else found
            for e, found in sensitivity.items()
        }
    item = make_item(
        evaluation, "gyro_g_sensitivity", _scaled(sensitivity, DEG), "(deg/s)/g", GYRO_CLAUSE,
        (*READINGS, "joint.g_earth"),
    )  # fmt: skip
    nothing = dict.fromkeys(item.value)
    still = {
        "value_without_earth_rotation": item.value if told else nothing,
        "u_without_earth_rotation": item.u if told else nothing,
        "U_without_earth_rotation": item.U if told else nothing,
    }
    return {
        "gyro_scale_factor": make_item(
            evaluation, "gyro_scale_factor", diagonal, "1", GYRO_CLAUSE, READINGS
        ),
        "gyro_cross_coupling": make_item(
            evaluation, "gyro_cross_coupling", couplings, "1", GYRO_CLAUSE, READINGS
        ),
        "gyro_fit_offset": make_item(
            evaluation, "gyro_fit_offset", _scaled(joint.offset, DEG), "deg/s", GYRO_CLAUSE,
            (*READINGS, "joint.fit_offset"),
        ),
        "gyro_bias": make_item(
            evaluation, "gyro_bias", _scaled(joint.found["gyro_bias"], DEG), "deg/s",
            GYRO_CLAUSE, READINGS,
        ),
        "gyro_g_sensitivity": item.model_copy(update=still),
    }  # fmt: skip


def _accel_items(recording: Recording, joint: Joint, evaluation: Evaluation) -> dict[str, Item]:
    diagonal, couplings = _split(joint.found["accel_matrix"])
    if recording.manifest.station.gravity_m_s2 is None:
        diagonal, couplings = (
            dict.fromkeys(AXES, UNDETERMINED),
            dict.fromkeys(COUPLINGS, UNDETERMINED),
        )
    by_model = joint.found["accel_rate_sensitivity"]
    rate_item = make_item(
        evaluation, "accel_rate_sensitivity", _scaled(by_model, -1.0), "m", ACCEL_CLAUSE,
        (*READINGS, "jjf2003.p_sign", "jjf2003.p_lever_arm", "jjf2003.p_unit"),
    )  # fmt: skip
    model = {e: None if v is None else -v for e, v in rate_item.value.items()}
    return {
        "accel_scale_factor": make_item(
            evaluation, "accel_scale_factor", diagonal, "1", ACCEL_CLAUSE, READINGS
        ),
        "accel_cross_coupling": make_item(
            evaluation, "accel_cross_coupling", couplings, "1", ACCEL_CLAUSE, READINGS
        ),
        "accel_bias": make_item(
            evaluation, "accel_bias", joint.found["accel_bias"], "m/s2", ACCEL_CLAUSE, READINGS
        ),
        "accel_rate_sensitivity": rate_item.model_copy(update={"value_model": model}),
    }


def _split(matrix: Elements) -> tuple[Elements, Elements]:
    """Scale factors by axis, and cross couplings."""
    return (
        {axis: matrix[axis * 2] for axis in AXES},
        {element: matrix[element] for element in COUPLINGS},
    )


def _scaled(found: Mapping[str, Measured], factor: float) -> Elements:
    return {element: each.scaled(factor) for element, each in found.items()}
