"""The joint method for a recording with known attitudes and rates: items and remarks."""

from schemas.recording import UPS
from tasks.specifications.estimate import (
    UNDETERMINED,
    ClauseResult,
    ItemEstimate,
    excess_remarks,
    undetermined,
)
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.items import MIMU_ITEMS
from tasks.specifications.jjf2003.positions import position_remarks
from tasks.specifications.joint.remarks import (
    earth_remarks,
    joint_items,
    level_unknown,
    procedure_remarks,
    table_reasons,
)
from tasks.specifications.joint.segment_motion import SegmentMotion, segment_motion
from tasks.specifications.joint.solution import Joint, solve_jointly
from tasks.uncertainty.equipment import Equipment

METHOD = "joint method"
READINGS = {item.key: ("joint.method",) for item in MIMU_ITEMS} | {
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
    return joint_items(evidence, parameters, METHOD, READINGS)
