"""Type A uncertainty of segment means when the samples are not independent.

Each channel's noise is taken as white plus flicker (1/f). Both strengths are fitted to the
Allan variances of all segments together; the covariance of the segment means follows from them
in closed form, so that drift between segments counts, and what drift is common to two segments
cancels in their difference.

Source: IEEE Std 952, annex C (Allan variance of angle random walk and bias instability); the
covariance of flicker noise averaged over intervals is the double integral of its generalised
autocovariance −h·ln|τ| (S(f) = h/f).
"""

from dataclasses import dataclass

import numpy as np

from tasks.segments.summarise import SegmentMean

FLICKER_ALLAN = 2.0 * np.log(2.0)  # Allan variance of flicker noise, per unit of h

UNSEEN = 10.0  # spans of the recording over which the stated bias is the mean


@dataclass(frozen=True)
class ChannelNoise:
    """White and flicker noise of the six channels, and of each segment.

    white: (segments, 6) variance of a mean over 1 s, unit²·s.
    flicker: (6,) h of S(f) = h/f, unit².
    """

    white: np.ndarray
    flicker: np.ndarray


def fit_noise(segments: tuple[SegmentMean, ...]) -> ChannelNoise:
    """White and flicker strengths from the Allan variances of all segments.

    The flicker is common to all segments; the white part is each segment's own (a turning
    table shakes), read off its Allan variances with the flicker taken away.
    """
    flicker = np.array([_pooled_flicker(segments, channel) for channel in range(6)])
    white = np.array([_white_of(segment, flicker) for segment in segments]).reshape(-1, 6)
    moving = np.array([segment.segment.kind == "rotation" for segment in segments], bool)
    if moving.any():  # what varies there is the turn itself, not noise
        white[moving] = np.nanmedian(white[~moving], axis=0) if (~moving).any() else np.nan
    return ChannelNoise(white=white, flicker=flicker)


def covariance_of_means(
    segments: tuple[SegmentMean, ...], noise: ChannelNoise, channel: int
) -> np.ndarray:
    """Covariance (n, n) of one channel's segment means, unit².

    Flicker is counted from a tenth of the recording's own lowest frequency upwards: drift that
    is slower cannot be seen in the recording, and still moves the bias that is stated.
    """
    start = np.array([segment.t_start for segment in segments])
    stop = np.array([segment.t_end for segment in segments])
    white = np.diag(noise.white[:, channel] / (stop - start))
    span = stop.max() - start.min()
    common = np.log(UNSEEN * span) - 1.5  # the variance of the mean over UNSEEN spans is zero
    flicker = common - _mean_log_distance(start, stop)
    return white + noise.flicker[channel] * flicker


def _pooled_flicker(segments: tuple[SegmentMean, ...], channel: int) -> float:
    """h of one channel: non-negative least squares on all segments' Allan variances.

    Model: variance(τ) = N²/τ + 2 ln 2 · h, each level weighted by its number of differences
    over the squared value that white noise alone would give it.
    """
    measured = [
        s
        for s in segments
        if s.segment.kind != "rotation" and len(s.tau) and np.isfinite(s.allan[:, channel]).all()
    ]
    if not measured:
        return 0.0
    levels = max(len(s.tau) for s in measured)
    full = [s for s in measured if len(s.tau) == levels]
    finest = np.array([s.allan[0, channel] for s in full])
    # A shaking turn would hide the flicker of the quiet segments under its white noise.
    quiet = [s for s, value in zip(full, finest, strict=True) if value <= 3 * np.median(finest)]
    tau = np.median([s.tau for s in quiet], axis=0)
    variance = np.mean([s.allan[:, channel] for s in quiet], axis=0)
    if not variance.any():
        return 0.0
    design = np.column_stack([1.0 / tau, np.full(levels, FLICKER_ALLAN)])
    pairs = 2.0 ** np.arange(levels, 0, -1) - 1
    weight = np.sqrt(pairs) / variance.clip(min=variance.max() * 1e-6)
    return _second_of_two(design * weight[:, None], variance * weight)


def _second_of_two(design: np.ndarray, target: np.ndarray) -> float:
    """The second of two non-negative parameters of a least-squares fit."""
    first, second = np.linalg.lstsq(design, target, rcond=None)[0]
    if second <= 0:
        return 0.0
    if first >= 0:
        return float(second)
    return float(design[:, 1] @ target / (design[:, 1] @ design[:, 1]))


def _white_of(segment: SegmentMean, flicker: np.ndarray) -> np.ndarray:
    """N² of one segment, (6,): its Allan variances less the flicker, times τ, averaged.

    Levels with more differences know more; what they leave of the total is never negative.
    """
    if not len(segment.tau):
        return np.full(6, np.nan)
    pairs = 2.0 ** np.arange(len(segment.tau), 0, -1) - 1
    excess = (segment.allan - FLICKER_ALLAN * flicker) * segment.tau[:, None]
    return np.maximum((pairs[:, None] * excess).sum(axis=0) / pairs.sum(), 0.0)


def _mean_log_distance(start: np.ndarray, stop: np.ndarray) -> np.ndarray:
    """Mean of ln|t − s| over t in interval i and s in interval j, (n, n)."""

    def second_integral(x: np.ndarray) -> np.ndarray:
        x = np.abs(x)
        return 0.5 * x**2 * np.log(np.where(x > 0, x, 1.0)) - 0.75 * x**2

    a, b = start[:, None], stop[:, None]
    c, d = start[None, :], stop[None, :]
    total = second_integral(b - c) + second_integral(a - d)
    total -= second_integral(b - d) + second_integral(a - c)
    return total / ((b - a) * (d - c))
