"""Noise in bands of frequency: S(f) = w + b/f for each channel, and what it makes of sums.

Even reflection and Fourier transform are one real transform, the DCT: in it noise is nearly
independent from coefficient to coefficient, whitening is a division, and a band of frequencies
is a slice. Odd reflection would hang the whole pad on one noisy sample; even reflection does not.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import dct, next_fast_len

SINGLE = 8  # lowest coefficients that are bands of their own
PER_OCTAVE = 4
MIDDLE = (0.006, 1.0)  # Hz: where flicker is read off
TOP = 0.5  # of the band, from where up noise is white
# Hz: corners b/w that a unit may have, all equally likely on a log scale
CORNERS = np.geomspace(1e-4, 15.0, 80)
ALIKE = 0.35  # standard deviation of ln(corner) among a triad's sensors
UNLIKE = 1e-4  # chance that one of them is nothing like the others
TAKEN = 0.25  # a band of which less is free tells nothing of the noise
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


@dataclass(frozen=True)
class Left:
    """What a fit left of a channel: course (n,), DCT coefficients; free: (bands,) the share of a
    band's coefficients that no fitted column took, which is what noise keeps of its power there.
    """

    course: np.ndarray
    free: np.ndarray


@dataclass(frozen=True)
class Seen:
    """What one channel's residual tells of its noise.

    white: variance of the upper half of the band. odds: (k,) of each of CORNERS, b/w in Hz.
    """

    white: float
    odds: np.ndarray


def noises_of_triad(
    lefts: Sequence[Left], bands: Bands, floors: Sequence[float]
) -> tuple[Noise, ...]:
    """White and flicker noise of what a fit left in a triad's channels.

    floors: variance that rounding has at least in each channel.

    White from the upper half of the band; flicker from the middle, by its posterior mean
    (Whittle's likelihood) over bands whose power is a median: lines and steps of physics not yet
    found are sparse there, noise is not. The mean and not the likeliest value, since a short run
    does not exclude flicker. Sensors of a triad are built alike: the corner of one is expected
    near those of the others, within ALIKE.
    """
    seen = [_seen(left, bands, floor) for left, floor in zip(lefts, floors, strict=True)]
    near = np.exp(-0.5 * (np.log(CORNERS[:, None] / CORNERS) / ALIKE) ** 2) + UNLIKE
    expected = [near @ each.odds for each in seen]
    found = []
    for number, each in enumerate(seen):
        others = np.prod([e for n, e in enumerate(expected) if n != number], axis=0)
        odds = each.odds * (near @ (others * np.ones(len(CORNERS))))
        corner = float(odds @ CORNERS / odds.sum())
        top = 0.75 * bands.frequency[-1]
        flicker = each.white / (1.0 + corner / top) * corner
        found.append(Noise(each.white - flicker / top, flicker))
    return tuple(found)


def _seen(left: Left, bands: Bands, floor: float) -> Seen:
    cut = bands.edges
    middle = (bands.frequency > MIDDLE[0]) & (bands.frequency < MIDDLE[1]) & (bands.sizes >= 3)
    middle &= left.free > TAKEN
    free, frequency = left.free[middle], bands.frequency[middle]
    power = [
        np.median(left.course[cut[k] : cut[k + 1]] ** 2) / MEDIAN for k in np.flatnonzero(middle)
    ]
    sizes = bands.sizes[middle] * free
    # Small medians are biased upwards: 1 + 0.58/n to first order.
    levels = np.maximum(np.array(power) / (free + 0.58 * free / np.maximum(sizes, 1)), floor)
    white = max(float(np.mean(left.course[int(TOP * len(left.course)) :] ** 2)), floor)
    if white <= 0 or not len(levels):
        return Seen(max(white, 1e-30), (CORNERS[0] == CORNERS).astype(float))
    top = 0.75 * bands.frequency[-1]
    expected = white / (1.0 + CORNERS[:, None] / top) * (1.0 + CORNERS[:, None] / frequency)
    costs = (sizes * (np.log(expected) + levels / expected)).sum(axis=1)
    return Seen(white, np.exp(-0.5 * EFFICIENCY * (costs - costs.min())))
