"""JJF 2003-2022, clause 7: every item that a recording allows, clause by clause."""

from collections.abc import Mapping
from functools import partial

from schemas.base import Unusable
from schemas.recording import ACCEL, GYRO, Recording
from tasks.segments.find import Conditions
from tasks.specifications.course import course_remarks, with_course
from tasks.specifications.estimate import (
    DEG,
    MIMU_ITEMS,
    ClauseResult,
    Estimates,
    ItemEstimate,
    Section,
    Specification,
    merged,
    scaled,
    with_equipment,
)
from tasks.specifications.evidence import ClauseEvidence, gather
from tasks.specifications.jjf2003.positions import tumble_items
from tasks.specifications.jjf2003.turning import gyro_matrix, rate_sensitivity_item, turning_items
from tasks.specifications.unit_model import doubled, errors_of_unit, mean_motion
from tasks.uncertainty.equipment import JJF2003 as EQUIPMENT
from tasks.uncertainty.equipment import Equipment

CONDITIONS = Conditions(
    dwell_s=30.0,
    dwell_clause="7.2",
    steadiness=5e-4,
    steadiness_clause="7.2.1.1 d)",
    temperature_degc=(15.0, 25.0),
    humidity_percent=(20.0, 85.0),
    environment_clause="6.1",
)
TABLE_2 = (
    "gyro_scale_factor", "gyro_bias", "gyro_g_sensitivity", "gyro_cross_coupling",
    "accel_bias", "accel_scale_factor", "accel_cross_coupling", "accel_rate_sensitivity",
)  # fmt: skip
LAYOUT = (  # Appendix B
    Section("scale-factors", ("gyro_scale_factor", "accel_scale_factor", "gyro_fit_offset")),
    Section("biases", ("gyro_bias", "accel_bias")),
    Section("gyro-cross-coupling", ("gyro_cross_coupling",)),
    Section("accel-cross-coupling", ("accel_cross_coupling",)),
    Section("gyro-g-sensitivity", ("gyro_g_sensitivity",)),
    Section("accel-rate-sensitivity", ("accel_rate_sensitivity",)),
)


def check_imu_columns(recording: Recording, use: str) -> None:
    """Raises Unusable where the recording holds neither gyro nor accelerometer readings.

    use: who needs the columns, and the way out.
    """
    if not any(name in recording.imu.columns for name in GYRO + ACCEL):
        raise Unusable(
            f"{recording.manifest.recording_id}: there are no gyro_* or accel_* columns, which "
            f"{use}"
        )


def estimate(evidence: ClauseEvidence, equipment: Equipment) -> ClauseResult:
    """The eight items of Table 2 and the fit offset of eq. (4)."""
    motion, _ = mean_motion(evidence)
    ideal = errors_of_unit(evidence, motion, equipment)
    evidence = with_course(evidence, motion, ideal)
    turning = turning_items(evidence, motion.rate, ideal)
    result = merged(
        (
            turning,
            tumble_items(evidence, motion.up, gyro_matrix(turning), ideal),
            rate_sensitivity_item(evidence, motion.rate),
            ClauseResult(remarks=tuple(course_remarks(evidence))),
        )
    )
    errors = errors_of_unit(evidence, motion, equipment, _as_terms(result.items))
    return with_equipment(result, errors)


def _as_terms(items: Mapping[str, ItemEstimate]) -> dict[str, Estimates]:
    """What the items say of models (1) and (2), by term, in SI units."""
    of = {key: item.elements for key, item in items.items()}
    sensitivity = items["gyro_g_sensitivity"].without_earth_rotation or {}
    return {
        "gyro_matrix": doubled(of["gyro_scale_factor"]) | of["gyro_cross_coupling"],
        "gyro_bias": scaled(of["gyro_bias"], 1.0 / DEG),
        "gyro_g_sensitivity": scaled(sensitivity, 1.0 / DEG),
        "accel_matrix": doubled(of["accel_scale_factor"]) | of["accel_cross_coupling"],
        "accel_bias": of["accel_bias"],
        "accel_rate_sensitivity": scaled(of["accel_rate_sensitivity"], -1.0),
    }


JJF2003 = Specification(
    method="jjf2003",
    standard="JJF 2003-2022",
    procedure="JJF 2003-2022, 7.2",
    items=MIMU_ITEMS,
    required=TABLE_2,
    conditions=CONDITIONS,
    interval_months=12,
    layout=LAYOUT,
    equipment=EQUIPMENT,
    equipment_source="JJF 2003-2022, Table 1",
    check=partial(
        check_imu_columns,
        use="JJF 2003 calibrates; a recording of accumulated angles belongs to JJF 1536",
    ),
    gather=gather,
    estimate=estimate,
)
