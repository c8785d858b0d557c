"""Readings and motion as means over even blocks of time.

Blocks keep every sample's information below half their rate and make the cost of the search
independent of the sampling rate. Rates, forces and angular accelerations are averaged from the
full rate, so that the corners of a ramp are not missed.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from schemas.base import Unusable
from schemas.recording import Recording, Segment
from tasks.explain.explanation import CHANNELS
from tasks.explain.inputs.reference import (
    clock_remarks,
    reference_remarks,
    with_seen_places,
    with_usable_labels,
)
from tasks.explain.inputs.signals import (
    noise_by_segment,
    output_steps,
    recorded_signals,
    vibration,
    with_gyro_acceleration,
)
from tasks.motion.pose import Tracking
from tasks.motion.reference_noise import EXACT, ReferenceNoise, reference_noise
from tasks.motion.samples import bridged, longest_step
from tasks.motion.whole import Motion, whole_motion
from tasks.readings.plausibility import runs
from tasks.segments.find import find_segments
from tasks.words import Sayable

# A recording at the unit's own rows: readings, motion, segments and the noise of samples.

NEAR_LEAST = 1.3  # times the least variance of a segment: still at rest


@dataclass(frozen=True)
class FullRate:
    """The recording at the unit's own rows: readings (n, 6), and the motion with recorded signals.

    segment: (n,) index into `segments`, −1 between them. segment_variance: (segments + 1, 2) noise
    variance of a sample in each, by triad; last: between them. steps: (6,) of the outputs;
    dithered: (6,) bool, noise is larger, so that means are finer than steps. start: of the motion's
    t = 0 on the recording's own clock, s. remarks: on the reference. reference_noise: errors of its
    predictions. span: s over which each row is a mean.
    """

    readings: np.ndarray
    motion: Motion
    segment: np.ndarray
    segments: tuple[Segment, ...]
    segment_variance: np.ndarray
    steps: np.ndarray
    dithered: np.ndarray
    start: float = 0.0
    remarks: tuple[Sayable, ...] = ()
    reference_noise: ReferenceNoise = EXACT
    span: float = 0.0

    @property
    def rest_variance(self) -> np.ndarray:
        """(6,) variance of a sample's noise at rest, of one triad the same; 1 if not known."""
        known = np.where(np.isfinite(self.segment_variance), self.segment_variance, np.inf)
        usual = [_median(variances) for variances in self.segment_variance.T]
        rounding = self.steps.reshape(2, 3).max(axis=1) ** 2 / 12.0
        level = np.maximum(np.minimum(usual, NEAR_LEAST * known.min(axis=0)), rounding)
        return np.where(np.isfinite(level) & (level > 0), level, 1.0).repeat(3)


def full_rate(recording: Recording) -> FullRate:
    """Motion and readings at the unit's rows.

    Raises Unusable if the recording has no rates and forces, or does not show the motion.
    """
    name = recording.manifest.recording_id
    if not set(CHANNELS) & set(recording.imu.columns):
        raise Unusable(
            f"recording {name} has no gyro_* or accel_* columns; "
            "explain needs rates or specific forces"
        )
    readings = recording.imu.stack(CHANNELS)
    recording, on_labels = with_usable_labels(recording)
    motion = with_seen_places(recording, whole_motion(recording))
    motion = with_gyro_acceleration(motion, readings)
    if not motion.felt.any():
        raise Unusable(
            f"recording {name} does not show how the unit moved: it has no table stream with "
            "table_axes, no reference pose and no labelled segments; add one of them"
        )
    # A motion that is unknown in places (labels only) must not reach into its neighbours.
    segments = recording.manifest.segments or find_segments(recording)
    segment = np.full(len(motion.t), -1)
    for k, each in enumerate(segments):
        segment[recording.imu.rows(each.t_start, each.t_end)] = k
    variance = noise_by_segment(readings, motion, segment, len(segments))
    remarks = (*on_labels, *reference_remarks(recording, motion), *clock_remarks(recording))
    speed = np.linalg.norm(np.nan_to_num(motion.rate), axis=1)
    recorded = recorded_signals(recording, motion.t, segments)
    recorded["vibration"] = vibration(variance, segment, speed)
    start = float(motion.t[0])
    noise = reference_noise(recording, motion).since(start)
    motion = replace(motion, t=motion.t - start, recorded=recorded)
    return FullRate(
        readings, motion, segment, segments, variance, *output_steps(readings), start, remarks,
        noise, recording.imu.span,
    )  # fmt: skip


def _median(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else np.inf


MIN_BLOCKS = 200
MIN_OF_POSES = 30  # blocks as long as poses ask for: half a minute of a body that moves slowly
VIBRATING = 1.3  # times the noise variance at rest
BY_NOISE = 45.0  # times the noise of a block: a fourth difference that no corner makes
REACH = 5  # blocks on each side that delays and filters make a reading of
FARTHEST = 0.3  # s, where blocks are longer than delays and filters reach
NEXT = 2  # blocks on each side of a corner whose means it makes wrong
UNEVEN = 0.5  # of an interval: stamps that scatter by less are no batches
BRIEF = 1.0  # s: a shorter gap stays between its neighbours
UNTOUCHED = 0.7  # of the edge of the poses' band
SPLINED = 0.25  # of the frequency of their frames
CORNER = 0.05  # of a fourth difference: error of a block mean at a corner of the motion


@dataclass(frozen=True)
class Blocks:
    """Readings and motion on even blocks.

    t: (n,) s from the start of the run, block centres. readings: (n, 6); 0 where not used.
    weight: (n, 6) root of the weight of a block, 1 for a full one at rest, 0: not used.
    motion: at the blocks, with all that was recorded. rate: blocks a second. band: Hz up to which
    readings are compared; all there is by default.
    segment: (n,) index into `segments`, −1 between them. floor: (6,) variance of a weighted block
    that the output's step and the errors of the reference make by themselves: a model that leaves
    less has taken the noise of the reference for the unit's. lines: Hz, frequencies that are not
    compared, since a signal of unknown source is there.
    """

    t: np.ndarray
    readings: np.ndarray
    weight: np.ndarray
    motion: Motion
    rate: float
    segment: np.ndarray
    segments: tuple[Segment, ...]
    floor: np.ndarray
    band: float = np.inf
    lines: tuple[float, ...] = ()

    @cached_property
    def compared(self) -> np.ndarray:
        """(m,) the rows that are compared, as if no time lay between them: without the gaps in
        which no channel says anything.

        Zeros in their place would cut a drift into steps, and what of it lies in the gaps would be
        missing from its power.
        """
        silent = np.count_nonzero(self.weight, axis=1) == 0
        for start, stop in runs(silent).tolist():
            silent[start:stop] = (stop - start) / self.rate >= BRIEF
        return np.flatnonzero(~silent)

    @property
    def gap_ratio(self) -> float:
        """Distance between the middles of neighbouring pieces that are compared, on average, over
        their length: one without gaps.
        """
        rows = self.compared
        pieces = 1 + np.count_nonzero(np.diff(rows) > 1)
        missing = (rows[-1] - rows[0] + 1 - len(rows)) / max(pieces - 1, 1)
        return float(1.0 + missing * pieces / len(rows))

    @property
    def share(self) -> float:
        """Of the frequencies below half the rate those that are compared."""
        return min(1.0, 2.0 * self.band / self.rate)

    @property
    def used(self) -> int:
        """Number of independent readings."""
        return max(1, round(self.share * np.count_nonzero(self.weight)))

    @property
    def used_by_channel(self) -> np.ndarray:
        """(6,) of each channel."""
        return self.share * np.count_nonzero(self.weight, axis=0)


def block_means(
    full: FullRate, rate: float, masked: np.ndarray | None = None, fewest: int | None = None
) -> Blocks:
    """Block means at a rate (Hz), or the rows themselves if they are slower.

    Where poses show the motion only up to some frequency, nothing is compared above it. Blocks are
    not made longer for that: effects that follow products of rates do not follow products of their
    means. masked: (n, 6) bool, samples that must not be used. fewest: 200, or as many as make 30 of
    the band's, unless given. Raises Unusable if there are fewer, or if none is known.
    """
    t = full.motion.t
    own = 1.0 / max(full.motion.interval, 1e-9)
    # A block between two batches of stamps would have no row, and its neighbours none beside them.
    step = max(1, round(own / rate), int(np.ceil(own * longest_step(t) - UNEVEN)))
    band, needed = np.inf, MIN_BLOCKS
    if full.motion.tracking is not None:
        band = full.motion.tracking.edge
        needed = max(needed, round(MIN_OF_POSES * own / step / (2.0 * band)))
    block = ((t + 0.5 / own) * own / step).astype(int)
    count = int(block[-1]) + 1
    if count < (needed if fewest is None else fewest):
        raise Unusable(
            f"the recording lasts {t[-1]:.1f} s; explain needs {needed * step / own:.0f} s or more"
        )
    usable = np.isfinite(full.readings) & full.motion.felt
    if masked is not None:
        usable &= ~masked
    counts = _sums(usable.astype(float), block, count)
    sums = _sums(np.where(usable, full.readings, 0.0), block, count)
    readings = np.divide(sums, counts, out=np.zeros_like(sums), where=counts > 0)
    motion = _block_motion(full.motion, block, count, step / own)
    first = np.minimum(np.searchsorted(block, np.arange(count)), len(block) - 1)
    segment = full.segment[first]
    weight = np.sqrt(counts / step) * _segment_weight(full)[segment]
    at_rest = full.rest_variance / step
    known_errors = _reference_errors(full, motion, step / own, band)
    # Rows of an AHRS are as slow as the corners: what is read between them errs as far as it reads.
    reach = REACH if full.span else NEXT
    weight /= np.sqrt(1.0 + _corners(motion, known_errors, reach) / at_rest)
    # Beside the noise that it has anyhow, else a rest would count more than its reference allows.
    weight /= np.sqrt(1.0 + weight**2 * known_errors / at_rest)
    weight[~_known(motion, step / own)] = 0.0
    if not weight.any():
        raise Unusable(
            f"the recording has no unbroken {(2 * REACH + 1) * step / own:.2g} s with both imu "
            "rows and a known motion; give a reference that covers the readings"
        )
    floor = full.steps**2 / 12.0 / np.where(full.dithered, step, 1)
    used = np.maximum((weight > 0).sum(axis=0), 1)
    floor = floor + np.nansum(weight**2 * known_errors, axis=0) / used
    return Blocks(
        motion.t, readings, weight, motion, own / step, segment, full.segments, floor, band
    )


def well_known(tracking: Tracking) -> float:
    """Hz up to which poses tell a motion as it was: the filter that ends their band at the edge
    takes 0.3 % of it there, and a cubic spline between their frames 1.2 %. What they take follows
    the motion, and a lever arm would make up for it.
    """
    return min(UNTOUCHED * tracking.edge, SPLINED / tracking.interval)


def _reference_errors(full: FullRate, motion: Motion, width: float, band: float) -> np.ndarray:
    """(n, 6) variance of blocks `width` s long whose white noise would be, below the band's edge
    (Hz), as large as the errors of the reference: those of poses all lie there.
    """
    longest = max(width, 0.5 / band)
    return full.reference_noise.variance(motion, longest) * longest / width


def _sums(values: np.ndarray, block: np.ndarray, count: int) -> np.ndarray:
    """(count, k) sums of values (n, k) over each block."""
    return np.column_stack([np.bincount(block, column, count) for column in values.T])


def _block_motion(motion: Motion, block: np.ndarray, count: int, width: float) -> Motion:
    """Means of everything that is known; a block without rows repeats nothing: it is unknown."""
    rows = np.bincount(block, minlength=count)

    def mean(values: np.ndarray) -> np.ndarray:
        with np.errstate(invalid="ignore"):
            sums = _sums(values.reshape(len(values), -1), block, count)
            means = sums / np.where(rows > 0, rows, np.nan)[:, None]
        return np.asarray(means.reshape(count, *values.shape[1:]))

    means = motion.mapped(mean)
    recorded = {**means.recorded, "fixing": np.round(means.recorded["fixing"])}  # no mean of two
    t = (np.arange(count) + 0.5) * width - 0.5 * width / max(1, round(rows.max()))
    return replace(means, t=t, recorded=recorded)


def _known(motion: Motion, width: float) -> np.ndarray:
    """(n, 6) bool: the inputs are known, and with encoders also just before and after.

    Every effect is judged by the same blocks: beside a gap of the encoders, one that needs no
    neighbours would otherwise have blocks that others cannot use.
    """
    if motion.axes is None:
        return motion.felt
    reach = min(REACH, int(np.ceil(FARTHEST / width)))
    return np.asarray(minimum_filter1d(motion.felt, 2 * reach + 1, axis=0, mode="nearest"))


def _corners(motion: Motion, known_errors: np.ndarray, reach: int) -> np.ndarray:
    """(n, 6) squared error of a block's rate and force where the motion has a corner, and `reach`
    blocks before and after it.

    Samples do not show when within their interval a table begins to accelerate; a fourth difference
    is large there and nowhere else, apart from the noise of the reference, whose variance is
    known_errors (n, 6). Poses are smoothed and have no corners.
    """
    if motion.tracking is not None:
        return np.zeros((len(motion.t), 6))
    rough = []
    for first, signal in enumerate((motion.rate, motion.force)):
        fourth = np.abs(np.diff(bridged(signal), 4, axis=0)).max(axis=1)
        noise = np.sqrt(known_errors[2:-2, 3 * first : 3 * first + 3].max(axis=1))
        fourth = np.maximum(fourth - BY_NOISE * noise, 0.0)
        rough.append(
            (CORNER * maximum_filter1d(np.pad(fourth, 2), 2 * reach + 1, mode="constant")) ** 2
        )
    return np.column_stack(rough).repeat(3, axis=1)


def _segment_weight(full: FullRate) -> np.ndarray:
    """(segments + 1, 6) root weight by the noise of each segment, 1 at rest; last: between them."""
    variance = full.segment_variance.repeat(3, axis=1)
    ratio = np.where(np.isfinite(variance), variance / full.rest_variance, 1.0)
    return np.asarray(1.0 / np.sqrt(np.where(ratio > VIBRATING, ratio, 1.0)))
