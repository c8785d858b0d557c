"""The joint method (patent, claims 1 to 4): one fit over all dynamic and static samples."""

from dataclasses import replace

from schemas.base import Unusable
from schemas.recording import ACCEL, GYRO, Recording
from tasks.motion.whole import attitude_stream
from tasks.specifications.estimate import ClauseResult
from tasks.specifications.evidence import Evidence
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.joint.by_gravity import joint_by_gravity
from tasks.specifications.joint.on_table import joint_on_table
from tasks.uncertainty.equipment import Equipment


def check(recording: Recording) -> None:
    """Raises Unusable where the recording holds neither gyro nor accelerometer readings."""
    if not any(name in recording.imu.columns for name in GYRO + ACCEL):
        raise Unusable(
            f"{recording.manifest.recording_id}: there are no gyro_* or accel_* columns, which the "
            "joint method fits; calibrate a recording of accumulated angles with --method jjf1536"
        )


def estimate(evidence: Evidence, equipment: Equipment) -> ClauseResult:
    """The items of JJF 2003-2022 by fitting models (1) and (2) to everything at once."""
    recording = evidence.recording
    gravity_alone = not recording.manifest.segments and attitude_stream(recording) is None
    return (joint_by_gravity if gravity_alone else joint_on_table)(evidence, equipment)


JOINT = replace(
    JJF2003,
    method="joint",
    procedure="JJF 2003-2022, 5.1, 5.2, joint least squares with zero correction",
    printed_once=("gyro_g_sensitivity",),  # the fit removes Earth's rotation from it
    check=check,
    estimate=estimate,
)
