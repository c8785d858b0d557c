"""The table's motion as the unit on it feels it.

Frames as in `mimu-recording/1`: R_n_payload = Rz(−heading)·R(dir₁, angle₁)·R(dir₂, angle₂)…;
R_n_body = R_n_payload·R(mount).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from schemas.recording import Manifest, Mount, Recording, Segment, Station
from tasks.motion.samples import continuous

ALONG = np.cos(np.radians(10.0))  # a mount turned farther from square is meant to be aslant
SAME_DIRECTION = 1.0 - 1e-12  # cosine of no angle at all
EARTH_RATE = 7.292115e-5  # rad/s, sidereal; WGS 84


@dataclass(frozen=True)
class TableAxes:
    """The table's axes as the body sees them, outermost first.

    angles, speeds: (n, k) rad, rad/s. directions: (n, k, 3) unit vectors in the body frame.
    base: (n, 3) what the table's y axis is with all angles zero, in the body frame.
    """

    angles: np.ndarray
    speeds: np.ndarray
    directions: np.ndarray
    base: np.ndarray

    def outside(self, axis: int) -> np.ndarray:
        """Rate (n, 3) of what carries an axis: of the axes outside it."""
        return np.einsum("nk,nki->ni", self.speeds[:, :axis], self.directions[:, :axis])

    def mapped(self, function: Callable[[np.ndarray], np.ndarray]) -> "TableAxes":
        """The axes with a function applied to each array (n, …), such as a choice of rows."""
        arrays = (self.angles, self.speeds, self.directions, self.base)
        return TableAxes(*map(function, arrays))


def rotation(direction: np.ndarray, angle: float) -> np.ndarray:
    """Matrix (3, 3) of the turn by `angle` (rad) about a unit direction."""
    from scipy.spatial.transform import Rotation  # late: it takes a third of a start

    return np.asarray(Rotation.from_rotvec(angle * np.asarray(direction)).as_matrix())


def mount_of(manifest: Manifest, segment: Segment | None = None) -> np.ndarray:
    """R(mount) (3, 3), frozen: the segment's own mount, else the recording's."""
    return _matrix_of(((segment and segment.mount) or manifest.mount).quaternion_wxyz)


@lru_cache(maxsize=64)
def _matrix_of(quaternion_wxyz: tuple[float, ...]) -> np.ndarray:
    from scipy.spatial.transform import Rotation  # late: see above

    matrix = np.asarray(Rotation.from_quat(quaternion_wxyz, scalar_first=True).as_matrix())
    matrix.setflags(write=False)
    return matrix


def labelled_direction(manifest: Manifest, segment: Segment | None, axis: np.ndarray) -> np.ndarray:
    """Direction (3,) in the body of what a label calls by the unit's axis, a unit vector (3,).

    It is the axis of the payload that the mount lays nearest to it: a fixture stands square on the
    table, and the unit in it by what the mount states. One mounted aslant is labelled by its own.
    """
    mount = mount_of(manifest, segment)
    along = mount @ axis
    nearest = int(np.abs(along).argmax())
    if not ALONG < abs(along[nearest]) < SAME_DIRECTION:
        return axis
    return np.asarray(np.sign(along[nearest]) * mount[nearest])


def off_square(manifest: Manifest) -> float:
    """Largest angle (rad) between an axis of the unit and the payload's nearest; 0: square."""
    mounts = [label.mount for label in manifest.segments or () if label.mount]
    turned = {mount.quaternion_wxyz for mount in (*mounts, manifest.mount)}
    along = min(np.abs(_matrix_of(mount)).max(axis=1).min() for mount in turned)
    return float(np.arccos(along)) if along < SAME_DIRECTION else 0.0


def squared(manifest: Manifest) -> Manifest:
    """The manifest with the unit square in its fixture: what is found is about the fixture's axes.

    Mounts that are nearly square alone; a unit that lies aslant has no other axes than its own.
    """
    from scipy.spatial.transform import Rotation  # late: see above

    def square(mount: Mount) -> Mount:
        matrix = _matrix_of(mount.quaternion_wxyz)
        near = np.where(np.abs(matrix) > ALONG, np.sign(matrix), 0.0)
        if np.abs(near).sum() != len(near):
            return mount
        turned = Rotation.from_matrix(near).as_quat(scalar_first=True)
        return Mount(quaternion_wxyz=turned.tolist())

    segments = manifest.segments and tuple(
        label.model_copy(update={"mount": label.mount and square(label.mount)})
        for label in manifest.segments
    )
    return manifest.model_copy(update={"mount": square(manifest.mount), "segments": segments})


def axis_directions(station: Station) -> list[np.ndarray]:
    """Unit vectors (3,) of the table's axes, outermost first, all angles zero."""
    directions = [np.array(axis.direction) for axis in station.table_axes or ()]
    return [direction / np.linalg.norm(direction) for direction in directions]


def table_vectors(station: Station, angle: np.ndarray) -> list[np.ndarray]:
    """Up, north, the table's y axis and the direction of each axis, (n, 3) in the payload's frame.

    angle: (n, k) rad of the axes.
    """
    heading = station.heading_deg
    psi = np.radians(np.nan if heading is None else heading)
    fixed = ([0.0, 0.0, 1.0], [-np.sin(psi), np.cos(psi), 0.0], [0.0, 1.0, 0.0])
    vectors = [np.tile(vector, (len(angle), 1)) for vector in fixed]
    for k, direction in enumerate(axis_directions(station)):
        vectors = [_turned(vector, direction, -angle[:, k]) for vector in vectors]
        vectors.append(np.tile(direction, (len(angle), 1)))
    return vectors


def _turned(vector: np.ndarray, direction: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) turned by angles (n,) rad about one unit direction (Rodrigues).

    By hand, because a matrix for each of a million rows, as scipy's Rotation makes, is nine times
    the memory.
    """
    if not angle.any():
        return vector
    along = (vector @ direction)[:, None] * direction
    sin, cos = np.sin(angle)[:, None], np.cos(angle)[:, None]
    return along + cos * (vector - along) + sin * np.cross(direction, vector)


def payload_attitude(station: Station, angles: np.ndarray) -> np.ndarray:
    """R_n_payload (3, 3) at the table's angles (rad); an unknown heading is taken as zero."""
    turned = rotation(np.array([0.0, 0.0, 1.0]), -np.radians(station.heading_deg or 0.0))
    for direction, angle in zip(axis_directions(station), angles, strict=True):
        turned = turned @ rotation(direction, float(angle))
    return turned


def axis_in_body(manifest: Manifest, segment: Segment, angles: np.ndarray, axis: int) -> np.ndarray:
    """Direction of one table axis in the body frame, (3,), at the given axis angles (rad)."""
    directions = axis_directions(manifest.station)
    seen = directions[axis][None]
    for direction, angle in zip(directions[axis + 1 :], angles[axis + 1 :], strict=True):
        seen = _turned(seen, direction, np.array([-angle]))
    return mount_of(manifest, segment).T @ seen[0]


def table_angles(recording: Recording, segment: Segment) -> np.ndarray:
    """Angles (n, k) rad of the table's axes in a segment, continuous over whole turns."""
    axes, table = recording.manifest.station.table_axes, recording.table
    if table is None or not axes:
        return np.empty((0, 0))
    rows = table.rows(segment.t_start, segment.t_end)
    return continuous(table, tuple(f"{axis.name}_angle" for axis in axes), rows)


def mean_rate(recording: Recording, segment: Segment) -> np.ndarray | None:
    """Mean body rate (3,) rad/s by the encoders, or None where there is no table stream.

    The angle turned between the first and the last encoder sample of the segment, divided by
    the time between them. One axis turns at a time; with several, each at the mean attitude of
    those inside it.
    """
    angles = table_angles(recording, segment)
    if recording.table is None or len(angles) < 2:
        return None
    t = recording.table.t[recording.table.rows(segment.t_start, segment.t_end)]
    rates = (angles[-1] - angles[0]) / (t[-1] - t[0])
    attitude = angles.mean(axis=0)
    turning = np.flatnonzero(rates)
    body = (
        rates[axis] * axis_in_body(recording.manifest, segment, attitude, int(axis))
        for axis in turning
    )
    return sum(body, start=np.zeros(3))
