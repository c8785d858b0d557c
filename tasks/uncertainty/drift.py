"""Drift of each channel over a recording: flicker, random walk and trend.

Within a segment, noise hides a drift that is slower than the segment; between segments it shows
(`tasks.uncertainty.contrasts`). The Allan variances within the segments join the likelihood.
A drift that a short recording hides is not zero: the strengths are means over the likelihood.

Flicker has to end somewhere for a bias to have a mean over all time. It is taken as relaxations
spread evenly over the logarithm of their time up to a longest one, which the data hardly
determine: covariance h·E₁(|τ|/L), Allan variance 2·ln 2·h below L (S(f) = h/f above 1/(2πL)).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from tasks.segments.summarise import SegmentMean

LEVELS = (100.0, 1e3, 5e3)  # s: the longest relaxation of which flicker is made
WALK, TREND = len(LEVELS), len(LEVELS) + 1  # what follows the flickers in an array of drifts
DRIFTS = len(LEVELS) + 2
FLICKER_ALLAN = 2.0 * np.log(2.0)  # Allan variance of flicker noise, per unit of h
MAX_DEGREES = 100.0  # no Allan variance counts more: the shapes are not exact
# In the contrast that shows the drift best, as parts of the white noise there: the smallest
# strength on the grid, and the prior medians of flicker, walk and trend.
FAINTEST_SHARE, PRIOR_MEDIAN = 0.01, (2.0, 0.5, 0.05)
# A priori probability that there is none. Every inertial sensor flickers; slow flicker is hardly
# told from a walk, so that a walk besides is the exception; a trend there is as often as not.
PRIOR_ABSENT = (0.0, 0.75, 0.5)
GRID_POINTS = 9  # strengths of a drift on each of two grids
INSTANT = 1e-3  # s: a segment of one row has no length


@dataclass(frozen=True)
class Contrasts:
    """Independent combinations of the segment means that rates, gravity and bias leave alone.

    One set for each level at which flicker may end, the one that diagonalises this flicker; walk
    and trend are taken as diagonal there too, which they nearly are.
    value: (LEVELS, m) over the standard deviation that white noise gives each.
    gain: (LEVELS, 3, m) variance per unit of each drift's strength, in units of the white one.
    tilted: (segments,) variance of each mean, unit², by a tilt that its axis has for itself.
    """

    value: np.ndarray
    gain: np.ndarray
    tilted: np.ndarray


@dataclass(frozen=True)
class PooledAllan:
    """Mean Allan variances (levels,) of `segments` segments at block lengths tau (levels,) s."""

    variance: np.ndarray
    tau: np.ndarray
    segments: int

    @cached_property
    def white(self) -> float:
        return float(white_of(self.variance, self.tau))

    @cached_property
    def drifting(self) -> np.ndarray:
        """Allan variance (DRIFTS, levels) per unit of each drift's strength."""
        return drift_allan(self.tau)

    @cached_property
    def degrees(self) -> np.ndarray:
        """How much each level counts in the likelihood."""
        return np.minimum(MAX_DEGREES, _differences(len(self.tau)) * self.segments)


def seconds_of(segments: Sequence[SegmentMean]) -> np.ndarray:
    """Lengths (n,) of the segments, s."""
    return np.array([max(segment.seconds, INSTANT) for segment in segments])


def drift_shapes(segments: tuple[SegmentMean, ...]) -> np.ndarray:
    """Covariance (DRIFTS, n, n) of the segment means per unit of each flicker, walk and trend.

    Flicker h (S(f) = h/f down to its level) is counted about its mean over all time; a random
    walk q (variance per second) and a trend (slope squared) about the mean of this run.
    """
    stops = (max(s.t_end, s.t_start + INSTANT) for s in segments)
    return _drift_shapes(tuple(s.t_start for s in segments), tuple(stops))


@lru_cache(maxsize=8)  # the same segments come for every channel, and for every correction
def _drift_shapes(starts: tuple[float, ...], stops: tuple[float, ...]) -> np.ndarray:
    """(DRIFTS, n, n), not to be written to, of the intervals between starts and stops (n,) s."""
    start, stop = np.array(starts), np.array(stops)
    first, last = start.min(), stop.max()
    flickers = [_mean_flicker(start, stop, level) for level in LEVELS]
    # The mean distance between two intervals, the whole run the last of them.
    apart = _mean_of(lambda x: x**3 / 6.0, np.append(start, first), np.append(stop, last))
    to_run = apart[:-1, -1]
    walk = 0.5 * (to_run[:, None] + to_run[None, :] - apart[:-1, :-1] - apart[-1, -1])
    middle = 0.5 * (start + stop - first - last)
    shapes = np.array([*flickers, walk, np.outer(middle, middle)])
    shapes.flags.writeable = False
    return shapes


def drift_allan(tau: np.ndarray) -> np.ndarray:
    """Allan variance (DRIFTS, …) per unit of each drift's strength (IEEE Std 952, C)."""
    x = tau / np.reshape(LEVELS, (-1, *[1] * np.ndim(tau)))
    once, twice = flicker_integral(np.array([x, 2.0 * x]))
    return np.array([*(4.0 * once - twice) / x**2, tau / 3.0, tau**2 / 2.0])


def drift_strengths(contrasts: Contrasts, allan: PooledAllan) -> np.ndarray:
    """Mean strength (DRIFTS,) of each flicker, of walk and of trend over their likelihood.

    Without contrasts between segments the Allan variances know of flicker only. The first, wide
    grid finds where the second, fine one has to be.
    """
    scales = _detectable_strengths(contrasts, allan)
    grids = [_wide_grid(contrasts, allan, shape, scale) for shape, scale in enumerate(scales)]
    posterior = _posterior(grids, scales, contrasts, allan)
    grids = [_fine_grid(grid, _marginal(posterior, shape)) for shape, grid in enumerate(grids)]
    posterior = _posterior(grids, scales, contrasts, allan)
    strengths = np.zeros(DRIFTS)
    strengths[: len(LEVELS)] = posterior.sum(axis=tuple(range(2, posterior.ndim))) @ grids[0]
    for shape in range(1, len(grids)):
        strengths[len(LEVELS) + shape - 1] = _marginal(posterior, shape) @ grids[shape]
    return strengths


def white_of(allan: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """N² (…) of Allan variances (…, levels): times τ, averaged, as each level knows it."""
    degrees = _differences(tau.shape[-1])
    return (allan * tau) @ degrees / degrees.sum()


def _differences(levels: int) -> np.ndarray:
    """Neighbouring blocks that each Allan variance compares, finest first."""
    return 2.0 ** np.arange(levels, 0, -1) - 1


def _detectable_strengths(contrasts: Contrasts, allan: PooledAllan) -> list[float]:
    """Strength of flicker, walk and trend that equals the white noise where it shows best."""
    if contrasts.value.size:
        return (1.0 / contrasts.gain.max(axis=(0, 2))).tolist()
    detectable = math.sqrt(2.0 / float(allan.degrees[-1]))  # of the longest blocks' white noise
    return [detectable * allan.white / float(allan.tau[-1]) / FLICKER_ALLAN]


def _wide_grid(contrasts: Contrasts, allan: PooledAllan, shape: int, scale: float) -> np.ndarray:
    """Strengths (0 first) from below the white noise to more than the data hold."""
    largest = 10.0 * FAINTEST_SHARE * scale
    if shape == 0:
        largest = max(largest, 3.0 * float(allan.variance.max()) / FLICKER_ALLAN)
    if contrasts.value.size:
        gain = contrasts.gain[:, shape].sum(axis=1).min()
        largest = max(largest, 10.0 * float((contrasts.value[0] ** 2).sum() / gain))
    return strength_grid(FAINTEST_SHARE * scale, largest)


def _fine_grid(grid: np.ndarray, posterior: np.ndarray) -> np.ndarray:
    """As many strengths where the posterior is."""
    supported = np.flatnonzero(posterior[1:] > 1e-3 * posterior.max()) + 1
    low, high = (supported[0], supported[-1]) if len(supported) else (1, 1)
    return strength_grid(grid[max(low - 1, 1)], grid[min(high + 1, len(grid) - 1)])


def strength_grid(lowest: float, largest: float) -> np.ndarray:
    """0, and GRID_POINTS strengths that grow by one factor."""
    share = np.arange(GRID_POINTS) / (GRID_POINTS - 1)
    return np.append(0.0, lowest * (largest / lowest) ** share)


def _marginal(posterior: np.ndarray, shape: int) -> np.ndarray:
    """Marginal posterior of the strengths of one drift."""
    return posterior.sum(axis=tuple(axis for axis in range(posterior.ndim) if axis != shape + 1))


def _posterior(
    grids: list[np.ndarray], scales: list[float], contrasts: Contrasts, allan: PooledAllan
) -> np.ndarray:
    """Posterior (LEVELS, …) of the level at which flicker ends and of the strengths.

    A priori all levels are equally probable. A drift is absent by PRIOR_ABSENT; else its share in
    the sum of itself and its PRIOR_MEDIAN strength is uniform between 0 and 1 (uniform shrinkage
    prior: Daniels, Canad. J. Statist. 27, 1999).
    """
    strengths = np.array(np.meshgrid(*grids, indexing="ij"))
    likelihood = _likelihood(strengths.reshape(len(grids), -1), contrasts, allan)
    likelihood = likelihood.reshape(-1, *strengths.shape[1:])
    posterior = np.exp(likelihood - likelihood.max())
    for shape, (grid, scale) in enumerate(zip(grids, scales, strict=True)):
        prior = strength_prior(grid, PRIOR_MEDIAN[shape] * scale, PRIOR_ABSENT[shape])
        posterior *= prior.reshape([-1 if j == shape else 1 for j in range(len(grids))])
    return posterior / posterior.sum()


def _likelihood(strengths: np.ndarray, contrasts: Contrasts, allan: PooledAllan) -> np.ndarray:
    """Logarithm of the likelihood (LEVELS, n) of strengths (1 or 3, n), flicker to each level."""
    drifts = [[level, WALK, TREND][: len(strengths)] for level in range(len(LEVELS))]
    slow = allan.drifting[drifts].swapaxes(1, 2) @ strengths  # (LEVELS, levels, n)
    variance, tau = allan.variance[:, None], allan.tau[:, None]
    white = white_of((variance - slow).swapaxes(1, 2), allan.tau)
    white = np.maximum(white, 1e-3 * allan.white)[:, None]
    expected = white / tau + slow
    likelihood = -0.5 * allan.degrees @ (np.log(expected) + variance / expected)
    if contrasts.value.size:
        spread = contrasts.gain.swapaxes(1, 2) @ strengths
        spread += white / allan.white
        logarithm = np.log(spread).sum(axis=1)
        square = contrasts.value[:, None] ** 2
        likelihood -= 0.5 * (logarithm + (square @ np.reciprocal(spread, out=spread))[:, 0])
    return np.asarray(likelihood)


def strength_prior(grid: np.ndarray, median: float, absent: float) -> np.ndarray:
    """Prior weight of each strength (0 first), if s/(s + median) is uniform between 0 and 1.

    absent: probability that the strength is zero whatever the median.
    """
    edges = np.concatenate([[0.5 * grid[1]], np.sqrt(grid[1:-1] * grid[2:])])
    above = median / (edges + median)  # probability to exceed each edge, not 1 − probability
    weights = np.concatenate([[edges[0] / (edges[0] + median)], -np.diff(above), above[-1:]])
    weights *= 1.0 - absent
    weights[0] += absent
    return np.asarray(weights)


def flicker_integral(x: np.ndarray) -> np.ndarray:
    """Twice the integral of E₁ from 0 to x ≥ 0: E₁(|t|/L) is the autocovariance of flicker."""
    from scipy.special import exp1  # late: a tenth of a start

    bounded = np.where(x > 0, x, 1.0)
    bent = np.where(x > 0, 0.5 * x**2 * exp1(bounded), 0.0)
    return bent + x - 0.5 + 0.5 * (1.0 - x) * np.exp(-x)


def _mean_flicker(start: np.ndarray, stop: np.ndarray, level: float) -> np.ndarray:
    """Mean of E₁(|t − s|/level) over t in interval i and s in interval j, (n, n)."""
    return _mean_of(lambda x: level**2 * flicker_integral(x / level), start, stop)


def _mean_of(
    second_integral: Callable[[np.ndarray], np.ndarray], start: np.ndarray, stop: np.ndarray
) -> np.ndarray:
    """Mean over two intervals of a function of |t − s| that has this second integral."""
    a, b = start[:, None], stop[:, None]
    c, d = start[None, :], stop[None, :]
    total = second_integral(np.abs(b - c)) + second_integral(np.abs(a - d))
    total -= second_integral(np.abs(b - d)) + second_integral(np.abs(a - c))
    return total / ((b - a) * (d - c))
