"""The motion of a tracked body, from its poses: attitude and, where they were recorded, positions.

Frames that are missing are bridged where they are few; across a longer gap nothing is known, nor
near the ends of what was seen without one. The specific force of a body that moves needs its
positions. Without them it is known where the body rests, and nowhere else.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.fft import irfft, rfft, rfftfreq

from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.motion.samples import interpolated

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


# The frames of a tracked body: parts without a gap, resampled evenly.

POSE = ("qw", "qx", "qy", "qz")
PLACE = ("px", "py", "pz")
BRIDGED = 3.5  # intervals between two frames that a straight line may join
BATCHED = 0.5  # of the mean step between stamps: where most are closer, frames come in batches
FEWEST_FRAMES = 16  # frames without a gap whose motion is known


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


def frames_of(pose: Stream) -> Frames:
    """The frames of a stream of poses, put on an even grid."""
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
    if len(steps) < FEWEST_FRAMES or np.median(steps) > BATCHED * steps.mean():
        return t
    from scipy.ndimage import correlate1d  # late: few recordings have poses

    batch = max(2, round(len(steps) / max(1, int((steps > steps.mean()).sum()))))
    kernel = np.convolve(np.ones(batch), np.ones(batch)) / batch**2
    rows = np.arange(len(t))
    slope = (t[-1] - t[0]) / rows[-1]
    return slope * rows + np.asarray(correlate1d(t - slope * rows, kernel, mode="nearest"))


def _spans(pose: Stream, interval: float) -> Iterator[Stretch]:
    from scipy.spatial.transform import Rotation  # late: few recordings have a pose

    gaps = np.flatnonzero(np.diff(pose.t) > BRIDGED * interval) + 1
    for first, end in pairwise([0, *gaps.tolist(), len(pose.t)]):
        if end - first < FEWEST_FRAMES:
            continue
        part = pose.at(slice(first, end))
        # Stamps are rounded: the last of an even grid can lie a hair behind the last frame.
        t = np.minimum(np.arange(part.t[0], part.t[-1], interval), part.t[-1])
        measured = Rotation.from_quat(part.stack(POSE), scalar_first=True)
        attitude = attitudes_at(t, part.t, measured)
        place = splined(t, part.t, part.stack(PLACE))
        yield Stretch(t, attitude, added_turns(attitude), place)


def attitudes_at(at: np.ndarray, t: np.ndarray, attitude: "Rotation") -> "Rotation":
    """Attitudes at times `at` (m,) s between those at t (n,) s, along a cubic spline of the turns.

    A turn at a constant rate from one to the next would take dt²ω²/12 from what swings at ω.
    """
    from scipy.spatial.transform import Rotation, Slerp

    turned = added_turns(attitude)
    bent = splined(at, t, turned) - interpolated(at, t, turned)
    return Slerp(t, attitude)(at) * Rotation.from_rotvec(bent)


def splined(at: np.ndarray, t: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(m, k) at times `at` (m,) s, by a cubic spline through values (n, k) at times t (n,) s.

    Unknown where one of the values is, as positions are that were not recorded.
    """
    from scipy.interpolate import CubicSpline

    if not np.isfinite(values).all():
        return np.full((len(at), values.shape[1]), np.nan)
    return np.asarray(CubicSpline(t, values)(at))


def added_turns(attitude: "Rotation") -> np.ndarray:
    """(n, 3) rad, the small turns from attitude to attitude added up."""
    turns = (attitude[:-1].inv() * attitude[1:]).as_rotvec()
    return np.concatenate([np.zeros((1, 3)), np.cumsum(turns, axis=0)])


# Derivatives of a tracked pose, within the band where motion exceeds noise.
#
# The acceleration of a body falls off with frequency; that of a noise that is the same at all
# frequencies rises with its fourth power. Where the spectrum of both together is least they are
# about equal, and there the band ends. Above it nothing is known. The filter is that of Wiener
# for a motion that falls off with the eighth power, which is a smoothing spline's (Woltring, Adv.
# Eng. Softw. 8, 1986): h = 1/(1 + (f/f₀)⁸), without a shift in time. What it takes from the
# motion is filtered once more and put back (Tukey's twicing, Exploratory Data Analysis, 1977,
# 16): alone it takes half a percent at half the band, which a regression sees as a scale factor.

WINDOW = 4.0  # s: of the spectrum
LOWEST, HIGHEST = 0.5, 60.0  # Hz: bodies that are tracked move within
PER_OCTAVE = 3
NEAR_LEAST = 1.1  # times the least power above: the motion is no longer seen
DIFFERENCE_ROUNDING = 1e-9  # rad or m: second differences of less are arithmetic
SHARED = 0.8  # of the poses' power that gyros account for: noise is a quarter of the motion
FALL = 8  # power of the frequency with which one pass of the filter falls off


def band_edge(spans: Sequence[np.ndarray], interval: float) -> float:
    """Where the band ends, Hz, of courses (n, k) sampled evenly, each stretch without a gap.

    The lowest frequency, from that of the strongest motion up, whose power in the second
    derivative is no more than NEAR_LEAST times the least above it; the highest that is looked at
    where the motion is seen up to there.
    """
    from scipy.signal import welch  # late: few recordings have a pose

    bends = np.concatenate([np.diff(stretch, 2, axis=0) for stretch in spans])
    top = min(HIGHEST, 0.45 / interval)
    if np.sqrt((bends**2).mean()) < DIFFERENCE_ROUNDING:
        return top
    length = min(round(WINDOW / interval), len(bends))
    frequency, power = welch(bends, 1.0 / interval, nperseg=length, axis=0)
    # What a second difference makes of a frequency, beside a second derivative.
    reach = np.maximum(2.0 * np.sin(np.pi * frequency * interval), 1e-12)
    power = power.sum(axis=1) * (2.0 * np.pi * frequency / reach) ** 4
    count = max(2, round(PER_OCTAVE * np.log2(top / LOWEST)))
    edges = np.geomspace(LOWEST, top, count + 1)
    which = np.searchsorted(edges, frequency) - 1
    bands = [k for k in range(count) if (which == k).any()]
    middle = np.sqrt(edges[:-1] * edges[1:])[bands]
    level = np.array([power[which == k].mean() for k in bands])
    strongest = int(np.argmax(level / middle**5))
    least = np.minimum.accumulate(level[::-1])[::-1]
    ends = np.flatnonzero(level <= NEAR_LEAST * least)
    return float(middle[ends[ends >= strongest][0]])


def seen_by_gyros(
    turned: Sequence[np.ndarray], gyros: Sequence[np.ndarray], interval: float
) -> float:
    """Hz up to where the gyros (n, 3) see the turns (n, 3) of the same stretches; 0: nowhere.

    By the multiple coherence of the turns' rates with the three gyros (Bendat, Piersol, Random
    Data, 2010, 7.3), which neither axes, scale factors nor a delay change: up to where the power
    that both have in common exceeds SHARED of all by most. The poses' noise may have any spectrum.
    """
    length = round(WINDOW / interval)
    window = np.hanning(length)[:, None]
    count = length // 2 + 1
    power, crossed = (np.zeros((count, 3, 3), complex) for _ in range(2))
    own = np.zeros(count)
    for course, read in zip(turned, gyros, strict=True):
        rates = np.gradient(course, interval, axis=0)
        for first in range(0, len(course) - length + 1, max(1, length // 2)):
            rows = slice(first, first + length)
            x, y = (rfft(window * (each[rows] - each[rows].mean(axis=0)), axis=0)
                    for each in (read, rates))  # fmt: skip
            power += x.conj()[:, :, None] * x[:, None, :]
            crossed += x.conj()[:, :, None] * y[:, None, :]
            own += (np.abs(y) ** 2).sum(axis=1)
    frequency = rfftfreq(length, interval)
    top, gain = min(HIGHEST, 0.45 / interval), [0.0]
    edges = np.geomspace(LOWEST, top, max(2, round(PER_OCTAVE * np.log2(top / LOWEST))) + 1)
    for low, high in pairwise(edges):
        rows = (frequency >= low) & (frequency < high)
        a, b = power[rows].sum(axis=0), crossed[rows].sum(axis=0)
        shared = np.einsum("ik,ik->", b.conj(), np.linalg.lstsq(a, b, rcond=None)[0]).real
        gain.append(gain[-1] + shared - SHARED * own[rows].sum())
    best = int(np.argmax(gain))  # a band without motion between two that have some costs little
    return float(np.sqrt(edges[best - 1] * edges[best])) if best else 0.0


def response(frequency: np.ndarray, edge: float) -> np.ndarray:
    """What the filter passes of each frequency, Hz, for a band up to `edge` Hz: h + h (1 − h)."""
    once = 1.0 / (1.0 + (frequency / edge) ** FALL)
    return np.asarray(once * (2.0 - once))


def derivatives(
    values: np.ndarray, interval: float, edge: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Smoothed values (n, k), first and second derivative per s and s², of an even course.

    Beyond its ends the course is taken to go on turned by half a turn, so that value and slope are
    right there and the second derivative is not: within about two periods of the band's edge.
    """
    count = len(values)
    slope = (values[-1] - values[0]) / (count - 1)
    line = values[0] + slope * np.arange(count)[:, None]
    course = values - line
    ring = np.concatenate([course, -course[-2:0:-1]])
    spectrum, frequency = rfft(ring, axis=0), rfftfreq(len(ring), interval)
    turn = (2.0j * np.pi * frequency)[:, None]
    passed = response(frequency, edge)[:, None] * spectrum
    smooth, first, second = (
        irfft(passed * turn**order, len(ring), axis=0)[:count] for order in (0, 1, 2)
    )
    return smooth + line, first + slope / interval, second


POINTS = 512
MARGIN = 1.5  # periods of the band's edge at either end whose motion is not known well enough
RESTING = 0.02  # rad that a body at rest turns at most within RESTING_TIME
RESTING_TIME = 1.0  # s
STILL_SCATTER, QUIETEST = 3.0, 0.1  # times the accelerometers' in the quietest tenth: at rest
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
    attitude_variance = noise_variance(turned, frames.interval, edge)
    if not frames.placed:
        return Tracking(edge, None, frames.interval, attitude_variance, 0.0)
    places = [each.place for each in frames.spans]
    place = band_edge(places, frames.interval)
    place_variance = noise_variance(places, frames.interval, place)
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


def noise_variance(courses: Sequence[np.ndarray], interval: float, edge: float) -> float:
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
    return np.asarray(
        rests & (shake <= min(SHAKEN, STILL_SCATTER * float(np.quantile(shake, QUIETEST))))
    )


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
