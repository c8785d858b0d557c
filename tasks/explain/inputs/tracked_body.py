"""The axes of a tracked body, turned into those of the unit that is fixed to it.

Markers are stuck on somehow. The standard's matrices absorb the turn between the two triads whole;
what else follows rates or forces, as a lever arm or an error of one accelerometer, does not.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from schemas.recording import GYRO, Recording, Stream
from tasks.explain.inputs.gyro_acceleration import by_rates
from tasks.model.parameters import DEG
from tasks.motion.pose_frames import POSE
from tasks.motion.whole import Motion
from tasks.words import Sayable, message

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

DISTINCT = 0.1  # least ratio of the gains of a triad's axes: else it has no attitude
TURNED = 5.0  # deg: a delay of the poses alone looks like one or two


def in_unit_axes(recording: Recording, motion: Motion) -> tuple[Stream | None, tuple[Sayable, ...]]:
    """The poses of the unit, from those of the body that was tracked, and a remark on a large turn.

    motion: by those poses. None where no poses tell the motion, or gyros do not determine the turn.
    """
    pose = recording.reference
    turn = None if motion.tracking is None else _turn(motion, recording.imu.stack(GYRO))
    if pose is None or turn is None:
        return None, ()
    from scipy.spatial.transform import Rotation

    attitude = Rotation.from_quat(pose.stack(POSE), scalar_first=True) * turn
    columns = dict(zip(POSE, attitude.as_quat(scalar_first=True).T, strict=True))
    degrees = DEG * turn.magnitude()
    remarks = (message("reference-turned", degrees=f"{degrees:.1f}"),) if degrees > TURNED else ()
    return replace(pose, columns={**pose.columns, **columns}), remarks


def _turn(motion: Motion, gyro: np.ndarray) -> "Rotation | None":
    """Turns vectors in the unit into the body: the rotation nearest to the matrix that makes the
    gyros' readings (n, 3) of the poses' rates. None where there is none.
    """
    from scipy.spatial.transform import Rotation

    known = motion.felt[:, 0] & np.isfinite(gyro).all(axis=1)
    columns, fitted, rank = by_rates(motion, gyro, known)
    left, gains, right = np.linalg.svd(fitted[:3])
    nearest = left @ right
    if rank < columns.shape[1] or gains[-1] < DISTINCT * gains[0] or np.linalg.det(nearest) < 0.0:
        return None
    return Rotation.from_matrix(nearest)
