"""The motion of the unit over a whole recording.

From the table's encoders where they were recorded, else from a reference pose, else from the
segments' labels. Where there is none of these, the motion is unknown (NaN), never assumed.
Frames as in `mimu-recording/1`: n is East-North-Up.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from schemas.recording import AXES, Recording, Segment, Stream, Up
from tasks.motion.reported_rate import is_rate_of
from tasks.motion.smooth import smooth_derivatives
from tasks.motion.table import axis_directions, mount_of

STANDARD_GRAVITY = 9.80665  # m/s², where the local one is not stated and only ratios are taken
POSE = ("qw", "qx", "qy", "qz")
SEAM = 0.05  # rad that the vertical jumps by, at least, where the unit was fixed anew


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

    def taken(self, rows: np.ndarray) -> "TableAxes":
        """The axes at some of the times, by index or mask."""
        return TableAxes(
            self.angles[rows], self.speeds[rows], self.directions[rows], self.base[rows]
        )

    def in_frame(self, mount: np.ndarray) -> "TableAxes":
        """Components along the body's axes instead of the payload's."""
        return replace(self, directions=self.directions @ mount, base=self.base @ mount)


@dataclass(frozen=True)
class Motion:
    """Attitude and motion of the body at n times, in the body frame; NaN: not known.

    t: (n,) s. up, north: (n, 3) unit vectors. rate: (n, 3) rad/s against the ground.
    acceleration: (n, 3) rad/s², the derivative of the rate. gravity: m/s².
    axes: those of the table, where encoders were recorded; each mount sees them its own way.
    recorded: what else was recorded or is known at each time, (n,) each, by name.
    """

    t: np.ndarray
    up: np.ndarray
    north: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray
    gravity: float
    axes: TableAxes | None = None
    recorded: Mapping[str, np.ndarray] = field(default_factory=dict)

    @cached_property
    def known(self) -> np.ndarray:
        """(n,) bool: the vertical and the rate are known."""
        return np.isfinite(self.up).all(axis=1) & np.isfinite(self.rate).all(axis=1)

    @cached_property
    def interval(self) -> float:
        """Time between rows, s."""
        return float(np.median(np.diff(self.t)))

    @cached_property
    def takes(self) -> tuple[slice, ...]:
        """Rows between two fixings: apart where the attitude jumps by more than any turn between
        two rows does.
        """
        moved = np.linalg.norm(np.diff(np.nan_to_num(self.up), axis=0), axis=1)
        turned = np.linalg.norm(np.nan_to_num(self.rate), axis=1) * self.interval
        limit = SEAM + 3.0 * np.maximum(turned[1:], turned[:-1])
        known = self.known[1:] & self.known[:-1]
        seams = (np.flatnonzero((moved > limit) & known) + 1).tolist()
        return tuple(slice(a, b) for a, b in pairwise([0, *seams, len(self.t)]))

    @property
    def force(self) -> np.ndarray:
        """Specific force (n, 3) m/s² of a body at rest: gravity's reaction, upwards."""
        return self.gravity * self.up

    def taken(self, rows: np.ndarray) -> "Motion":
        """The motion at some of the times, by index or mask."""
        return replace(
            self,
            t=self.t[rows],
            up=self.up[rows],
            north=self.north[rows],
            rate=self.rate[rows],
            acceleration=self.acceleration[rows],
            axes=self.axes and self.axes.taken(rows),
            recorded={name: signal[rows] for name, signal in self.recorded.items()},
        )


def attitude_recorded(recording: Recording) -> bool:
    """Whether encoders or a reference pose give the attitude, and not the labels alone."""
    by_table = recording.table is not None and bool(recording.manifest.station.table_axes)
    pose = recording.reference
    return by_table or (pose is not None and set(POSE) <= set(pose.columns))


def whole_motion(recording: Recording, t: np.ndarray | None = None) -> Motion:
    """The motion at the unit's rows, or at other times t (n,) s of the same time base."""
    at = recording.imu.t if t is None else t
    if recording.table is not None and recording.manifest.station.table_axes:
        return _by_table(recording, recording.table, at)
    if recording.reference is not None and set(POSE) <= set(recording.reference.columns):
        return _by_pose(recording, recording.reference, at)
    return _by_labels(recording, at)


def unit_vector(up: Up | None) -> np.ndarray:
    """The direction (3,) of an axis with its sign, NaN for none."""
    if up is None:
        return np.full(3, np.nan)
    return np.eye(3)[AXES.index(up[1])] * (1.0 if up[0] == "+" else -1.0)


def gravity_of(recording: Recording) -> float:
    """Local gravity, m/s²; the standard one where it is not stated."""
    return recording.manifest.station.gravity_m_s2 or STANDARD_GRAVITY


def _unknown(recording: Recording, at: np.ndarray) -> Motion:
    up, north, rate, acceleration = (np.full((len(at), 3), np.nan) for _ in range(4))
    return Motion(at, up, north, rate, acceleration, gravity_of(recording))


def _by_table(recording: Recording, table: Stream, at: np.ndarray) -> Motion:
    """Turns the directions of n, and of each axis, inwards through the table's axes.

    The body rate is Σ sₖ·θ̇ₖ over the axes' directions sₖ in the body. Those change with what
    turns inside them, so that its derivative is Σ sₖ·θ̈ₖ − (ω_inside × sₖ)·θ̇ₖ.
    """
    axes = recording.manifest.station.table_axes or ()
    angles = table.stack(tuple(f"{axis.name}_angle" for axis in axes))
    if (np.abs(np.diff(angles, axis=0)) > np.pi).any():  # an encoder that starts anew each turn
        angles = np.unwrap(angles, axis=0)
    angle, speed, change = smooth_derivatives(table.t, angles, at)
    speed = _as_reported(table, [axis.name for axis in axes], angles, at, speed)
    heading = recording.manifest.station.heading_deg
    vertical, level = (np.tile(unit, (len(at), 1)) for unit in np.eye(3)[[2, 1]])
    vectors = [vertical, _north(heading, len(at)), level]
    for k, direction in enumerate(axis_directions(recording.manifest.station)):
        vectors = [_turned(vector, direction, -angle[:, k]) for vector in vectors]
        vectors.append(np.tile(direction, (len(at), 1)))
    up, north, base, *spins = vectors
    rate, acceleration = np.zeros((len(at), 3)), np.zeros((len(at), 3))
    for k in reversed(range(len(axes))):
        own = speed[:, k, None] * spins[k]
        acceleration += change[:, k, None] * spins[k] - np.cross(rate, own)
        rate += own
    turning = TableAxes(angle, speed, np.stack(spins, axis=1), base)
    payload = Motion(at, up, north, rate, acceleration, gravity_of(recording), turning)
    return _mounted(recording, payload)


def _as_reported(
    table: Stream, names: Sequence[str], angles: np.ndarray, at: np.ndarray, speed: np.ndarray
) -> np.ndarray:
    """Rates (m, k) of the axes: the reported one where it is the angle's, else the derivative."""
    speed = speed.copy()
    for k, name in enumerate(names):
        reported = table.columns.get(f"{name}_rate")
        if reported is not None and is_rate_of(table.t, angles[:, k], reported):
            rate = np.interp(at, table.t, reported)
            speed[:, k] = np.where(np.isfinite(speed[:, k]), rate, np.nan)
    return speed


def _north(heading: float | None, count: int) -> np.ndarray:
    """North in the table's frame at zero angles, Rz(−heading)ᵀ·(0, 1, 0); NaN if not stated."""
    psi = np.radians(np.nan if heading is None else heading)
    return np.tile([-np.sin(psi), np.cos(psi), 0.0], (count, 1))


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


def _mounted(recording: Recording, payload: Motion) -> Motion:
    """From the payload's frame to the body's: the recording's mount, or each segment's own.

    Where segments carry a mount, what happened outside them (re-fixing) is not known.
    """
    manifest = recording.manifest
    own = [segment for segment in manifest.segments or () if segment.mount is not None]
    if not own:
        whole = Segment(name="whole", kind="transition", t_start=0.0, t_end=0.0)
        return _in_frame(payload, mount_of(manifest, whole))
    body, axes = _unknown(recording, payload.t), payload.axes
    if axes is not None:
        directions, base = np.full_like(axes.directions, np.nan), np.full_like(axes.base, np.nan)
        body = replace(body, axes=replace(axes, directions=directions, base=base))
    for segment in own:
        rows = (payload.t >= segment.t_start) & (payload.t < segment.t_end)
        part = _in_frame(payload.taken(rows), mount_of(manifest, segment))
        for name in ("up", "north", "rate", "acceleration"):
            getattr(body, name)[rows] = getattr(part, name)
        if body.axes is not None and part.axes is not None:
            body.axes.directions[rows], body.axes.base[rows] = part.axes.directions, part.axes.base
    return body


def _in_frame(motion: Motion, mount: np.ndarray) -> Motion:
    """Components along the body's axes, Mᵀ·v for each vector v."""
    return replace(
        motion,
        up=motion.up @ mount,
        north=motion.north @ mount,
        rate=motion.rate @ mount,
        acceleration=motion.acceleration @ mount,
        axes=motion.axes and motion.axes.in_frame(mount),
    )


def _by_pose(recording: Recording, pose: Stream, at: np.ndarray) -> Motion:
    """The attitude of a tracked body; its rate from the small turns between its samples.

    The turns, added up, are an angle vector whose derivative is the body rate.
    """
    from scipy.spatial.transform import Rotation, Slerp  # late: few recordings have a pose

    attitude = Rotation.from_quat(pose.stack(POSE), scalar_first=True)
    turns = (attitude[:-1].inv() * attitude[1:]).as_rotvec()
    summed = np.concatenate([np.zeros((1, 3)), np.cumsum(turns, axis=0)])
    _, rate, acceleration = smooth_derivatives(pose.t, summed, at)
    inside = (at >= pose.t[0]) & (at <= pose.t[-1])
    matrix = np.full((len(at), 3, 3), np.nan)
    matrix[inside] = Slerp(pose.t, attitude)(at[inside]).as_matrix()
    rate[~inside], acceleration[~inside] = np.nan, np.nan
    return Motion(at, matrix[:, 2], matrix[:, 1], rate, acceleration, gravity_of(recording))


def _by_labels(recording: Recording, at: np.ndarray) -> Motion:
    """What the labels say: rests, steady turns at the nominal rate, turns by an angle.

    A turn by a known angle is known in the mean only: its angle over its time.
    """
    motion = _unknown(recording, at)
    for segment in recording.manifest.segments or ():
        turned = _labelled_rate(segment)
        if turned is None:
            continue
        start, stop = np.searchsorted(at, (segment.t_start, segment.t_end))
        rows = slice(int(start), int(stop))
        axis = np.eye(3)[AXES.index(segment.axis)] if segment.axis else np.zeros(3)
        motion.up[rows] = unit_vector(segment.up)
        motion.rate[rows] = turned * axis
        if segment.kind != "rotation":
            motion.acceleration[rows] = 0.0
    return motion


def _labelled_rate(segment: Segment) -> float | None:
    """Rate (rad/s) about the segment's axis, None where the label has none."""
    if segment.kind == "static":
        return 0.0
    if segment.kind == "rate" and segment.rate_deg_s is not None:
        return float(np.radians(segment.rate_deg_s))
    if segment.kind == "rotation" and segment.angle_deg is not None:
        return float(np.radians(segment.angle_deg)) / (segment.t_end - segment.t_start)
    return None
