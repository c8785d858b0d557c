"""A recording as `explain` sees it: readings and motion as means over even blocks of time.

Blocks keep every sample's information below half their rate and make the cost of the search
independent of the sampling rate. Rates, forces and angular accelerations are averaged from the
full rate, so that the corners of a ramp are not missed.
"""

from dataclasses import dataclass, replace

import numpy as np

from schemas.base import Unusable
from schemas.recording import ACCEL, GYRO, Recording, Segment
from tasks.motion.nudge import slope
from tasks.motion.whole import Motion, whole_motion
from tasks.segments.find import find_segments

CHANNELS = GYRO + ACCEL
SEARCH_RATE = 25.0  # Hz
FEWEST_BLOCKS = 200
SAMPLE = 50_000  # readings that the output's step is read off
WHOLE, MOSTLY = 0.02, 0.9  # changes are whole steps within this, nine in ten of them
STIRRED = 0.5  # of the readings differ from the one before: noise is larger than the step
SHAKEN = 1.3  # times the noise variance at rest: vibration
CORNER = 0.05  # of a fourth difference: error of a block mean at a corner of the motion
AT_REST = 1e-3  # rad/s
SETTLE = 20.0  # s over which the unit's temperature is smoothed before it is differentiated


@dataclass(frozen=True)
class Observed:
    """Readings and motion on even blocks.

    t: (n,) s from the start of the run, block centres. readings: (n, 6); 0 where not used.
    weight: (n, 6) root of the weight of a block, 1 for a full one at rest, 0: not used.
    motion: at the blocks, with all that was recorded. rate: blocks a second.
    segment: (n,) index into `segments`, −1 between them. rounding: (6,) variance of a block that
    the output's step makes by itself.
    """

    t: np.ndarray
    readings: np.ndarray
    weight: np.ndarray
    motion: Motion
    rate: float
    segment: np.ndarray
    segments: tuple[Segment, ...]
    rounding: np.ndarray


@dataclass(frozen=True)
class FullRate:
    """The recording at the unit's own rows: readings (n, 6), motion with what was recorded.

    segment: (n,) index into `segments`, −1 between them. shaking: (segments + 1, 2) variance of
    a sample's noise in each, by triad; last: between them. steps: (6,) of the outputs as they
    were read; stirred: (6,) bool, noise is larger, so that means are finer than steps.
    """

    readings: np.ndarray
    motion: Motion
    segment: np.ndarray
    segments: tuple[Segment, ...]
    shaking: np.ndarray
    steps: np.ndarray
    stirred: np.ndarray

    @property
    def quiet(self) -> np.ndarray:
        """(2,) variance of a sample's noise at rest, by triad; 1 where it is not known."""
        least = np.min(np.where(np.isfinite(self.shaking), self.shaking, np.inf), axis=0)
        usual = [_median(course) for course in self.shaking.T]
        rounded = np.array([self.steps[:3].max(), self.steps[3:].max()]) ** 2 / 12.0
        level = np.maximum(np.minimum(usual, 1.3 * least), rounded)
        return np.asarray(np.where(np.isfinite(level) & (level > 0), level, 1.0))


def full_rate(recording: Recording) -> FullRate:
    """Motion and readings at the unit's rows.

    Raises Unusable where the recording has no rates and forces, or tells no motion.
    """
    if not set(CHANNELS) & set(recording.imu.columns):
        raise Unusable(
            f"recording {recording.manifest.recording_id} has no gyro_* or accel_* columns; "
            "explain needs rates or specific forces"
        )
    readings = recording.imu.stack(CHANNELS)
    motion = whole_motion(recording)
    if not motion.known.any():
        raise Unusable(
            f"recording {recording.manifest.recording_id} tells no motion: no table stream with "
            "table_axes, no reference pose and no labelled segments; give one of them"
        )
    # A motion that is unknown in places (labels only) must not reach into its neighbours.
    segments = recording.manifest.segments or find_segments(recording)
    number = _numbers(recording.imu.t, segments)
    variance = _noise_by_segment(readings, motion, number, len(segments))
    recorded = _recorded(recording, motion.t, segments)
    recorded["vibration"] = _vibration(
        variance, number, np.linalg.norm(np.nan_to_num(motion.rate), axis=1)
    )
    motion = replace(motion, t=motion.t - motion.t[0], recorded=recorded)
    return FullRate(readings, motion, number, segments, variance, *_steps(readings))


def in_blocks(full: FullRate, rate: float, masked: np.ndarray | None = None) -> Observed:
    """Block means at a rate (Hz), or the rows themselves where they are slower.

    masked: (n, 6) bool, samples that must not be used.
    """
    t = full.motion.t
    own = 1.0 / max(float(np.median(np.diff(t))), 1e-9)
    step = max(1, round(own / rate))
    block = ((t + 0.5 / own) * own / step).astype(int)
    count = int(block[-1]) + 1
    if count < FEWEST_BLOCKS:
        raise Unusable(
            f"the recording lasts {t[-1]:.1f} s; explain needs {FEWEST_BLOCKS / rate:.0f} s or more"
        )
    usable = np.isfinite(full.readings) & full.motion.known[:, None]
    if masked is not None:
        usable &= ~masked
    rows = np.bincount(block, minlength=count)
    counts = np.column_stack([np.bincount(block, used, count) for used in usable.T.astype(float)])
    readings = _means(np.where(usable, full.readings, 0.0), block, count, counts)
    motion = _block_motion(full.motion, block, count, rows, step / own)
    weight = np.sqrt(counts / step) * _relative(full, block, count)
    weight /= np.sqrt(1.0 + _corners(motion) / _noise_of_blocks(full, step))
    weight[~motion.known] = 0.0
    first = np.searchsorted(block, np.arange(count))
    segment = full.segment[np.minimum(first, len(block) - 1)]
    rounding = full.steps**2 / 12.0 / np.where(full.stirred, step, 1)
    return Observed(
        motion.t, readings, weight, motion, own / step, segment, full.segments, rounding
    )


def _steps(readings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(6,) steps of the outputs, 0 where there are none, and whether noise is larger than them."""
    steps, stirred = np.zeros(6), np.ones(6, bool)
    for channel, course in enumerate(readings.T):
        changes = np.abs(np.diff(course[np.isfinite(course)][:SAMPLE]))
        moved = changes[changes > 0]
        if not len(moved):
            continue
        least = float(np.quantile(moved, 0.01))
        parts = moved / least
        if np.mean(np.abs(parts - np.round(parts)) < WHOLE * np.maximum(1.0, parts)) > MOSTLY:
            steps[channel] = least
            stirred[channel] = len(moved) > STIRRED * len(changes)
    return steps, stirred


def _means(values: np.ndarray, block: np.ndarray, count: int, counts: np.ndarray) -> np.ndarray:
    sums = np.column_stack([np.bincount(block, column, count) for column in values.T])
    return np.divide(sums, counts, out=np.zeros_like(sums), where=counts > 0)


def _block_motion(
    motion: Motion, block: np.ndarray, count: int, rows: np.ndarray, width: float
) -> Motion:
    """Means of everything that is known; a block without rows repeats nothing: it is unknown."""

    def mean(values: np.ndarray) -> np.ndarray:
        flat = values.reshape(len(values), -1)
        sums = np.column_stack([np.bincount(block, column, count) for column in flat.T])
        with np.errstate(invalid="ignore"):
            means = sums / np.where(rows > 0, rows, np.nan)[:, None]
        return np.asarray(means.reshape(count, *values.shape[1:]))

    axes = motion.axes and replace(
        motion.axes,
        **{
            name: mean(getattr(motion.axes, name))
            for name in ("angles", "speeds", "directions", "base")
        },
    )
    recorded = {name: mean(course) for name, course in motion.recorded.items()}
    recorded["fixing"] = np.round(recorded["fixing"])  # a number, not a mean of two
    return Motion(
        t=(np.arange(count) + 0.5) * width - 0.5 * width / max(1, round(rows.max())),
        up=mean(motion.up),
        north=mean(motion.north),
        rate=mean(motion.rate),
        acceleration=mean(motion.acceleration),
        gravity=motion.gravity,
        axes=axes,
        recorded=recorded,
    )


def _numbers(t: np.ndarray, segments: tuple[Segment, ...]) -> np.ndarray:
    """Which segment each row lies in, −1 for none."""
    number: np.ndarray = np.full(len(t), -1)
    for k, segment in enumerate(segments):
        start, stop = np.searchsorted(t, (segment.t_start, segment.t_end))
        number[start:stop] = k
    return number


def _noise_by_segment(
    readings: np.ndarray, motion: Motion, number: np.ndarray, count: int
) -> np.ndarray:
    """(count + 1, 2) variance of a sample's noise in each segment, by triad; last: between them.

    From second differences of what a straight-line fit leaves, by their median, so that neither
    motion nor single bad samples count.
    """
    left = readings - plain_prediction(readings, motion)
    rough = np.full_like(left, np.nan)
    rough[1:-1] = np.diff(left, 2, axis=0) ** 2 / 6.0
    variance = np.full((count + 1, 2), np.nan)
    for k in range(-1, count):
        rows = np.flatnonzero(number == k)
        if len(rows) < 30:
            continue
        rows = rows[:: 1 + len(rows) // 4000]
        for triad in range(2):
            part = rough[rows, 3 * triad : 3 * triad + 3]
            part = part[np.isfinite(part)]
            if len(part):
                variance[k, triad] = np.median(part) / 0.4549
    return variance


def plain_prediction(readings: np.ndarray, motion: Motion) -> np.ndarray:
    """(n, 6) what the standard's model says, fitted by plain least squares to all rows."""
    up, rate = np.nan_to_num(motion.up), np.nan_to_num(motion.rate)
    one = np.ones((len(up), 1))
    predicted = np.full(readings.shape, np.nan)
    for channel in range(6):
        columns = np.hstack([rate, up, one]) if channel < 3 else np.hstack([up, rate**2, one])
        rows = np.isfinite(readings[:, channel]) & motion.known
        if not rows.any():
            continue
        scale = np.sqrt((columns[rows] ** 2).mean(axis=0)) + 1e-12
        scaled = columns / scale
        normal = scaled[rows].T @ scaled[rows]
        right = scaled[rows].T @ readings[rows, channel]
        predicted[:, channel] = scaled @ (np.linalg.pinv(normal, rcond=1e-10) @ right)
    return predicted


def _median(course: np.ndarray) -> float:
    known = course[np.isfinite(course)]
    return float(np.median(known)) if len(known) else np.inf


def _relative(full: FullRate, block: np.ndarray, count: int) -> np.ndarray:
    """(count, 6) root weight by the noise of the segment, 1 at rest."""
    first = np.minimum(np.searchsorted(block, np.arange(count)), len(block) - 1)
    variance = full.shaking
    floor = full.quiet
    ratio = np.where(np.isfinite(variance), variance / np.where(floor > 0, floor, 1.0), 1.0)
    ratio = np.where(ratio > SHAKEN, ratio, 1.0)
    return np.asarray(np.repeat(1.0 / np.sqrt(ratio), 3, axis=1)[full.segment[first]])


def _corners(motion: Motion) -> np.ndarray:
    """(n, 6) squared error of a block's rate and force where the motion has a corner.

    Samples do not tell when within their interval a table begins to accelerate; a fourth
    difference is large there and nowhere else.
    """
    rough = np.zeros((len(motion.t), 6))
    for first, course in ((0, motion.rate), (3, motion.force)):
        fourth = np.abs(np.diff(_bridged(course), 4, axis=0)).max(axis=1)
        near = np.zeros(len(motion.t))
        for shift in range(5):
            rows = slice(shift, shift + len(fourth))
            near[rows] = np.maximum(near[rows], fourth)
        rough[:, first : first + 3] = ((CORNER * near) ** 2)[:, None]
    return rough


def _bridged(course: np.ndarray) -> np.ndarray:
    """A course (n, 3) that goes straight on where it is not known."""
    known = np.isfinite(course).all(axis=1)
    if known.all() or not known.any():
        return np.nan_to_num(course)
    rows = np.arange(len(course))
    return np.column_stack([np.interp(rows, rows[known], c[known]) for c in course.T])


def _noise_of_blocks(full: FullRate, step: int) -> np.ndarray:
    """(6,) variance of a block at rest."""
    return full.quiet.repeat(3) / step


def _vibration(variance: np.ndarray, number: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """(n,) mean square of the accelerometers' noise beyond that at rest, by the speed it has.

    variance: (segments, 2); number: (n,) segment of each row; speed: (n,) rad/s.
    """
    seen = [k for k in range(len(variance) - 1) if np.isfinite(variance[k, 1])]
    if not seen:
        return np.zeros(len(number))
    speeds = np.array([float(np.median(speed[number == k])) for k in seen])
    resting = speeds < AT_REST
    quiet = float(np.median(variance[seen, 1][resting if resting.any() else slice(None)]))
    order = np.argsort(speeds)
    beyond = np.maximum(variance[seen, 1] - quiet, 0.0)
    turning = order[speeds[order] >= AT_REST]
    return np.interp(speed, np.append(0.0, speeds[turning]), np.append(0.0, beyond[turning]))


def _recorded(
    recording: Recording, t: np.ndarray, segments: tuple[Segment, ...]
) -> dict[str, np.ndarray]:
    """What sensors of unit and room recorded, at the unit's rows, and which fixing it was."""
    recorded = {}
    if "temperature" in recording.imu.columns:
        recorded["temperature"] = recording.imu.columns["temperature"]
    if (room := recording.environment) is not None:
        for name, course in room.columns.items():
            key = "air_temperature" if name == "temperature" else name
            recorded[key] = np.interp(t, room.t, course)
    if "temperature" in recorded:
        recorded["temperature"] = _filled(recorded["temperature"])
        recorded["temperature_rate"] = _smooth_slope(t, recorded["temperature"])
    recorded["fixing"] = _fixings(recording, t, segments)
    recorded["steady_turn"] = np.zeros(len(t))
    for segment in segments:
        if segment.kind == "rate":
            start, stop = np.searchsorted(recording.imu.t, (segment.t_start, segment.t_end))
            recorded["steady_turn"][start:stop] = 1.0
    return recorded


def _filled(course: np.ndarray) -> np.ndarray:
    known = np.isfinite(course)
    rows = np.arange(len(course))
    return np.interp(rows, rows[known], course[known]) if known.any() else np.zeros(len(course))


def _smooth_slope(t: np.ndarray, course: np.ndarray) -> np.ndarray:
    """Derivative by differences of means over SETTLE."""
    grid = np.arange(t[0], t[-1] + SETTLE, SETTLE / 4)
    cells = np.clip(np.searchsorted(grid, t, "right") - 1, 0, len(grid) - 1)
    counts = np.maximum(np.bincount(cells, minlength=len(grid)), 1)
    means = np.bincount(cells, course, len(grid)) / counts
    held = counts > 1
    means = np.interp(np.arange(len(grid)), np.flatnonzero(held), means[held])
    kernel = np.ones(5) / 5
    padded = np.concatenate([2 * means[0] - means[4:0:-1], means, 2 * means[-1] - means[-2:-6:-1]])
    smooth = np.convolve(np.convolve(padded, kernel, "valid"), kernel, "valid")
    return np.interp(t, grid + SETTLE / 8, slope(grid, smooth))


def _fixings(recording: Recording, t: np.ndarray, segments: tuple[Segment, ...]) -> np.ndarray:
    """Number of the fixing at each row: blocks of the procedure between which a unit is re-fixed.

    The positions on a table of several axes are one; each upright axis of the rates is another. A
    unit is fixed anew right after the last segment of a block, before the move to the next.
    """
    several = len(recording.manifest.station.table_axes or ()) > 1
    number: np.ndarray = np.zeros(len(t))
    at, last, ended = 0, None, 0.0
    for segment in segments:
        if segment.up is None:
            continue
        block = "positions" if several and segment.item == "twelve_position" else segment.up
        if last is not None and block != last:
            at += 1
            number[np.searchsorted(t, ended) :] = at
        last, ended = block, segment.t_end
    return number
