"""White, flicker and rising noise of what a fit left of a triad's channels."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import xlogy

from tasks.explain.whitening import Bands, Noise

FLICKER_RANGE = (0.006, 1.0)  # Hz: where flicker is read off
WHITE_ABOVE = 0.5  # of the band, from where up noise is white
# Hz: corners b/w that a unit may have, all equally likely on a log scale
CORNERS = np.geomspace(1e-4, 15.0, 80)
RISES = np.geomspace(0.3, 60.0, 40)  # Hz: from where the noise of derivatives may rise
CORNER_SPREAD = 0.35  # standard deviation of ln(corner) among a triad's sensors
OUTLIER = 1e-4  # chance that one of them is nothing like the others
MIN_FREE = 0.25  # a band of which less is free says nothing of the noise
EFFICIENCY = 0.37  # of a median of squares beside their mean
MEDIAN_OF_SQUARE = 0.4549  # of a squared standard normal


def flicker_over_gaps(gap_ratio: float) -> float:
    """By how much the variance of the difference of two neighbouring means is larger in flicker
    noise where a gap lies between them; gap_ratio: the distance of their middles over their length.

    The autocovariance of 1/f noise goes as −ln of the lag, and its double integral over both means
    gives (r+1)²·ln(r+1) + (r−1)²·ln(r−1) − 2r²·ln r, which is 4·ln 2 without a gap.
    """
    r = gap_ratio
    return float(
        (xlogy((r + 1) ** 2, r + 1) + xlogy((r - 1) ** 2, r - 1) - 2 * xlogy(r**2, r))
        / (4.0 * np.log(2.0))
    )


@dataclass(frozen=True)
class ChannelResidual:
    """What a fit left of a channel: DCT coefficients (n,); free: (bands,) the share of a
    band's coefficients that no fitted column took, which is what noise keeps of its power there.
    """

    coefficients: np.ndarray
    free: np.ndarray


@dataclass(frozen=True)
class CornerPosterior:
    """What one channel's residual shows of its noise.

    white: variance of the upper half of the band. odds: (k,) of each of CORNERS, b/w in Hz.
    """

    white: float
    odds: np.ndarray


def triad_noises(
    lefts: Sequence[ChannelResidual], bands: Bands, floors: Sequence[float], order: int = 0
) -> tuple[Noise, ...]:
    """White and flicker noise of what a fit left in a triad's channels.

    floors: variance that rounding has at least in each channel. order: of the power of frequency
    with which the noise of the reference rises; 0: it does not.

    White from the upper half of the band; flicker from the middle, by its posterior mean
    (Whittle's likelihood) over bands whose power is a median: lines and steps of physics not yet
    found are sparse there, noise is not. The mean and not the likeliest value, since a short run
    does not exclude flicker. Sensors of a triad are built alike: the corner of one is expected
    near those of the others, within CORNER_SPREAD.
    """
    if order:
        rising = _rising(lefts, bands, order)
        rise = rising.rise(bands.frequency)
        lefts = [
            replace(left, coefficients=left.coefficients / np.sqrt(np.repeat(rise, bands.sizes)))
            for left in lefts
        ]
        return tuple(
            replace(rising, white=one.white, flicker=one.flicker)
            for one in triad_noises(lefts, bands, floors)
        )
    posteriors = [_posterior(left, bands, floor) for left, floor in zip(lefts, floors, strict=True)]
    near = np.exp(-0.5 * (np.log(CORNERS[:, None] / CORNERS) / CORNER_SPREAD) ** 2) + OUTLIER
    expected = [near @ posterior.odds for posterior in posteriors]
    found = []
    for number, posterior in enumerate(posteriors):
        others = np.prod([e for n, e in enumerate(expected) if n != number], axis=0)
        odds = posterior.odds * (near @ (others * np.ones(len(CORNERS))))
        corner = float(odds @ CORNERS / odds.sum())
        top = 0.75 * bands.frequency[-1]
        flicker = posterior.white / (1.0 + corner / top) * corner
        found.append(Noise(posterior.white - flicker / top, flicker))
    return tuple(found)


def _rising(lefts: Sequence[ChannelResidual], bands: Bands, order: int) -> Noise:
    """Unit noise that rises from where a triad's likeliest does, by Whittle's likelihood above the
    flicker; all of a triad have the same reference.
    """
    least, most = np.inf, Noise(1.0, 0.0)
    for corner in (np.inf, *RISES):
        rising = Noise(1.0, 0.0, corner, order)
        shape, cost = rising.rise(bands.frequency), 0.0
        for left in lefts:
            used = (bands.frequency > FLICKER_RANGE[1]) & (left.free > MIN_FREE)
            powers = np.add.reduceat(left.coefficients**2, bands.edges[:-1])[used] / left.free[used]
            count = bands.sizes[used].sum()
            white = (powers / shape[used]).sum() / max(count, 1)
            cost += count * np.log(max(white, 1e-300)) + bands.sizes[used] @ np.log(shape[used])
        if cost < least:
            least, most = cost, rising
    return most


def _posterior(left: ChannelResidual, bands: Bands, floor: float) -> CornerPosterior:
    cut = bands.edges
    middle = (
        (bands.frequency > FLICKER_RANGE[0])
        & (bands.frequency < FLICKER_RANGE[1])
        & (bands.sizes >= 3)
    )
    middle &= left.free > MIN_FREE
    free, frequency = left.free[middle], bands.frequency[middle]
    power = [
        np.median(left.coefficients[cut[k] : cut[k + 1]] ** 2) / MEDIAN_OF_SQUARE
        for k in np.flatnonzero(middle)
    ]
    sizes = bands.sizes[middle] * free
    # Small medians are biased upwards: 1 + 0.58/n to first order.
    levels = np.maximum(np.array(power) / (free + 0.58 * free / np.maximum(sizes, 1)), floor)
    top_half = left.coefficients[int(WHITE_ABOVE * len(left.coefficients)) :]
    white = max(float(np.mean(top_half**2)), floor)
    if white <= 0 or not len(levels):
        return CornerPosterior(max(white, 1e-30), (CORNERS[0] == CORNERS).astype(float))
    top = 0.75 * bands.frequency[-1]
    expected = white / (1.0 + CORNERS[:, None] / top) * (1.0 + CORNERS[:, None] / frequency)
    costs = (sizes * (np.log(expected) + levels / expected)).sum(axis=1)
    return CornerPosterior(white, np.exp(-0.5 * EFFICIENCY * (costs - costs.min())))
