"""A recording as `explain` sees it: readings and motion as means over even blocks of time.

Blocks keep every sample's information below half their rate and make the cost of the search
independent of the sampling rate. Rates, forces and angular accelerations are averaged from the
full rate, so that the corners of a ramp are not missed.
"""

from dataclasses import dataclass, replace

import numpy as np

from schemas.base import Unusable
from schemas.recording import ACCEL, GYRO, Recording, Segment
from tasks.explain.inputs.corners import corners
from tasks.explain.inputs.recorded_signals import recorded_courses, vibration
from tasks.explain.inputs.sample_noise import noise_by_segment, output_steps
from tasks.motion.whole import Motion, whole_motion
from tasks.segments.find import find_segments

CHANNELS = GYRO + ACCEL
SEARCH_RATE = 25.0  # Hz
FEWEST_BLOCKS = 200
SHAKEN = 1.3  # times the noise variance at rest: vibration


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
    variance = noise_by_segment(readings, motion, number, len(segments))
    recorded = recorded_courses(recording, motion.t, segments)
    recorded["vibration"] = vibration(
        variance, number, np.linalg.norm(np.nan_to_num(motion.rate), axis=1)
    )
    motion = replace(motion, t=motion.t - motion.t[0], recorded=recorded)
    return FullRate(readings, motion, number, segments, variance, *output_steps(readings))


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
    weight /= np.sqrt(1.0 + corners(motion) / _noise_of_blocks(full, step))
    weight[~motion.known] = 0.0
    first = np.searchsorted(block, np.arange(count))
    segment = full.segment[np.minimum(first, len(block) - 1)]
    rounding = full.steps**2 / 12.0 / np.where(full.stirred, step, 1)
    return Observed(
        motion.t, readings, weight, motion, own / step, segment, full.segments, rounding
    )


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


def _noise_of_blocks(full: FullRate, step: int) -> np.ndarray:
    """(6,) variance of a block at rest."""
    return full.quiet.repeat(3) / step
