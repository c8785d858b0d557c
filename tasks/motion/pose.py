"""The motion of a tracked body, from its poses: attitude and, where they were recorded, positions.

Frames that are missing are bridged where they are few; across a longer gap nothing is known, nor
near the ends of what was seen without one. The specific force of a body that moves needs its
positions. Without them it is known where the body rests, and nowhere else.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.motion.band import band_edge, derivatives, response, seen_by_gyros
from tasks.motion.pose_frames import (
    Frames,
    Stretch,
    added_turns,
    attitudes_at,
    frames_of,
    splined,
)
from tasks.motion.samples import interpolated

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

POINTS = 512
MARGIN = 1.5  # periods of the band's edge at either end whose motion is not known well enough
RESTING = 0.02  # rad that a body at rest turns at most within RESTING_TIME
RESTING_TIME = 1.0  # s
QUIET, QUIETEST = 3.0, 0.1  # times the accelerometers' scatter in the quietest tenth: still at rest
SHAKEN = 0.2  # m/s²: scatter that no rest has


@dataclass(frozen=True)
class Tracking:
    """The frequency, Hz, up to which poses determine the attitude and the place of a body.

    place: None if positions were not recorded. interval: s between frames. attitude_variance,
    place_variance: rad², m² of one frame on one axis, by what the smoothing removes.
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
    """The motion from poses at n times, NaN where unknown; vectors (n, 3) in the body's frame.

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
    course = _course_of(pose, recording.imu)
    if course is None:
        nothing = np.full((len(at), 3), np.nan)
        unknown = Tracking(np.inf, None, frames_of(pose).interval, 0.0, 0.0)
        return TrackedMotion(*(nothing,) * 5, tracking=unknown)
    return _motion_of(recording, course, at)


def motion_smoothed_twice(recording: Recording, pose: Stream, at: np.ndarray) -> TrackedMotion:
    """The motion at the times `at` (n,) s from poses that were already smoothed, in the same band.

    It differs from `tracked_motion` by about what smoothing removes from the motion itself.
    """
    course = _course_of(pose, recording.imu)
    if course is None:
        return tracked_motion(recording, pose, at)
    return _motion_of(recording, course.smoothed_again(), at)


def _motion_of(recording: Recording, course: "Course", at: np.ndarray) -> TrackedMotion:
    tracking = course.tracking
    courses = np.full((5, len(at), 3), np.nan)
    for stretch in course.parts:
        margin = MARGIN / tracking.edge
        rows = (at >= stretch.t[0] + margin) & (at <= stretch.t[-1] - margin)
        if rows.any():
            courses[:, rows] = stretch.at(at[rows])
    up, north, rate, acceleration, translation = courses
    if tracking.place is None:
        if recording.manifest.station.table_axes:  # what stands on a table stays in its place
            translation = np.where(np.isfinite(rate), 0.0, np.nan)
        else:
            rests = _rests(recording, course.frames)
            still = _at(rests, recording.imu.t, at)
            translation = np.where(still[:, None], np.zeros(3), np.nan)
    return TrackedMotion(up, north, rate, acceleration, translation, tracking)


@dataclass(frozen=True)
class SmoothStretch:
    """A stretch smoothed at its times t (n,) s.

    attitude: of the body in the room. rate: (n, 3) rad/s and its change, rad/s², in the body.
    place: (n, 3) m and bend, m/s², in the room; as it was, and unknown, without positions.
    """

    t: np.ndarray
    attitude: "Rotation"
    rate: np.ndarray
    change: np.ndarray
    place: np.ndarray
    bend: np.ndarray

    @classmethod
    def of(cls, stretch: Stretch, interval: float, tracking: Tracking) -> "SmoothStretch":
        smooth, rate, change = derivatives(stretch.turned, interval, tracking.attitude)
        place, bend = stretch.place, np.full((len(stretch.t), 3), np.nan)
        if tracking.place is not None:
            place, _, bend = derivatives(place, interval, tracking.place)
        return cls(stretch.t, _corrected(stretch, smooth), rate, change, place, bend)

    def at(self, at: np.ndarray) -> tuple[np.ndarray, ...]:
        """Vertical, north, rate, its change and translation (m, 3) each, at times (m,) s."""
        inwards = attitudes_at(at, self.t, self.attitude).inv()
        moved = inwards.apply(splined(at, self.t, self.bend))
        columns = inwards.as_matrix()
        rate, change = (splined(at, self.t, each) for each in (self.rate, self.change))
        return columns[:, :, 2], columns[:, :, 1], rate, change, moved


@dataclass(frozen=True)
class Course:
    """Frames, the frequency up to which they determine the motion, and their smoothed parts."""

    frames: Frames
    tracking: Tracking
    parts: tuple[SmoothStretch, ...]

    @classmethod
    def of(cls, frames: Frames, tracking: Tracking) -> "Course":
        parts = (SmoothStretch.of(each, frames.interval, tracking) for each in frames.spans)
        return cls(frames, tracking, tuple(parts))

    def smoothed_again(self) -> "Course":
        """The course of the smoothed stretches, in the same band."""
        spans = tuple(
            Stretch(each.t, each.attitude, added_turns(each.attitude), each.place)
            for each in self.parts
        )
        return Course.of(replace(self.frames, spans=spans), self.tracking)


@lru_cache(maxsize=2)  # a recording's motion is asked for again and again, at other times
def _course_of(pose: Stream, imu: Stream) -> Course | None:
    """None where hardly a frame was seen."""
    frames = frames_of(pose)
    return Course.of(frames, _tracking(frames, imu)) if frames.spans else None


def _tracking(frames: Frames, imu: Stream) -> Tracking:
    turned = [each.turned for each in frames.spans]
    edge = max(band_edge(turned, frames.interval), _seen_edge(frames, imu))
    attitude_variance = _removed(turned, frames.interval, edge)
    if not frames.placed:
        return Tracking(edge, None, frames.interval, attitude_variance, 0.0)
    places = [each.place for each in frames.spans]
    place = band_edge(places, frames.interval)
    place_variance = _removed(places, frames.interval, place)
    return Tracking(edge, place, frames.interval, attitude_variance, place_variance)


def _seen_edge(frames: Frames, imu: Stream) -> float:
    """Hz up to where the unit's gyros see the frames turn; 0: nowhere, or not known."""
    known = np.isfinite(imu.stack(GYRO)).all(axis=1) if set(GYRO) <= set(imu.columns) else ()
    if not np.any(known):
        return 0.0
    t, gyro = imu.t[known], imu.stack(GYRO)[known]
    spans = [each for each in frames.spans if t[0] <= each.t[0] and each.t[-1] <= t[-1]]
    gyros = [interpolated(each.t, t, gyro) for each in spans]
    seen = seen_by_gyros([each.turned for each in spans], gyros, frames.interval)
    return min(seen, 0.45 / float(np.median(np.diff(t))))


def _removed(courses: Sequence[np.ndarray], interval: float, edge: float) -> float:
    """Variance of one sample's noise of courses (n, 3), by what smoothing up to edge removes."""
    rest = np.concatenate([course - derivatives(course, interval, edge)[0] for course in courses])
    return float((rest**2).mean()) / taken_away(edge, interval)


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


def derivative_gain(order: int, edge: float, interval: float, width: float = 0.0) -> float:
    """Variance of a derivative, per s^order, of white noise of variance one in each sample.

    edge: Hz, where the smoothing's band ends. interval: s between samples. width: s that it is
    averaged over.
    """
    frequency = (np.arange(POINTS) + 0.5) / (2.0 * POINTS * interval)
    size = (2.0 * np.pi * frequency) ** order * response(frequency, edge)
    return float(((size * np.sinc(frequency * width)) ** 2).mean())


def taken_away(edge: float, interval: float) -> float:
    """Share of the variance of white noise that the smoothing takes away."""
    frequency = (np.arange(POINTS) + 0.5) / (2.0 * POINTS * interval)
    return float(((1.0 - response(frequency, edge)) ** 2).mean())
