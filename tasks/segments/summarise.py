"""Segment means that transmission errors do not spoil, with what their noise is made of."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.ndimage import binary_dilation

from schemas.recording import ACCEL, GYRO, Recording, Segment, Stream

CHANNELS = GYRO + ACCEL
GYRO_COLUMNS = slice(0, 3)
ACCEL_COLUMNS = slice(3, 6)

SAMPLE_ROWS = 2000  # rows that centre and scale are taken from; enough for a median
FAR = 10.0  # robust standard deviations beyond which a row is not this segment's signal
BLOCKS = 32  # finest blocks of the Allan variances
LONGEST_BURST = 3  # rows: a corrupted frame or two; anything longer moved


@dataclass(frozen=True)
class SegmentMean:
    """One segment, summarised.

    mean: (6,) gyro rad/s then accelerometer m/s², NaN where a triad was not recorded.
    allan: (levels, 6) Allan variances of the block means, finest blocks first.
    tau: (levels,) s, the blocks' lengths.
    left_out: rows that a channel shows to be corrupted; they are in no mean.
    far_rows: (6,) how many of them each channel showed.
    longest_burst: the longest run of them.
    """

    segment: Segment
    origin: Literal["label", "found"]
    rows: int
    t_start: float
    t_end: float
    mean: np.ndarray
    allan: np.ndarray
    tau: np.ndarray
    left_out: int
    far_rows: np.ndarray
    longest_burst: int

    @property
    def seconds(self) -> float:
        return self.t_end - self.t_start

    @property
    def has_gyro(self) -> bool:
        return bool(np.isfinite(self.mean[GYRO_COLUMNS]).all())

    @property
    def has_accel(self) -> bool:
        return bool(np.isfinite(self.mean[ACCEL_COLUMNS]).all())


def far_rows(values: np.ndarray) -> np.ndarray:
    """Which entries of each column lie far from that column's bulk, (n, c) bool.

    Centre and scale come from the median, its absolute deviation and the 2 % to 98 % range of
    an evenly spread sample, so that a spike, or a hundred, cannot hide itself. NaN is not far.
    """
    sample = values[:: max(1, len(values) // SAMPLE_ROWS)]
    low, centre, high = np.quantile(sample, (0.02, 0.5, 0.98), axis=0)
    spread = 1.4826 * np.median(np.abs(sample - centre), axis=0)
    scale = np.maximum(spread, (high - low) / 4.1)
    resolution = 8 * np.finfo(float).eps * np.abs(centre)
    with np.errstate(invalid="ignore"):
        return np.abs(values - centre) > FAR * np.maximum(scale, resolution)


def longest_run(flags: np.ndarray) -> int:
    """Length of the longest run of True in (n,) flags."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(np.int8), [0]))))
    return int((edges[1::2] - edges[::2]).max(initial=0))


def _widened(corrupt: np.ndarray) -> np.ndarray:
    """A burst of far rows with its own length added on both sides, where it came and went."""
    burst = longest_run(corrupt)
    return binary_dilation(corrupt, iterations=burst) if burst > LONGEST_BURST else corrupt


def allan_variances(values: np.ndarray, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Allan variances of (n, c) values at block lengths seconds/32, /16, /8, /4 and /2.

    Returns variances (levels, c) and block lengths (levels,) s. Fewer levels where there are
    fewer rows than blocks.
    """
    blocks = min(BLOCKS, 1 << (len(values).bit_length() - 1))
    size = len(values) // blocks
    means = values[: size * blocks].reshape(blocks, size, -1).mean(axis=1)
    variances, lengths = [], []
    while len(means) >= 2:
        variances.append(0.5 * np.mean(np.diff(means, axis=0) ** 2, axis=0))
        lengths.append(seconds / len(means))
        means = 0.5 * (means[::2] + means[1::2])
    return np.array(variances).reshape(-1, values.shape[1]), np.array(lengths)


def summarise(
    imu: Stream, segment: Segment, origin: Literal["label", "found"]
) -> SegmentMean | None:
    """The summary of one segment, or None where the recording has no row of it."""
    rows = imu.rows(segment.t_start, segment.t_end)
    if rows.stop <= rows.start:
        return None
    t = imu.t[rows]
    values = imu.stack_rows(CHANNELS, rows)
    far = np.zeros(values.shape, bool) if segment.kind == "rotation" else far_rows(values)
    corrupt = _widened(np.any(far, axis=1))
    kept = values[~corrupt] if corrupt.any() else values
    seconds = float(t[-1] - t[0]) * len(t) / max(1, len(t) - 1)
    allan, tau = allan_variances(kept, seconds)
    return SegmentMean(
        segment=segment,
        origin=origin,
        rows=len(t),
        t_start=float(t[0]),
        t_end=float(t[0]) + seconds,
        mean=kept.mean(axis=0),
        allan=allan,
        tau=tau,
        left_out=int(corrupt.sum()),
        far_rows=far.sum(axis=0),
        longest_burst=longest_run(corrupt),
    )


def summarise_all(
    recording: Recording, segments: tuple[Segment, ...], origin: Literal["label", "found"]
) -> tuple[SegmentMean, ...]:
    """Summaries of every static, rate and rotation segment that the recording has rows of."""
    measured = (s for s in segments if s.kind in ("static", "rate", "rotation"))
    summaries = (summarise(recording.imu, segment, origin) for segment in measured)
    return tuple(summary for summary in summaries if summary is not None)
