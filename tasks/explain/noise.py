"""Noise in frequency bands, S(f) = w + b/f for each channel, and its effect on sums.

Beside poses, whose noise their derivatives raise, S(f) = (w + b/f)·(1 + (f/r)ᵏ): the rates of an
attitude with the square of the frequency, the accelerations of a place with its fourth power. What
smoothing loses of the motion rises no less.

Even reflection and Fourier transform are one real transform, the DCT: in it noise is nearly
independent from coefficient to coefficient, whitening is a division, and a band of frequencies
is a slice. Odd reflection would hang the whole pad on one noisy sample; even reflection does not.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import dct, idct, next_fast_len
from scipy.special import xlogy

from tasks.explain.inputs.blocks import Blocks
from tasks.model.fit import WhitenedEquations, of_channel
from tasks.model.term import Column

SINGLE_BANDS = 8  # lowest coefficients that are bands of their own
PER_OCTAVE = 4
LINE_WIDTH = 3.0  # waves per recording on each side of a line that are not compared


@dataclass(frozen=True)
class Bands:
    """Slices of the DCT's coefficients and their mean frequencies (k,) Hz."""

    edges: np.ndarray
    frequency: np.ndarray

    @property
    def sizes(self) -> np.ndarray:
        return np.diff(self.edges)


def bands_of(count: int, rate: float) -> Bands:
    """Bands of n coefficients at `rate` Hz: single ones at first, then four an octave.

    The first coefficient, the mean, stands with the second.
    """
    edges = [0, *range(2, SINGLE_BANDS + 1)]
    while edges[-1] < count:
        edges.append(min(count, max(edges[-1] + 1, round(edges[-1] * 2 ** (1 / PER_OCTAVE)))))
    cut = np.array(edges)
    frequency = 0.5 * (cut[:-1] + cut[1:] - 1) * rate / (2 * count)
    return Bands(cut, np.maximum(frequency, 0.5 * rate / (2 * count)))


def padded_length(count: int) -> int:
    """A length not below `count` that transforms fast."""
    return int(next_fast_len(count, real=True))


def known_share(observed: Blocks, channel: int) -> float:
    """Of the rows that are transformed those in which a channel says something."""
    known = np.count_nonzero(observed.weight[:, channel])
    return float(known) / padded_length(len(observed.compared))


def weighted(
    signals: Sequence[np.ndarray] | np.ndarray, weight: np.ndarray, observed: Blocks
) -> np.ndarray:
    """(k, padded m) the compared rows of signals (n,) times weight (n,), in rows; zero where a
    signal is not known.
    """
    rows = observed.compared
    level, count = weight[rows], len(rows)
    stack = np.zeros((len(signals), padded_length(count)))
    for row, signal in zip(stack, signals, strict=True):
        np.multiply(signal[rows], level, out=row[:count])
    np.copyto(stack, 0.0, where=np.isnan(stack))
    return stack


def at_blocks(stack: np.ndarray, observed: Blocks) -> np.ndarray:
    """(k, n) rows (k, padded m) at all blocks; zero where nothing is compared."""
    rows = observed.compared
    spread = np.zeros((len(stack), len(observed.t)))
    spread[:, rows] = stack[:, : len(rows)]
    return spread


def transformed(columns: np.ndarray) -> np.ndarray:
    """DCT of each row of (k, n), orthonormal."""
    return np.asarray(dct(columns, type=2, norm="ortho", axis=-1))


def in_time(coefficients: np.ndarray, padded: int) -> np.ndarray:
    """Rows (k, padded n) with these first coefficients of the DCT, and no others."""
    return np.asarray(idct(coefficients, type=2, n=padded, norm="ortho", axis=-1))


def in_band(columns: np.ndarray, observed: Blocks) -> np.ndarray:
    """DCT of each row of (k, n) without the coefficients above the band that is compared, and
    nothing at the lines that are not.
    """
    padded = columns.shape[-1]
    rows = transformed(columns)[..., : _compared(padded, observed)]
    for line in observed.lines:
        seen = abs(line - round(line / observed.rate) * observed.rate)  # blocks fold it
        place = 2 * padded * seen / observed.rate
        width = 2 * padded * LINE_WIDTH / len(observed.compared)
        rows[..., max(0, round(place - width)) : round(place + width) + 1] = 0.0
    return rows


def compared_bands(observed: Blocks) -> Bands:
    """Bands of the coefficients that are compared."""
    padded = padded_length(len(observed.compared))
    count = _compared(padded, observed)
    return bands_of(count, observed.rate * count / padded)


def _compared(padded: int, observed: Blocks) -> int:
    return round(padded * observed.share)


@dataclass(frozen=True)
class Noise:
    """Noise of one channel's blocks: variance of a coefficient at f is w + b/f, and rises with the
    power `order` of the frequency from `rises` Hz on.
    """

    white: float
    flicker: float
    rises: float = np.inf
    order: int = 0

    def variance(self, frequency: np.ndarray) -> np.ndarray:
        level = self.white + self.flicker / frequency
        return np.asarray(level * self.rise(frequency))

    def rise(self, frequency: np.ndarray) -> np.ndarray:
        """By what the noise of derivatives raises the variance at some frequencies, Hz."""
        return np.asarray(1.0 + (frequency / self.rises) ** self.order if self.order else 1.0)

    def of_coefficients(self, bands: Bands) -> np.ndarray:
        """(n,) variance of every coefficient, the same within a band."""
        return np.repeat(self.variance(bands.frequency), bands.sizes)

    def at_rate(self, factor: float) -> "Noise":
        """The same spectrum for blocks of `factor` times the rate."""
        return replace(self, white=self.white * factor, flicker=self.flicker * factor)


def equations_of(
    columns: Sequence[Column],
    misfit: np.ndarray,
    observed: Blocks,
    noises: Sequence[Noise],
) -> WhitenedEquations:
    """Whitened Gram matrices of columns and misfit (n, 6)."""
    grams, which = [], []
    for channel, noise in enumerate(noises):
        own, signals = of_channel(columns, misfit, channel)
        stack = weighted(signals, observed.weight[:, channel], observed)
        grams.append(whitened_gram(stack, observed, noise))
        which.append(own)
    return WhitenedEquations(tuple(grams), tuple(which), len(columns))


def scores_of(
    columns: Sequence[Column],
    misfit: np.ndarray,
    observed: Blocks,
    noises: Sequence[Noise],
) -> tuple[np.ndarray, float]:
    """Right side (q,) and chi-squared of `equations_of`, by transforming the misfit (n, 6) alone.

    Its product with a column is that of its whitened self, transformed back: Σ⁻¹ is symmetric.
    """
    right, chi2 = np.zeros(len(columns)), 0.0
    for channel, noise in enumerate(noises):
        weight = observed.weight[:, channel]
        rows = np.flatnonzero(weight)
        own, signals = of_channel(columns, misfit, channel)
        stack = weighted(signals[-1:], weight, observed)
        left = in_band(stack, observed)[0]
        whitened = left / noise.variance(frequencies(len(left), stack.shape[1], observed.rate))
        chi2 += float(left @ whitened)
        score = at_blocks(in_time(whitened, stack.shape[1])[None], observed)[0][rows] * weight[rows]
        for q, signal in zip(own.tolist(), signals[:-1], strict=True):
            filled = signal[rows]
            filled[np.isnan(filled)] = 0.0
            right[q] += float(filled @ score)
    return right, chi2


def frequencies(count: int, padded: int, rate: float) -> np.ndarray:
    """(count,) Hz of the first of `padded` coefficients; of the mean half that of the second."""
    return np.maximum(np.arange(count), 0.5) * rate / (2 * padded)


def whitened_gram(stack: np.ndarray, observed: Blocks, noise: Noise) -> np.ndarray:
    """Products (k, k) of weighted rows (k, padded n) of signals, divided by the noise."""
    rows = whitened(stack, observed, noise)
    return np.asarray(rows @ rows.T)


def whitened(stack: np.ndarray, observed: Blocks, noise: Noise) -> np.ndarray:
    """(k, m) coefficients of weighted rows (k, padded n) of signals, divided by the noise."""
    rows = in_band(stack, observed)
    rows /= np.sqrt(noise.variance(frequencies(rows.shape[1], stack.shape[1], observed.rate)))
    return rows


# White, flicker and rising noise of what a fit left of a triad's channels.

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
