"""The motion of the unit over a whole recording.

From the table's encoders where they were recorded, else from a reference pose, else from the
segments' labels. Where there is none of these, the motion is unknown (NaN), never assumed.
Frames as in `mimu-recording/1`: n is East-North-Up.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from schemas.base import Unusable
from schemas.recording import AXES, Recording, Segment, Stream, Up
from tasks.motion.encoders import smooth_course
from tasks.motion.pose import POSE, Tracking, tracked_motion
from tasks.motion.samples import continuous, in_blocks, noise_by_differences, sample_interval
from tasks.motion.table import TableAxes, labelled_direction, mean_rate, mount_of, table_vectors

# A table whose angles are polled: their times are known to ± τ, as the manifest says.
#
# A mean rate over T is uncertain by √2·τ/T of itself, and no derivative of such angles is a rate.
# What is known of the motion is what the labels say is held: rests, and rates that the angles
# agree with.

MOST_HALF_WIDTH_S = 3600.0
STEADINESS = 5e-4  # 0.05 % rate stability, JJF 2003-2022, Table 1


def polled_within(recording: Recording) -> float:
    """Within how many seconds the times of polled angles are known; 0 where they are captured.

    Raises Unusable for a `table_time` that says no such time.
    """
    stated = (recording.manifest.model_extra or {}).get("table_time")
    if stated is None or recording.table is None:
        return 0.0
    captured = 0.0 if isinstance(stated, dict) and "commanded_rate" in stated else None
    half_width_s = stated.get("half_width_s", captured) if isinstance(stated, dict) else stated
    if not isinstance(half_width_s, int | float) or not 0.0 <= half_width_s < MOST_HALF_WIDTH_S:
        raise Unusable(
            f"the manifest's table_time.half_width_s is {half_width_s!r}: give the half-width in s "
            f"(0 to {MOST_HALF_WIDTH_S:g}) by which the encoders' times are known"
        )
    return float(half_width_s)


def doubt_of_angles(recording: Recording, seconds: float) -> float:
    """By how much of itself a mean rate over some seconds may be wrong, by the angles' times."""
    return math.sqrt(2.0) * polled_within(recording) / max(seconds, 1e-3)


def agreeing_rate(recording: Recording, segment: Segment) -> np.ndarray | None:
    """The mean body rate (3,) rad/s of a held rate as labelled, about the axis that turns.

    None where the angles contradict it.
    """
    shown = mean_rate(recording, segment)
    if shown is None or not shown.any() or not segment.rate_deg_s:
        return None
    labelled = abs(np.radians(segment.rate_deg_s)) / np.linalg.norm(shown)
    doubt = doubt_of_angles(recording, segment.t_end - segment.t_start)
    return shown * labelled if abs(labelled - 1.0) < STEADINESS + doubt else None


def as_held(recording: Recording, motion: "Motion") -> "Motion":
    """The motion with the rates that are held, unknown in between; the angles are no course."""
    rate = np.full_like(motion.rate, np.nan)
    for segment in recording.manifest.segments or ():
        rows = slice(*np.searchsorted(motion.t, (segment.t_start, segment.t_end)))
        if segment.kind == "static":
            rate[rows] = 0.0
        elif segment.kind == "rate":
            held = agreeing_rate(recording, segment)
            rate[rows] = np.nan if held is None else held
    return replace(motion, rate=rate, acceleration=0.0 * rate, axes=None)


# Whether the rate that a table reports beside its angle is the rate of that angle.
#
# A rate that the table's controller measured is quieter than any derivative of the angle and does
# not round off the corners of a ramp. But many tables report the rate commanded, a filtered one,
# or a difference of angles half an interval late; then the angle is what counts.

STEADY = 0.02  # rad/s²: less of it is a dwell at rate
MOVING = 0.005  # rad/s
BLOCK = 16  # increments whose mean shows a slow difference beneath the encoder's noise
FEWEST_BLOCKS = 10  # of steady motion; fewer prove nothing
SCALE, LAG, ROUNDED = 1e-5, 2e-3, 0.03  # of the rate, of the interval, of the interval squared
AGREEING = 1.5  # of the noise expected: the rms of block means
NEGLIGIBLE = 1e-6  # rad/s: a difference that no unit on a table resolves
EVEN = 0.01  # of the interval: stamps that differ by more are not compared
# the angle's increment over one interval, by the rates at four samples around it
QUADRATURE = np.array([-1.0, 13.0, 13.0, -1.0]) / 24.0
ORDER = 3  # of the differences that the noise is read off


def reported_rate(table: Stream, axis: str) -> np.ndarray | None:
    """The rate (n,) rad/s that a table reports of an axis; None where it is not its angle's."""
    rate = table.columns.get(f"{axis}_rate")
    if rate is None:
        return None
    angle = continuous(table, (f"{axis}_angle",))[:, 0]
    return rate if is_rate_of(table.t, angle, rate) else None


def is_rate_of(t: np.ndarray, angle: np.ndarray, rate: np.ndarray) -> bool:
    """Whether a reported rate (n,) rad/s is that of the angle (n,) rad at even times (n,) s.

    Its integral must give the angle's increments: without a scale, without a lag, without
    rounded corners, and within the noise of both, at steady rates where there are any; and it
    must be quieter than the angle's differences.
    """
    if len(t) < 4 * BLOCK or not (np.isfinite(angle) & np.isfinite(rate)).all():
        return False
    interval = float(np.median(np.diff(t)))
    if np.abs(np.diff(t) - interval).max() > EVEN * interval:
        return False
    middle = np.convolve(rate, QUADRATURE, "valid")
    missed = np.diff(angle)[1:-1] / interval - middle
    change = (rate[2:-1] - rate[1:-2]) / interval
    bend = (rate[3:] - rate[2:-1] - rate[1:-2] + rate[:-3]) / 2.0
    moving = np.abs(middle) > MOVING
    regressors = np.column_stack([middle, change * interval, bend])
    of_angle = np.sqrt(2.0) * noise_by_differences(angle, ORDER, 0.5) / interval
    of_rate = noise_by_differences(rate, ORDER, 0.5)
    if of_rate > of_angle + NEGLIGIBLE:
        return False  # the angle's differences are the better rate
    steady = moving & (np.abs(change) < STEADY)
    compared = steady if steady.sum() >= 2 * FEWEST_BLOCKS * BLOCK else moving
    return _independent_of(regressors[moving], missed[moving]) and _agreeing(
        missed, compared, of_angle, of_rate
    )


def _independent_of(regressors: np.ndarray, missed: np.ndarray) -> bool:
    """Whether the misses follow neither the rate, its change nor its bend, beyond the limits."""
    if len(missed) < BLOCK or not regressors.any(axis=0).all():
        return False
    size = np.sqrt((regressors**2).mean(axis=0))
    normal = np.linalg.pinv((regressors / size).T @ (regressors / size))
    slopes = normal @ ((regressors / size).T @ missed)
    u = np.sqrt(np.diag(normal)) * np.std(missed)
    return bool((np.abs(slopes) <= size * np.array([SCALE, LAG, ROUNDED]) + 3.0 * u).all())


def _agreeing(missed: np.ndarray, compared: np.ndarray, of_angle: float, of_rate: float) -> bool:
    """Whether block means of the misses are no larger than the noise of both makes them."""
    means = in_blocks(missed, BLOCK).mean(axis=1)[in_blocks(compared, BLOCK).all(axis=1)]
    if len(means) < FEWEST_BLOCKS:
        return False
    expected = (of_angle / BLOCK) ** 2 + of_rate**2 / BLOCK + NEGLIGIBLE**2
    return bool((means**2).mean() <= AGREEING**2 * expected)


STANDARD_GRAVITY = 9.80665  # m/s², where the local one is not stated and only ratios are taken
UNEVEN = 0.02  # of the interval by which a step between stamps differs
MOSTLY = 0.9  # of the steps: rows are even but for gaps
TIMED = 1e-4  # s: angles whose times are known worse have no derivatives
SEAM = 0.05  # rad that the vertical jumps by, at least, where the unit was fixed anew


@dataclass(frozen=True)
class Motion:
    """Attitude and motion of the body at n times, in the body frame; NaN: unknown.

    t: (n,) s. up, north: (n, 3) unit vectors. rate: (n, 3) rad/s relative to the ground.
    acceleration: (n, 3) rad/s², the derivative of the rate. gravity: m/s². axes: of the table, if
    encoders were recorded, relative to each mount. recorded: other recorded or known signals at
    each time, (n,) each, by name. translation: (n, 3) m/s², kinematic acceleration; None: it does
    not translate, as on a table. tracking: for poses, the frequencies up to which they determine
    the motion.
    """

    t: np.ndarray
    up: np.ndarray
    north: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray
    gravity: float
    axes: TableAxes | None = None
    recorded: Mapping[str, np.ndarray] = field(default_factory=dict)
    translation: np.ndarray | None = None
    tracking: Tracking | None = None

    @cached_property
    def known(self) -> np.ndarray:
        """(n,) bool: the vertical and the rate are known."""
        return np.isfinite(self.up).all(axis=1) & np.isfinite(self.rate).all(axis=1)

    @cached_property
    def felt(self) -> np.ndarray:
        """(n, 6) bool: what a gyro, or an accelerometer, of each axis feels is known.

        A turn by an angle is known in the mean only: its rate has no known derivative. Gyros follow
        gravity, too: where it is known at all they need it.
        """
        turning = np.isfinite(self.rate).all(axis=1) & np.isfinite(self.acceleration).all(axis=1)
        upright = np.isfinite(self.up).all(axis=1)
        turning &= upright | ~upright.any()
        pushed = turning & np.isfinite(self.force).all(axis=1)
        return np.column_stack([turning, pushed]).repeat(3, axis=1)

    @cached_property
    def interval(self) -> float:
        """Time between rows, s."""
        return sample_interval(self.t)

    @cached_property
    def evenly_timed(self) -> bool:
        """Whether rows are equal times apart, but for gaps."""
        steps = np.diff(self.t)
        usual = np.abs(steps - self.interval) < UNEVEN * self.interval
        return bool(usual.mean() > MOSTLY) if len(steps) else True

    @cached_property
    def takes(self) -> tuple[slice, ...]:
        """Rows between fixings: there the attitude jumps by more than any turn within a row."""
        moved = np.linalg.norm(np.diff(np.nan_to_num(self.up), axis=0), axis=1)
        turned = np.linalg.norm(np.nan_to_num(self.rate), axis=1) * self.interval
        limit = SEAM + 3.0 * np.maximum(turned[1:], turned[:-1])
        known = self.known[1:] & self.known[:-1]
        seams = (np.flatnonzero((moved > limit) & known) + 1).tolist()
        return tuple(slice(a, b) for a, b in pairwise([0, *seams, len(self.t)]))

    @property
    def force(self) -> np.ndarray:
        """Specific force (n, 3) m/s²: gravity's reaction, upwards, and what moves the body."""
        held = self.gravity * self.up
        return held if self.translation is None else held + self.translation

    def mapped(self, function: Callable[[np.ndarray], np.ndarray]) -> "Motion":
        """The motion with a function applied to each array (n, …), such as a choice of rows."""
        arrays = (self.t, self.up, self.north, self.rate, self.acceleration)
        t, up, north, rate, acceleration = map(function, arrays)
        return Motion(
            t, up, north, rate, acceleration, self.gravity,
            axes=self.axes and self.axes.mapped(function),
            recorded={name: function(signal) for name, signal in self.recorded.items()},
            translation=None if self.translation is None else function(self.translation),
            tracking=self.tracking,
        )  # fmt: skip

    def taken(self, rows: np.ndarray) -> "Motion":
        """The motion at some of the times, by index or mask."""
        return self.mapped(lambda values: values[rows])


def whole_motion(recording: Recording, t: np.ndarray | None = None) -> Motion:
    """The motion at the unit's rows, or at other times t (n,) s of the same time base; means over
    the span of its rows where they are means.
    """
    at, span = recording.imu.t if t is None else t, recording.imu.span
    motion = _motion_at(recording, at)
    if not span:
        return motion
    before, after = _motion_at(recording, at - 0.5 * span), _motion_at(recording, at + 0.5 * span)
    return _mean_motion(motion, before, after, span)


def _mean_motion(middle: Motion, before: Motion, after: Motion, span: float) -> Motion:
    """The motion of intervals `span` s long, by that of their middles and of both ends.

    Its rate is the mean over the interval: of encoders the angle between the ends, of anything
    else by Simpson's rule. What gives the force is the mean of both ends, as such a unit's
    accelerometers are read. Unknown where any of the three is.
    """
    if middle.axes is None or before.axes is None or after.axes is None:
        rate = (before.rate + 4.0 * middle.rate + after.rate) / 6.0
    else:
        mean = (after.axes.angles - before.axes.angles) / span
        own = np.einsum("nk,nki->ni", mean - middle.axes.speeds, middle.axes.directions)
        rate = middle.rate + own
    moved = before.translation, after.translation
    return replace(
        middle,
        up=0.5 * (before.up + after.up),
        north=0.5 * (before.north + after.north),
        rate=rate,
        translation=None if moved[0] is None or moved[1] is None else 0.5 * (moved[0] + moved[1]),
    )


def north_at_rest(recording: Recording, t: np.ndarray) -> np.ndarray:
    """Where north is in the body (n, 3) at times t (n,) s of rests, as `whole_motion` has it.

    The rates of encoders, which take most of its time, are not asked for.
    """
    table = attitude_stream(recording)
    if table is None or table is not recording.table or recording.imu.span:
        return whole_motion(recording, t).north
    axes = recording.manifest.station.table_axes or ()
    course = smooth_course(table, tuple(f"{axis.name}_angle" for axis in axes))
    angle = np.full((len(t), len(axes)), np.nan) if course is None else course.angles_at(t)
    up, north, *_ = table_vectors(recording.manifest.station, angle)
    unknown = np.full((len(t), 3), np.nan)
    payload = Motion(t, up, north, unknown, unknown, gravity_of(recording))
    return _mounted(recording, payload).north


def _motion_at(recording: Recording, at: np.ndarray) -> Motion:
    stream = attitude_stream(recording)
    if stream is None:
        return _by_labels(recording, at)
    return (_by_table if stream is recording.table else _by_pose)(recording, stream, at)


def attitude_stream(recording: Recording) -> Stream | None:
    """What gives the attitude: encoders, else a reference pose; None: the labels alone."""
    if recording.table is not None and recording.manifest.station.table_axes:
        return recording.table
    pose = recording.reference
    return pose if pose is not None and set(POSE) <= set(pose.columns) else None


def unit_vector(up: Up | None) -> np.ndarray:
    """The direction (3,) of an axis with its sign, NaN for none."""
    if up is None:
        return np.full(3, np.nan)
    return np.eye(3)[AXES.index(up[1])] * (1.0 if up[0] == "+" else -1.0)


def gravity_of(recording: Recording) -> float:
    """Local gravity, m/s²; the standard one where it is not stated."""
    return recording.manifest.station.gravity_m_s2 or STANDARD_GRAVITY


def _by_table(recording: Recording, table: Stream, at: np.ndarray) -> Motion:
    """Turns the directions of n, and of each axis, inwards through the table's axes.

    The body rate is Σ sₖ·θ̇ₖ over the axes' directions sₖ in the body. Those change with what
    turns inside them, so that its derivative is Σ sₖ·θ̈ₖ − (ω_inside × sₖ)·θ̇ₖ.
    """
    axes = recording.manifest.station.table_axes or ()
    course = smooth_course(table, tuple(f"{axis.name}_angle" for axis in axes))
    unknown = np.full((3, len(at), len(axes)), np.nan)
    angle, speed, change = unknown if course is None else course.at(at)
    for k, axis in enumerate(axes):
        if (reported := reported_rate(table, axis.name)) is not None:
            known = np.isfinite(speed[:, k])
            speed[:, k] = np.where(known, np.interp(at, table.t, reported), np.nan)
    up, north, base, *spins = table_vectors(recording.manifest.station, angle)
    rate, acceleration = np.zeros((2, len(at), 3))
    for k in reversed(range(len(axes))):
        own = speed[:, k, None] * spins[k]
        acceleration += change[:, k, None] * spins[k] - np.cross(rate, own)
        rate += own
    turning = TableAxes(angle, speed, np.stack(spins, axis=1), base)
    gravity = gravity_of(recording)
    motion = _mounted(recording, Motion(at, up, north, rate, acceleration, gravity, turning))
    return as_held(recording, motion) if polled_within(recording) > TIMED else motion


def _mounted(recording: Recording, payload: Motion) -> Motion:
    """From the payload's frame to the body's: the recording's mount, or each segment's own.

    Where segments carry a mount, what happened outside them (re-fixing) is not known.
    """
    manifest = recording.manifest
    own = [segment for segment in manifest.segments or () if segment.mount is not None]
    if not own:
        return _in_frame(payload, mount_of(manifest))
    body = _in_frame(payload, np.full((3, 3), np.nan))
    for segment in own:
        rows = (payload.t >= segment.t_start) & (payload.t < segment.t_end)
        part = _in_frame(payload.taken(rows), mount_of(manifest, segment))
        for vectors, known in zip(_vectors(body), _vectors(part), strict=True):
            vectors[rows] = known
    return body


def _vectors(motion: Motion) -> tuple[np.ndarray, ...]:
    """What has components in the body frame, (n, …, 3) each."""
    of_axes = (motion.axes.directions, motion.axes.base) if motion.axes else ()
    return (motion.up, motion.north, motion.rate, motion.acceleration, *of_axes)


def _in_frame(motion: Motion, mount: np.ndarray) -> Motion:
    """Components along the body's axes, Mᵀ·v for each vector v."""
    up, north, rate, acceleration, *of_axes = (vectors @ mount for vectors in _vectors(motion))
    axes = motion.axes and TableAxes(motion.axes.angles, motion.axes.speeds, *of_axes)
    return Motion(motion.t, up, north, rate, acceleration, motion.gravity, axes)


def _by_pose(recording: Recording, pose: Stream, at: np.ndarray) -> Motion:
    """The motion of a tracked body."""
    body = tracked_motion(recording, pose, at)
    return Motion(
        at, body.up, body.north, body.rate, body.acceleration, gravity_of(recording),
        translation=body.translation, tracking=body.tracking,
    )  # fmt: skip


def _by_labels(recording: Recording, at: np.ndarray) -> Motion:
    """What the labels say: rests, steady turns at the nominal rate, turns by an angle.

    A turn by a known angle is known in the mean only: its angle over its time.
    """
    up, north, rate, acceleration = (np.full((len(at), 3), np.nan) for _ in range(4))
    for segment in recording.manifest.segments or ():
        labels = {"static": 0.0, "rate": segment.rate_deg_s, "rotation": segment.angle_deg}
        if (degrees := labels.get(segment.kind)) is None:
            continue
        if segment.axis is None and segment.kind != "static":
            continue  # the unit is held aslant, which no label says in full
        turned = np.radians(degrees)
        rows = slice(*np.searchsorted(at, (segment.t_start, segment.t_end)))
        if segment.kind == "rotation":
            turned = turned / (segment.t_end - segment.t_start)
        else:
            acceleration[rows] = 0.0
        axis = np.eye(3)[AXES.index(segment.axis)] if segment.axis else np.zeros(3)
        manifest = recording.manifest
        up[rows] = labelled_direction(manifest, segment, unit_vector(segment.up))
        rate[rows] = turned * labelled_direction(manifest, segment, axis)
    return Motion(at, up, north, rate, acceleration, gravity_of(recording))


# A motion with an additional small rotation between ground and unit.
#
# To first order in the angle. A rotation by ε about a direction u turns what is fixed in n by
# −ε·u in the body; so does the rate of what turns outside it, and ε̇ adds to the rate.


def with_small_rotation(
    motion: Motion,
    direction: np.ndarray,
    angle: np.ndarray,
    change: np.ndarray,
    outside: np.ndarray,
) -> Motion:
    """The motion with the rotation added.

    direction: (n, 3) or (3,) unit vector in the body. angle, change: (n,) rad and rad/s.
    outside: (n, 3) rad/s, rate in the body of all that turns outside of where it happens.
    """
    turn = angle[:, None] * direction
    axes = motion.axes
    if axes is not None:
        axes = replace(axes, base=axes.base - crossed(turn, axes.base))
    moved = motion.translation
    return replace(
        motion,
        translation=moved if moved is None else moved - crossed(turn, moved),
        up=motion.up - crossed(turn, motion.up),
        north=motion.north - crossed(turn, motion.north),
        rate=motion.rate + change[:, None] * direction - crossed(turn, outside),
        axes=axes,
    )


def crossed(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a × b for rows (n, 3); three times as fast as numpy's, which is general."""
    product = np.empty_like(a)
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    product[:, 0] = ay * bz - az * by
    product[:, 1] = az * bx - ax * bz
    product[:, 2] = ax * by - ay * bx
    return product
