"""JJF 2003-2022, clause 7: every item that a recording allows, clause by clause."""

from functools import partial

from schemas.base import Unusable
from schemas.recording import ACCEL, GYRO, Recording
from tasks.segments.conditions import Conditions
from tasks.specifications.estimate import ClauseResult, merged
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.gather import gather
from tasks.specifications.items import MIMU_ITEMS
from tasks.specifications.jjf2003.rate_sensitivity import rate_sensitivity_item
from tasks.specifications.jjf2003.tumble import tumble_items
from tasks.specifications.jjf2003.turning import gyro_matrix, turning_items
from tasks.specifications.specification import Section, Specification
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
    turning = turning_items(evidence, equipment)
    return merged(
        (
            turning,
            tumble_items(evidence, gyro_matrix(turning), equipment),
            rate_sensitivity_item(evidence, equipment),
        )
    )


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
