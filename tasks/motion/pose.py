"""The motion of a tracked body, from its poses: attitude and, where they were recorded, positions.

Frames that are missing are bridged where they are few; across a longer gap nothing is known, nor
near the ends of what was seen without one. The specific force of a body that moves needs its
positions. Without them it is known where the body rests, and nowhere else.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from schemas.recording import ACCEL, Recording, Stream
from tasks.motion.band import band_edge, derivatives
from tasks.motion.motion_noise import derivative_gain, taken_away
from tasks.motion.samples import interpolated

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

POSE = ("qw", "qx", "qy", "qz")
PLACE = ("px", "py", "pz")
BRIDGED = 3.5  # intervals between two frames that a straight line may join
BATCHED = 0.5  # of the mean step between stamps: where most are closer, frames come in batches
FEWEST = 16  # frames without a gap whose motion is known
MARGIN = 0.5  # periods of the band's edge at either end that are not
RESTING = 0.02  # rad that a body at rest turns at most within RESTING_TIME
RESTING_TIME = 1.0  # s
QUIET, QUIETEST = 3.0, 0.1  # times the accelerometers' scatter in the quietest tenth: still at rest
SHAKEN = 0.2  # m/s²: scatter that no rest has


@dataclass(frozen=True)
class Tracking:
    """Up to which frequency, Hz, poses tell the attitude and the place of a body.

    place: None where positions were not recorded. interval: s between frames. attitude_variance,
    place_variance: rad², m² of one frame on one axis, by what the smoothing takes away.
    """

    attitude: float
    place: float | None
    interval: float
    attitude_variance: float
    place_variance: float

    @property
    def edge(self) -> float:
        """Hz: up to there they tell whatever they tell."""
        return min(self.attitude, self.attitude if self.place is None else self.place)

    def rate_variance(self, width: float) -> float:
        """(rad/s)² of a rate on one axis, averaged over `width` s."""
        gain = derivative_gain(1, self.attitude, self.interval, width)
        return self.attitude_variance * gain

    @property
    def acceleration_variance(self) -> float:
        """(rad/s²)² of an angular acceleration on one axis."""
        return self.attitude_variance * derivative_gain(2, self.attitude, self.interval)

    def force_variance(self, width: float, gravity: float) -> float:
        """(m/s²)² of a specific force on one axis, averaged over `width` s."""
        gain = derivative_gain(0, self.attitude, self.interval, width)
        leaning = gravity**2 * self.attitude_variance * gain
        if self.place is None:
            return leaning
        pushed = derivative_gain(2, self.place, self.interval, width)
        return leaning + self.place_variance * pushed


@dataclass(frozen=True)
class TrackedMotion:
    """What poses tell at n times, NaN where nothing; vectors (n, 3) in the body's frame.

    up, north: unit vectors. rate: rad/s. acceleration: rad/s². translation: m/s², kinematic.
    """

    up: np.ndarray
    north: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray
    translation: np.ndarray
    tracking: Tracking


def tracked_motion(recording: Recording, pose: Stream, at: np.ndarray) -> TrackedMotion:
    """The motion at the times `at` (n,) s; all of it unknown where hardly a frame was seen."""
    frames = _frames(pose)
    if not frames.spans:
        nothing = np.full((len(at), 3), np.nan)
        unknown = Tracking(np.inf, None, frames.interval, 0.0, 0.0)
        return TrackedMotion(*(nothing,) * 5, tracking=unknown)
    return _motion_of(recording, frames, _tracking(frames), at)


def motion_smoothed_twice(recording: Recording, pose: Stream, at: np.ndarray) -> TrackedMotion:
    """The motion at the times `at` (n,) s of poses that were smoothed before, in the same band.

    It differs from `tracked_motion` by about what smoothing takes off the motion itself. There
    must be frames.
    """
    frames = _frames(pose)
    tracking = _tracking(frames)
    smooth = tuple(_smoothed(stretch, frames.interval, tracking) for stretch in frames.spans)
    return _motion_of(recording, replace(frames, spans=smooth), tracking, at)


def _motion_of(
    recording: Recording, frames: "Frames", tracking: Tracking, at: np.ndarray
) -> TrackedMotion:
    courses = np.full((5, len(at), 3), np.nan)
    for stretch in frames.spans:
        margin = MARGIN / tracking.edge
        rows = (at >= stretch.t[0] + margin) & (at <= stretch.t[-1] - margin)
        if rows.any():
            courses[:, rows] = _within(stretch, frames.interval, tracking, at[rows])
    up, north, rate, acceleration, translation = courses
    if tracking.place is None:
        if recording.manifest.station.table_axes:  # what stands on a table stays in its place
            translation = np.where(np.isfinite(rate), 0.0, np.nan)
        else:
            rests = _rests(recording, frames)
            translation = np.where(_at(rests, recording.imu.t, at)[:, None], 0.0, np.nan)
    return TrackedMotion(up, north, rate, acceleration, translation, tracking)


@dataclass(frozen=True)
class Stretch:
    """Frames without a gap, at even times t (n,) s.

    attitude: of the frames as they are. turned: (n, 3) rad, its small turns added up. place: m.
    """

    t: np.ndarray
    attitude: "Rotation"
    turned: np.ndarray
    place: np.ndarray


@dataclass(frozen=True)
class Frames:
    """Stretches of frames, the time between two of them, s, and whether they have positions."""

    spans: tuple[Stretch, ...]
    interval: float
    placed: bool


def _frames(pose: Stream) -> Frames:
    pose = replace(pose, t=_even_stamps(pose.t))
    interval = float(np.median(np.diff(pose.t))) if len(pose.t) > 1 else 1.0
    placed = set(PLACE) <= set(pose.columns)
    return Frames(tuple(_spans(pose, interval)), interval, placed)


def _even_stamps(t: np.ndarray) -> np.ndarray:
    """When frames stamped t (n,) s were taken, where a host stamps them in batches.

    Most stamps are then closer together than frames come, and each batch ends in a long step; the
    mean over as many as a batch has is free of it.
    """
    steps = np.diff(t)
    if len(steps) < FEWEST or np.median(steps) > BATCHED * steps.mean():
        return t
    from scipy.ndimage import correlate1d  # late: few recordings have poses

    batch = max(2, round(len(steps) / max(1, int((steps > steps.mean()).sum()))))
    kernel = np.convolve(np.ones(batch), np.ones(batch)) / batch**2
    rows = np.arange(len(t))
    slope = (t[-1] - t[0]) / rows[-1]
    return slope * rows + np.asarray(correlate1d(t - slope * rows, kernel, mode="nearest"))


def _spans(pose: Stream, interval: float) -> Iterator[Stretch]:
    from scipy.spatial.transform import Rotation, Slerp  # late: few recordings have a pose

    gaps = np.flatnonzero(np.diff(pose.t) > BRIDGED * interval) + 1
    for first, end in pairwise([0, *gaps.tolist(), len(pose.t)]):
        if end - first < FEWEST:
            continue
        part = pose.at(slice(first, end))
        # Stamps are rounded: the last of an even grid can lie a hair behind the last frame.
        t = np.minimum(np.arange(part.t[0], part.t[-1], interval), part.t[-1])
        measured = Rotation.from_quat(part.stack(POSE), scalar_first=True)
        attitude = Slerp(part.t, measured)(t)
        place = interpolated(t, part.t, part.stack(PLACE))
        yield Stretch(t, attitude, _turned(attitude), place)


def _turned(attitude: "Rotation") -> np.ndarray:
    """(n, 3) rad, the small turns from attitude to attitude added up."""
    turns = (attitude[:-1].inv() * attitude[1:]).as_rotvec()
    return np.concatenate([np.zeros((1, 3)), np.cumsum(turns, axis=0)])


def _tracking(frames: Frames) -> Tracking:
    attitude, attitude_variance = _smoothing(
        [each.turned for each in frames.spans], frames.interval
    )
    if not frames.placed:
        return Tracking(attitude, None, frames.interval, attitude_variance, 0.0)
    place, place_variance = _smoothing([each.place for each in frames.spans], frames.interval)
    return Tracking(attitude, place, frames.interval, attitude_variance, place_variance)


def _smoothing(courses: Sequence[np.ndarray], interval: float) -> tuple[float, float]:
    """Where the band of courses (n, 3) ends, Hz, and the variance of one sample's noise."""
    edge = band_edge(courses, interval)
    rest = np.concatenate([course - derivatives(course, interval, edge)[0] for course in courses])
    return edge, float((rest**2).mean()) / taken_away(edge, interval)


def _within(
    stretch: Stretch, interval: float, tracking: Tracking, at: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Vertical, north, rate, its change and translation (n, 3) each, within one stretch."""
    from scipy.spatial.transform import Slerp

    smooth, rate, change = derivatives(stretch.turned, interval, tracking.attitude)
    attitude = _corrected(stretch, smooth)
    inwards = Slerp(stretch.t, attitude)(at).inv()
    moved = np.full((len(at), 3), np.nan)
    if tracking.place is not None:
        *_, bend = derivatives(stretch.place, interval, tracking.place)
        moved = inwards.apply(interpolated(at, stretch.t, bend))
    columns = inwards.as_matrix()
    rate, change = (interpolated(at, stretch.t, each) for each in (rate, change))
    return columns[:, :, 2], columns[:, :, 1], rate, change, moved


def _smoothed(stretch: Stretch, interval: float, tracking: Tracking) -> Stretch:
    """The stretch with attitudes and places as smoothing leaves them."""
    attitude = _corrected(stretch, derivatives(stretch.turned, interval, tracking.attitude)[0])
    place = stretch.place
    if tracking.place is not None:
        place = derivatives(place, interval, tracking.place)[0]
    return Stretch(stretch.t, attitude, _turned(attitude), place)


def _corrected(stretch: Stretch, smooth: np.ndarray) -> "Rotation":
    """The stretch's attitudes, turned on from their added turns to smooth ones (n, 3) rad."""
    from scipy.spatial.transform import Rotation

    return stretch.attitude * Rotation.from_rotvec(smooth - stretch.turned)


def _rests(recording: Recording, frames: Frames) -> np.ndarray:
    """(n,) bool at the unit's rows: neither the poses turn nor the accelerometers shake."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d, uniform_filter1d

    t = recording.imu.t
    rests, width = np.zeros(len(t), bool), max(3, round(RESTING_TIME / frames.interval))
    for stretch in frames.spans:
        reach = maximum_filter1d(stretch.turned, width, axis=0)
        reach -= minimum_filter1d(stretch.turned, width, axis=0)
        still = reach.max(axis=1) < RESTING
        rests |= _at(still, stretch.t, t) & (t >= stretch.t[0]) & (t <= stretch.t[-1])
    accel = np.nan_to_num(recording.imu.stack(ACCEL))
    rows = max(3, round(RESTING_TIME / float(np.median(np.diff(t)))))
    accel = accel - accel.mean(axis=0)
    variance = uniform_filter1d(accel**2, rows, axis=0) - uniform_filter1d(accel, rows, axis=0) ** 2
    shake = np.sqrt(np.maximum(variance, 0.0).sum(axis=1))
    return np.asarray(rests & (shake <= min(SHAKEN, QUIET * float(np.quantile(shake, QUIETEST)))))


def _at(flags: np.ndarray, t: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Flags (n,) at times t, as they are at the nearest of them: (m,) bool."""
    return np.asarray(np.interp(at, t, flags.astype(float)) > 0.5)
