"""JJF 2003-2022, clause 7: every item that a recording allows."""

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.recording import ACCEL, GYRO, Recording
from tasks.segments.conditions import Conditions
from tasks.specifications.assemble import assemble
from tasks.specifications.evaluation import Evaluation, evaluation_for
from tasks.specifications.evidence import gather
from tasks.specifications.jjf2003.rate_sensitivity import rate_sensitivity_item
from tasks.specifications.jjf2003.tumble import tumble_items
from tasks.specifications.jjf2003.turning import gyro_matrix, turning_items
from tasks.specifications.parts import NOMINAL_GRAVITY, joined

PROCEDURE = "JJF 2003-2022, 7.2"
CONDITIONS = Conditions(
    dwell_s=30.0,
    dwell_clause="7.2",
    steadiness=5e-4,
    steadiness_clause="7.2.1.1 d)",
    temperature_degc=(15.0, 25.0),
    humidity_percent=(20.0, 85.0),
    room_clause="6.1",
)
ORDER = (
    "gyro_scale_factor",
    "gyro_cross_coupling",
    "gyro_fit_offset",
    "gyro_bias",
    "gyro_g_sensitivity",
    "accel_scale_factor",
    "accel_cross_coupling",
    "accel_bias",
    "accel_rate_sensitivity",
)


def calibrate(
    recording: Recording, *, run: str, code_version: str, evaluation: Evaluation | None = None
) -> Calibration:
    """Estimate the eight items of JJF 2003-2022 (Table 2) and the fit offset of eq. (4).

    evaluation: of the uncertainties; by the law of propagation with the limits of the recording's
    specification where it is not given.
    Raises Unusable where the recording holds neither gyro nor accelerometer readings.
    """
    if not any(name in recording.imu.columns for name in GYRO + ACCEL):
        raise Unusable(
            f"{recording.manifest.recording_id}: there are no gyro_* or accel_* columns, which JJF "
            "2003 calibrates; a recording of accumulated angles belongs to JJF 1536"
        )
    evaluation = evaluation or evaluation_for(recording)
    evidence = gather(recording)
    gravity = recording.manifest.station.gravity_m_s2 or NOMINAL_GRAVITY
    turning = turning_items(recording, evidence, evaluation)
    tumble = tumble_items(recording, evidence, gyro_matrix(turning), evaluation)
    return assemble(
        recording,
        evidence,
        joined((turning, tumble, rate_sensitivity_item(evidence, gravity, evaluation))),
        method="jjf2003",
        procedure=PROCEDURE,
        order=ORDER,
        conditions=CONDITIONS,
        evaluation=evaluation,
        run=run,
        code_version=code_version,
    )
