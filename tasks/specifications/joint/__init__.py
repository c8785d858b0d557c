"""The joint method (patent, claims 1 to 4): one fit over all dynamic and static samples."""

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.recording import ACCEL, GYRO, Recording
from tasks.motion.whole import attitude_recorded
from tasks.specifications.assemble import assemble
from tasks.specifications.evaluation import Evaluation, evaluation_for
from tasks.specifications.evidence import gather
from tasks.specifications.jjf2003 import CONDITIONS, ORDER
from tasks.specifications.joint.by_hand import joint_by_hand
from tasks.specifications.joint.on_table import joint_on_table

PROCEDURE = "JJF 2003-2022, 5.1, 5.2, joint least squares with zero correction"


def calibrate(
    recording: Recording, *, run: str, code_version: str, evaluation: Evaluation | None = None
) -> Calibration:
    """Estimate the items of JJF 2003-2022 by fitting models (1) and (2) to everything at once.

    evaluation: of the uncertainties; by the law of propagation with the limits of the recording's
    specification where it is not given.
    Raises Unusable where the recording holds no gyro or accelerometer readings.
    """
    if not any(name in recording.imu.columns for name in GYRO + ACCEL):
        raise Unusable(
            f"{recording.manifest.recording_id}: there are no gyro_* or accel_* columns, which the "
            "joint method fits; calibrate a recording of accumulated angles with --method jjf1536"
        )
    evaluation = evaluation or evaluation_for(recording)
    evidence = gather(recording)
    by_hand = not recording.manifest.segments and not attitude_recorded(recording)
    return assemble(
        recording,
        evidence,
        (joint_by_hand if by_hand else joint_on_table)(recording, evidence, evaluation),
        method="joint",
        procedure=PROCEDURE,
        order=ORDER,
        conditions=CONDITIONS,
        evaluation=evaluation,
        run=run,
        code_version=code_version,
    )
