"""The joint method on a recording whose attitudes and rates are known: items and remarks."""

from tasks.specifications.estimate import (
    DEG,
    UNDETERMINED,
    ClauseResult,
    ItemEstimate,
    diagonal,
    excess_remarks,
    off_diagonal,
    scaled,
    undetermined_matrix,
)
from tasks.specifications.evidence import UPS, Evidence
from tasks.specifications.jjf2003.positions import position_remarks
from tasks.specifications.joint.reasons import level_unknown, table_reasons
from tasks.specifications.joint.remarks import earth_remarks, procedure_remarks
from tasks.specifications.joint.segment_motion import SegmentMotion, segment_motion
from tasks.specifications.joint.solution import Joint, solve_jointly
from tasks.uncertainty.equipment import Equipment

GYRO_CLAUSE = "JJF 2003-2022, 5.1 eq. (1), joint method"
ACCEL_CLAUSE = "JJF 2003-2022, 5.2 eq. (2), joint method"
READINGS = ("joint.method",)


def joint_on_table(evidence: Evidence, equipment: Equipment) -> ClauseResult:
    """Every item that the segments of a recording determine, by the joint method."""
    motion = segment_motion(evidence)
    joint = solve_jointly(evidence, motion, equipment)
    items = {**_gyro_items(joint, motion, evidence), **_accel_items(joint, evidence)}
    remarks = (
        *position_remarks(evidence),
        *procedure_remarks(evidence),
        *earth_remarks(evidence, joint, motion),
        *excess_remarks("joint-scatter", joint.excess.tolist()),
    )
    return ClauseResult(items, table_reasons(items, motion, evidence), remarks)


def _gyro_items(joint: Joint, motion: SegmentMotion, evidence: Evidence) -> dict[str, ItemEstimate]:
    matrix, sensitivity = joint.estimates["gyro_matrix"], joint.estimates["gyro_g_sensitivity"]
    if evidence.latitude_deg is not None:
        unknown = {UPS[k][1] for k in range(len(UPS)) if level_unknown(motion, evidence, UPS[k])}
        sensitivity = {
            e: UNDETERMINED if e[0] != e[1] and e[1] in unknown else estimate
            for e, estimate in sensitivity.items()
        }
    by_rests = scaled(sensitivity, DEG)
    without_earth = undetermined_matrix() if evidence.latitude_deg is None else by_rests
    return {
        "gyro_scale_factor": ItemEstimate(diagonal(matrix), GYRO_CLAUSE, READINGS),
        "gyro_cross_coupling": ItemEstimate(off_diagonal(matrix), GYRO_CLAUSE, READINGS),
        "gyro_fit_offset": ItemEstimate(
            scaled(joint.offset, DEG), GYRO_CLAUSE, (*READINGS, "joint.fit_offset")
        ),
        "gyro_bias": ItemEstimate(scaled(joint.estimates["gyro_bias"], DEG), GYRO_CLAUSE, READINGS),
        "gyro_g_sensitivity": ItemEstimate(
            by_rests, GYRO_CLAUSE, (*READINGS, "joint.g_earth"), without_earth
        ),
    }


def _accel_items(joint: Joint, evidence: Evidence) -> dict[str, ItemEstimate]:
    matrix = joint.estimates["accel_matrix"]
    if evidence.gravity is None:
        matrix = undetermined_matrix()
    by_clause = scaled(joint.estimates["accel_rate_sensitivity"], -1.0)
    p_readings = (*READINGS, "jjf2003.p_sign", "jjf2003.p_lever_arm", "jjf2003.p_unit")
    return {
        "accel_scale_factor": ItemEstimate(diagonal(matrix), ACCEL_CLAUSE, READINGS),
        "accel_cross_coupling": ItemEstimate(off_diagonal(matrix), ACCEL_CLAUSE, READINGS),
        "accel_bias": ItemEstimate(joint.estimates["accel_bias"], ACCEL_CLAUSE, READINGS),
        "accel_rate_sensitivity": ItemEstimate(by_clause, ACCEL_CLAUSE, p_readings),
    }
