"""The axes of a tracked body, turned into those of the unit that is fixed to it.

Markers are stuck on somehow. The standard's matrices absorb the turn between the two triads whole;
what else follows rates or forces, as a lever arm or an error of one accelerometer, does not. Where
the triads tell different turns, columns are exchanged or inverted, and nothing is turned.
"""

from dataclasses import replace

import numpy as np

from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.model.parameters import DEG
from tasks.motion.pose_frames import POSE
from tasks.motion.whole import Motion
from tasks.words import Sayable, message

DISTINCT = 0.1  # least ratio of the gains of a triad's axes: else it has no attitude
TURNED = 5.0  # deg: a delay of the poses alone looks like one or two
EXCHANGED = 0.7  # cosine between axes of the triads: of half a right angle
HELD = 3  # rows at the largest or least value of a channel from which it is a limit
ROUNDS = 20  # of a fit by absolute deviations, which torn rows hardly move


def in_unit_axes(recording: Recording, motion: Motion) -> tuple[Stream | None, tuple[Sayable, ...]]:
    """The poses of the unit, from those of the body that was tracked, and a remark on a large turn.

    motion: by those poses. None where no poses tell the motion, where gyros do not determine the
    turn, or where accelerometers contradict it.
    """
    pose, imu = recording.reference, recording.imu
    if pose is None or motion.tracking is None:
        return None, ()
    from scipy.spatial.transform import Rotation

    by_gyros = _arrangement(motion.rate, imu.stack(GYRO), motion.felt[:, 0])
    by_accels = _arrangement(motion.force, imu.stack(ACCEL), motion.felt[:, 3])
    if by_gyros is None:
        return None, ()
    if by_accels is not None and (by_gyros * by_accels).sum(axis=0).min() < EXCHANGED:
        return None, (message("reference-triads-apart"),)
    if np.linalg.det(by_gyros) < 0.0:
        return None, ()
    turn = Rotation.from_matrix(by_gyros)
    attitude = Rotation.from_quat(pose.stack(POSE), scalar_first=True) * turn
    columns = dict(zip(POSE, attitude.as_quat(scalar_first=True).T, strict=True))
    degrees = DEG * turn.magnitude()
    remarks = (message("reference-turned", degrees=f"{degrees:.1f}"),) if degrees > TURNED else ()
    return replace(pose, columns={**pose.columns, **columns}), remarks


def _arrangement(by_poses: np.ndarray, read: np.ndarray, known: np.ndarray) -> np.ndarray | None:
    """(3, 3) orthogonal, from a triad's axes to the body's: the nearest to the matrix that makes
    the triad's readings (n, 3) of what the poses tell (n, 3). None where they do not determine it.

    Of absolute deviations, by weights that are the inverse of each row's deviation.
    """
    used = known & np.isfinite(by_poses).all(axis=1) & np.isfinite(read).all(axis=1)
    used &= ~_at_limits(read).any(axis=1)
    if not used.any():
        return None
    columns, readings = np.column_stack([by_poses, np.ones(len(by_poses))])[used], read[used]
    weight = np.ones((len(columns), 1))
    for _ in range(ROUNDS):
        fitted, _, rank, _ = np.linalg.lstsq(columns * weight, readings * weight, rcond=None)
        size = np.linalg.norm(readings - columns @ fitted, axis=1, keepdims=True)
        weight = 1.0 / np.sqrt(np.maximum(size, 1e-3 * size.mean() + 1e-12))
    left, gains, right = np.linalg.svd(fitted[:3])
    if rank < columns.shape[1] or gains[-1] < DISTINCT * gains[0]:
        return None
    return np.asarray(left @ right)


def _at_limits(read: np.ndarray) -> np.ndarray:
    """(n, 3) bool: readings at the largest or least value of their channel, if it has several."""
    ends = [read == extreme.reduce(read, axis=0) for extreme in (np.fmax, np.fmin)]
    return np.asarray(np.any([end & (end.sum(axis=0) >= HELD) for end in ends], axis=0))
