"""The table's motion as the unit on it feels it.

Frames as in `mimu-recording/1`: R_n_payload = Rz(−heading)·R(dir₁, angle₁)·R(dir₂, angle₂)…;
R_n_body = R_n_payload·R(mount).
"""

import numpy as np

from schemas.recording import Manifest, Recording, Segment

EARTH_RATE = 7.292115e-5  # rad/s, sidereal; WGS 84


def rotation(direction: np.ndarray, angle: float) -> np.ndarray:
    """Matrix (3, 3) of the turn by `angle` (rad) about a unit direction (Rodrigues)."""
    x, y, z = direction
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def mount_of(manifest: Manifest, segment: Segment) -> np.ndarray:
    """R(mount) (3, 3): the segment's own mount, else the recording's."""
    quaternion = np.array((segment.mount or manifest.mount).quaternion_wxyz)
    w, *axis = quaternion / np.linalg.norm(quaternion)
    size = float(np.linalg.norm(axis))
    return rotation(np.array(axis) / size, 2 * np.arctan2(size, w)) if size else np.eye(3)


def axis_in_body(manifest: Manifest, segment: Segment, angles: np.ndarray, axis: int) -> np.ndarray:
    """Direction of one table axis in the body frame, (3,), at the given axis angles (rad)."""
    directions = [np.array(each.direction) for each in manifest.station.table_axes or ()]
    directions = [each / np.linalg.norm(each) for each in directions]
    inner = np.eye(3)
    for direction, angle in zip(directions[axis + 1 :], angles[axis + 1 :], strict=True):
        inner = inner @ rotation(direction, angle)
    return (inner @ mount_of(manifest, segment)).T @ directions[axis]


def mean_rate(recording: Recording, segment: Segment) -> np.ndarray | None:
    """Mean body rate (3,) rad/s that the encoders say, or None where there is no table stream.

    The angle turned between the first and the last encoder sample of the segment, divided by
    the time between them. One axis turns at a time; with several, each at the mean attitude of
    those inside it.
    """
    axes = recording.manifest.station.table_axes
    if recording.table is None or not axes:
        return None
    rows = recording.table.rows(segment.t_start, segment.t_end)
    if rows.stop - rows.start < 2:
        return None
    t = recording.table.t[rows]
    angles = recording.table.stack_rows(tuple(f"{axis.name}_angle" for axis in axes), rows)
    angles = np.unwrap(angles, axis=0)  # an encoder that starts anew each turn
    rates = (angles[-1] - angles[0]) / (t[-1] - t[0])
    attitude = angles.mean(axis=0)
    turning = np.flatnonzero(rates)
    body = (
        rates[axis] * axis_in_body(recording.manifest, segment, attitude, int(axis))
        for axis in turning
    )
    return sum(body, start=np.zeros(3))
