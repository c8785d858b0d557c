"""Noise in bands of frequency: S(f) = w + b/f for each channel, and what it makes of sums.

Even reflection and Fourier transform are one real transform, the DCT: in it noise is nearly
independent from coefficient to coefficient, whitening is a division, and a band of frequencies
is a slice. Odd reflection would hang the whole pad on one noisy sample; even reflection does not.
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import dct, next_fast_len

SINGLE = 8  # lowest coefficients that are bands of their own
PER_OCTAVE = 4
MIDDLE = (0.006, 1.0)  # Hz: where flicker is read off
TOP = 0.5  # of the band, from where up noise is white
FLATTEST = 1e-4  # Hz: smallest corner considered; all are equally likely on a log scale
STEEPEST = 15.0  # Hz: largest corner b/w that a unit may have
EFFICIENCY = 0.37  # of a median of squares beside their mean
MEDIAN = 0.4549  # of a squared standard normal


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
    edges = [0, *range(2, SINGLE + 1)]
    while edges[-1] < count:
        edges.append(min(count, max(edges[-1] + 1, round(edges[-1] * 2 ** (1 / PER_OCTAVE)))))
    cut = np.array(edges)
    frequency = 0.5 * (cut[:-1] + cut[1:] - 1) * rate / (2 * count)
    return Bands(cut, np.maximum(frequency, 0.5 * rate / (2 * count)))


def padded_length(count: int) -> int:
    """A length not below `count` that transforms fast."""
    return int(next_fast_len(count, real=True))


def transformed(columns: np.ndarray) -> np.ndarray:
    """DCT of each row of (k, n), orthonormal."""
    return np.asarray(dct(columns, type=2, norm="ortho", axis=-1))


@dataclass(frozen=True)
class Noise:
    """Noise of one channel's blocks: variance of a coefficient at f is w + b/f (+ q/f²)."""

    white: float
    flicker: float

    def variance(self, frequency: np.ndarray) -> np.ndarray:
        return self.white + self.flicker / frequency


def noise_of(left: np.ndarray, bands: Bands, floor: float) -> Noise:
    """White and flicker noise of what a fit left, in DCT coefficients (n,).

    floor: variance that rounding has at least.

    White from the upper half of the band; flicker from the middle, by its posterior mean
    (Whittle's likelihood) over bands whose power is a median: lines and steps of physics not yet
    found are sparse there, noise is not.
    """
    cut = bands.edges
    start = int(TOP * len(left))
    middle = (bands.frequency > MIDDLE[0]) & (bands.frequency < MIDDLE[1]) & (bands.sizes >= 3)
    power, sizes, frequency = [], bands.sizes[middle], bands.frequency[middle]
    for k in np.flatnonzero(middle):
        power.append(np.median(left[cut[k] : cut[k + 1]] ** 2) / MEDIAN)
    # Small medians are biased upwards: 1 + 0.58/n to first order.
    levels = np.array(power) / (1.0 + 0.58 / np.maximum(sizes, 1))
    white = max(float(np.mean(left[start:] ** 2)), floor)
    if white <= 0 or not len(levels):
        return Noise(max(white, 1e-30), 0.0)
    levels = np.maximum(levels, floor)
    top = 0.75 * bands.frequency[-1]
    corners = np.geomspace(FLATTEST, STEEPEST, 80)
    costs = np.empty(len(corners))
    for n, corner in enumerate(corners):
        expected = white / (1.0 + corner / top) * (1.0 + corner / frequency)
        costs[n] = (sizes * (np.log(expected) + levels / expected)).sum()
    # The mean, not the likeliest: a short run does not exclude flicker, and a jump is told from it.
    odds = np.exp(-0.5 * EFFICIENCY * (costs - costs.min()))
    corner = float(odds @ corners / odds.sum())
    flicker = white / (1.0 + corner / top) * corner
    return Noise(white - flicker / top, flicker)
