"""How much each channel drifts over a recording: flicker, random walk and trend.

Within a segment, noise hides a drift that is slower than the segment; between segments it shows
(`tasks.uncertainty.contrasts`). The Allan variances within the segments join the likelihood.
A drift that a short recording hides is not zero: the strengths are means over the likelihood.

Flicker has to end somewhere for a bias to have a mean over all time. It is taken as relaxations
spread evenly over the logarithm of their time up to a longest one, of which the data tell
little: covariance h·E₁(|τ|/L), Allan variance 2·ln 2·h below L (S(f) = h/f above 1/(2πL)).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import exp1

from tasks.segments.summarise import SegmentMean

LEVELS = (100.0, 1e3, 5e3)  # s: the longest relaxation of which flicker is made
WALK, TREND = len(LEVELS), len(LEVELS) + 1  # what follows the flickers in an array of drifts
DRIFTS = len(LEVELS) + 2
FLICKER_ALLAN = 2.0 * np.log(2.0)  # Allan variance of flicker noise, per unit of h
MOST_DEGREES = 100.0  # no Allan variance counts more: the shapes are not exact
# In the contrast that shows the drift best, as parts of the white noise there: the faintest drift
# that is looked at, and what flicker, walk and trend exceed as often as not, beforehand.
FAINTEST, USUAL = 0.01, (1.0, 0.5, 0.05)
STEPS = 9  # strengths of a drift on each of two grids
INSTANT = 1e-3  # s: a segment of one row has no length


@dataclass(frozen=True)
class Contrasts:
    """Independent combinations of the segment means that rates, gravity and bias leave alone.

    One set for each level at which flicker may end, the one that diagonalises this flicker; walk
    and trend are taken as diagonal there too, which they nearly are.
    value: (LEVELS, m) over the standard deviation that white noise gives each.
    gain: (LEVELS, 3, m) variance per unit of each drift's strength, in units of the white one.
    """

    value: np.ndarray
    gain: np.ndarray


@dataclass(frozen=True)
class PooledAllan:
    """Mean Allan variances (levels,) of `segments` segments at block lengths tau (levels,) s."""

    variance: np.ndarray
    tau: np.ndarray
    segments: int

    @property
    def white(self) -> float:
        return float(white_of(self.variance, self.tau))

    @property
    def degrees(self) -> np.ndarray:
        """How much each level counts in the likelihood."""
        return np.minimum(MOST_DEGREES, _differences(len(self.tau)) * self.segments)


def drift_shapes(segments: tuple[SegmentMean, ...]) -> np.ndarray:
    """Covariance (DRIFTS, n, n) of the segment means per unit of each flicker, walk and trend.

    Flicker h (S(f) = h/f down to its level) is counted about its mean over all time; a random
    walk q (variance per second) and a trend (slope squared) about the mean of this run.
    """
    start = np.array([segment.t_start for segment in segments])
    stop = np.array([max(s.t_end, s.t_start + INSTANT) for s in segments])
    first, last = start.min(), stop.max()
    flickers = [_mean_flicker(start, stop, level) for level in LEVELS]
    apart = _mean_distance(np.append(start, first), np.append(stop, last))
    to_run = apart[:-1, -1]
    walk = 0.5 * (to_run[:, None] + to_run[None, :] - apart[:-1, :-1] - apart[-1, -1])
    middle = 0.5 * (start + stop - first - last)
    return np.array([*flickers, walk, np.outer(middle, middle)])


def drift_allan(tau: np.ndarray) -> np.ndarray:
    """Allan variance (DRIFTS, …) per unit of each drift's strength (IEEE Std 952, C)."""
    flickers = []
    for level in LEVELS:
        x = tau / level
        flickers.append((4.0 * flicker_integral(x) - flicker_integral(2.0 * x)) / x**2)
    return np.array([*flickers, tau / 3.0, tau**2 / 2.0])


def drift_strengths(seen: Contrasts, allan: PooledAllan) -> np.ndarray:
    """Mean strength (DRIFTS,) of each flicker, of walk and of trend over their likelihood.

    Without contrasts between segments the Allan variances know of flicker only. The first, wide
    grid finds where the second, fine one has to be.
    """
    units = _units(seen, allan)
    grids = [_wide_grid(seen, allan, shape, unit) for shape, unit in enumerate(units)]
    chance = _chances(grids, units, seen, allan)
    grids = [_closer(grid, _marginal(chance, shape)) for shape, grid in enumerate(grids)]
    chance = _chances(grids, units, seen, allan)
    strengths = np.zeros(DRIFTS)
    strengths[: len(LEVELS)] = chance.sum(axis=tuple(range(2, chance.ndim))) @ grids[0]
    for shape in range(1, len(grids)):
        strengths[len(LEVELS) + shape - 1] = _marginal(chance, shape) @ grids[shape]
    return strengths


def white_of(allan: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """N² (…) of Allan variances (…, levels): times τ, averaged, as each level knows it."""
    degrees = _differences(tau.shape[-1])
    return (allan * tau) @ degrees / degrees.sum()


def _differences(levels: int) -> np.ndarray:
    """Neighbouring blocks that each Allan variance compares, finest first."""
    return 2.0 ** np.arange(levels, 0, -1) - 1


def _units(seen: Contrasts, allan: PooledAllan) -> list[float]:
    """Strength of flicker, walk and trend that is just seen where it shows best."""
    if seen.value.size:
        return [float(1.0 / seen.gain[:, shape].max()) for shape in range(seen.gain.shape[1])]
    seen_first = math.sqrt(2.0 / float(allan.degrees[-1]))  # of the longest blocks' white noise
    return [seen_first * allan.white / float(allan.tau[-1]) / FLICKER_ALLAN]


def _wide_grid(seen: Contrasts, allan: PooledAllan, shape: int, unit: float) -> np.ndarray:
    """Strengths from what hides under the white noise to more than all there is."""
    largest = 10.0 * FAINTEST * unit
    if shape == 0:
        largest = max(largest, 3.0 * float(allan.variance.max()) / FLICKER_ALLAN)
    if seen.value.size:
        gain = seen.gain[:, shape].sum(axis=1).min()
        largest = max(largest, 10.0 * float((seen.value[0] ** 2).sum() / gain))
    return np.append(0.0, np.geomspace(FAINTEST * unit, largest, STEPS))


def _closer(grid: np.ndarray, chance: np.ndarray) -> np.ndarray:
    """As many strengths where the likelihood is."""
    likely = np.flatnonzero(chance[1:] > 1e-3 * chance.max()) + 1
    low, high = (likely[0], likely[-1]) if len(likely) else (1, 1)
    fine = np.geomspace(grid[max(low - 1, 1)], grid[min(high + 1, len(grid) - 1)], STEPS)
    return np.append(0.0, fine)


def _marginal(chance: np.ndarray, shape: int) -> np.ndarray:
    """Probability of each strength of one drift, whatever the level and the others are."""
    return chance.sum(axis=tuple(axis for axis in range(chance.ndim) if axis != shape + 1))


def _chances(
    grids: list[np.ndarray], units: list[float], seen: Contrasts, allan: PooledAllan
) -> np.ndarray:
    """Probability (LEVELS, …) of each level at which flicker ends, and of each set of strengths.

    Beforehand all levels are as likely, and each drift's share of the sum of itself and its USUAL
    strength lies anywhere between 0 and 1 alike (uniform shrinkage prior: Daniels, Canad. J.
    Statist. 27, 1999).
    """
    known = np.moveaxis(np.array(np.meshgrid(*grids, indexing="ij")), 0, -1)
    likelihood = np.array([_likelihood(known, level, seen, allan) for level in range(len(LEVELS))])
    chance = np.exp(likelihood - likelihood.max())
    for shape, (grid, unit) in enumerate(zip(grids, units, strict=True)):
        prior = _prior(grid, USUAL[shape] * unit)
        chance *= prior.reshape([-1 if j == shape else 1 for j in range(len(grids))])
    return chance / chance.sum()


def _likelihood(known: np.ndarray, level: int, seen: Contrasts, allan: PooledAllan) -> np.ndarray:
    """Logarithm of the likelihood (…) of strengths (…, 1 or 3) with flicker to one level."""
    shown = known.shape[-1]
    slow = known @ drift_allan(allan.tau)[[level, WALK, TREND]][:shown]
    white = np.maximum(white_of(allan.variance - slow, allan.tau), 1e-3 * allan.white)
    expected = white[..., None] / allan.tau + slow
    likelihood = -0.5 * (np.log(expected) + allan.variance / expected) @ allan.degrees
    if seen.value.size:
        spread = known @ seen.gain[level] + (white / allan.white)[..., None]
        likelihood -= 0.5 * (np.log(spread) + seen.value[level] ** 2 / spread).sum(axis=-1)
    return likelihood


def _prior(grid: np.ndarray, usual: float) -> np.ndarray:
    """What each strength (0 first) stands for, if s/(s + usual) is uniform between 0 and 1."""
    edges = np.concatenate([[0.5 * grid[1]], np.sqrt(grid[1:-1] * grid[2:])])
    above = usual / (edges + usual)  # how often it exceeds each edge: no difference from 1
    return np.concatenate([[edges[0] / (edges[0] + usual)], -np.diff(above), above[-1:]])


def flicker_integral(x: np.ndarray) -> np.ndarray:
    """Twice the integral of E₁ from 0 to x ≥ 0: E₁(|t|/L) is the autocovariance of flicker."""
    bounded = np.where(x > 0, x, 1.0)
    bent = np.where(x > 0, 0.5 * x**2 * exp1(bounded), 0.0)
    return bent + x - 0.5 + 0.5 * (1.0 - x) * np.exp(-x)


def _mean_flicker(start: np.ndarray, stop: np.ndarray, level: float) -> np.ndarray:
    """Mean of E₁(|t − s|/level) over t in interval i and s in interval j, (n, n)."""
    return _mean_of(lambda x: level**2 * flicker_integral(x / level), start, stop)


def _mean_distance(start: np.ndarray, stop: np.ndarray) -> np.ndarray:
    """Mean of |t − s| over t in interval i and s in interval j, (n, n)."""
    return _mean_of(lambda x: x**3 / 6.0, start, stop)


def _mean_of(
    second_integral: Callable[[np.ndarray], np.ndarray], start: np.ndarray, stop: np.ndarray
) -> np.ndarray:
    """Mean over two intervals of a function of |t − s| that has this second integral."""
    a, b = start[:, None], stop[:, None]
    c, d = start[None, :], stop[None, :]
    total = second_integral(np.abs(b - c)) + second_integral(np.abs(a - d))
    total -= second_integral(np.abs(b - d)) + second_integral(np.abs(a - c))
    return total / ((b - a) * (d - c))
