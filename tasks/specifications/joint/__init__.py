"""The joint method (patent, claims 1 to 4): one fit over all dynamic and static samples."""

from dataclasses import replace
from functools import partial

from tasks.motion.whole import attitude_stream
from tasks.specifications.estimate import ClauseResult
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.jjf2003 import JJF2003, check_imu_columns
from tasks.specifications.joint.by_gravity import joint_by_gravity
from tasks.specifications.joint.on_table import joint_on_table
from tasks.uncertainty.equipment import Equipment


def estimate(evidence: ClauseEvidence, equipment: Equipment) -> ClauseResult:
    """The items of JJF 2003-2022 by fitting models (1) and (2) to everything at once."""
    recording = evidence.recording
    gravity_alone = not recording.manifest.segments and attitude_stream(recording) is None
    return (joint_by_gravity if gravity_alone else joint_on_table)(evidence, equipment)


JOINT = replace(
    JJF2003,
    method="joint",
    procedure="JJF 2003-2022, 5.1, 5.2, joint least squares with zero correction",
    printed_once=("gyro_g_sensitivity",),  # the fit removes Earth's rotation from it
    check=partial(
        check_imu_columns,
        use="the joint method fits; calibrate a recording of accumulated angles with "
        "--method jjf1536",
    ),
    estimate=estimate,
)
