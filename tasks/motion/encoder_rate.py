"""The rate of an encoder's angle, over as long a window as the motion at each sample permits.

A window that is short enough for the ends of a ramp makes a coarse encoder's noise a hundred times
larger than it need be at rests and held rates. So of polynomials fitted to longer and longer
windows each sample takes the longest whose rate still agrees, within its noise, with those of all
shorter ones (intersection of confidence intervals: Goldenshluger and Nemirovski, Math. Meth.
Statist. 6, 1997), and then one half as long, whose bias is small beside its noise. A rest has the
rate of all of it.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

SIDE = 0.25  # s: means on both sides of a sample, whose difference shows a motion
SHORTEST = 0.5  # s
AHEAD = 0.06  # s: means by which the end of a rest is found, and how far it stays before it
FEWEST_AHEAD = 3  # samples
MOVED, LEFT, SLOPING = 4.0, 2.5, 3.0  # standard deviations
SHAKING = 1.4  # times the noise: more is a motion
RATE_WINDOW = 0.05  # s: the shortest
LONGEST_HALF = 1.0  # s
FEWEST_HALF = 2  # samples on each side that a quartic needs
GROWTH, HALVED = np.sqrt(2.0), 2  # from window to window, and the windows that make one half
AGREEING = 3.0  # standard deviations
MANY = 3  # shortest windows over which a choice has to be usual
QUIET = 1e-4  # rad/s: noise of the shortest window that no longer one has to make smaller
ROUNDING = 1e-12  # rad: an angle that changes by less stands still


# Rests shown by a coarse encoder, each of which has one rate as a whole.
#
# A window about each sample is short beside the ends of a ramp, so that the encoder's noise makes
# rates there that nothing has; a unit that does not follow them seems to read small rates too small
# (attenuation by errors in the regressor; Fuller, Measurement Error Models, 1987). A rest is a
# stretch that a line of no slope fits, or of one by which it moves less than a sample's noise: that
# slope, by all of its samples, is the rate of each.


@dataclass(frozen=True)
class Rest:
    """Samples `first` to `last` (exclusive) of one angle; rate and its uncertainty u, rad/s."""

    first: int
    last: int
    rate: float
    u: float


@dataclass(frozen=True)
class EncoderRate:
    """Rate (n, k) rad/s of angles, and its variance.

    chosen: (n, k) which of the kernels; they are per sample, in symmetric order. interval: s.
    at_rest: (n, k) bool, the rate is that of a whole rest.
    """

    rate: np.ndarray
    variance: np.ndarray
    chosen: np.ndarray
    at_rest: np.ndarray
    kernels: tuple[np.ndarray, ...]
    interval: float

    def variance_of_mean(self, width: float) -> np.ndarray:
        """(n, k) of means over `width` s."""
        box = np.full(max(1, round(width / self.interval)), 1.0)
        gain = [
            (np.convolve(kernel, box / len(box)) ** 2).sum() / (kernel**2).sum()
            for kernel in self.kernels
        ]
        return np.asarray(self.variance * np.where(self.at_rest, 1.0, np.array(gain)[self.chosen]))


def encoder_rate(angle: np.ndarray, interval: float, variance: np.ndarray) -> EncoderRate:
    """Of angles (n, k) rad on an even grid, whose samples have variance (n, k) rad²."""
    from scipy.ndimage import median_filter, minimum_filter  # late: a quarter of a start

    kernels = _kernels(angle, interval, variance)
    rates, variances = [], []
    low, high = np.full(angle.shape, -np.inf), np.full(angle.shape, np.inf)
    chosen, agrees = np.zeros(angle.shape, int), np.ones(angle.shape, bool)
    row = np.arange(len(angle))[:, None]
    inside = np.minimum(row, row[::-1])  # samples to the nearer end
    for number, kernel in enumerate(kernels):
        rates.append(filtered(angle, kernel) / interval)
        variances.append(np.maximum(filtered(variance, kernel**2), 0.0) / interval**2)
        within = AGREEING * np.sqrt(variances[-1]) + ROUNDING / interval
        low, high = np.maximum(low, rates[-1] - within), np.minimum(high, rates[-1] + within)
        agrees &= (low <= high) & ((inside >= len(kernel) // 2) | (number == 0))
        chosen[agrees] = number
    # Chance ends a window at single samples, a corner of the motion at as many as it is long.
    chosen = median_filter(chosen, size=(MANY * (len(kernels[0]) // 2) * 2 + 1, 1))
    # Only where nothing ends the longest window all around is there no bias to keep small.
    unlimited = minimum_filter(chosen, size=(len(kernels[-1]) // 2, 1)) == len(kernels) - 1
    chosen = np.where(unlimited, chosen, np.maximum(chosen - HALVED, 0))
    rate, of_rate = (
        np.take_along_axis(np.array(every), chosen[None], axis=0)[0] for every in (rates, variances)
    )
    at_rest = np.zeros(angle.shape, bool)
    for k in range(angle.shape[1]) if len(kernels) > 1 else ():
        for rest in rests(angle[:, k], interval, variance[:, k]):
            rows = slice(rest.first, rest.last)
            rate[rows, k], of_rate[rows, k], at_rest[rows, k] = rest.rate, rest.u**2, True
    return EncoderRate(rate, of_rate, chosen, at_rest, kernels, interval)


def _kernels(angle: np.ndarray, interval: float, variance: np.ndarray) -> tuple[np.ndarray, ...]:
    """First derivatives of quartics, from the noisiest on; last the parabola, quieter by half."""
    half = half_window(RATE_WINDOW, interval, len(angle))
    if half < FEWEST_HALF:
        return (_slope(half, 2),)
    shortest = _slope(half, 4)
    noise = np.sqrt(variance.max(initial=0.0)) * np.linalg.norm(shortest) / interval
    if noise <= QUIET:
        return (shortest,)
    longest = min(LONGEST_HALF / interval, len(angle) / 8)
    count = 1 + max(0, int(np.log(longest / half) / np.log(GROWTH)))
    halves = np.unique(np.round(half * GROWTH ** np.arange(count)).astype(int)).tolist()
    return (*(_slope(each, 4) for each in halves), _slope(halves[-1], 2))


def _slope(half: int, degree: int) -> np.ndarray:
    place = np.arange(-half, half + 1.0) / half
    return np.asarray(np.linalg.pinv(np.vander(place, degree + 1, increasing=True))[1] / half)


def half_window(window: float, interval: float, count: int) -> int:
    """Samples on each side of one of `count`, for a window in s."""
    # Stamps are rounded: half a sample more or less must not depend on their last digit.
    wanted = round(0.5 * window / interval - 1e-6)
    return min(max(FEWEST_HALF, wanted), max(1, (count - 1) // 2))


def filtered(values: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    """Correlation of each column with a kernel; the ends go on straight (odd reflection)."""
    half = len(kernel) // 2
    before = 2 * values[:1] - values[half:0:-1]
    after = 2 * values[-1:] - values[-2 : -half - 2 : -1]
    padded = np.concatenate([before, values, after])
    return np.column_stack([np.convolve(c, kernel[::-1], "valid") for c in padded.T])


def rests(angle: np.ndarray, interval: float, variance: np.ndarray) -> Iterator[Rest]:
    """The rests of one angle (n,) rad on an even grid, whose samples have variance (n,) rad²."""
    from scipy.ndimage import binary_erosion, uniform_filter1d  # late: see encoder_rate

    side = max(FEWEST_AHEAD, round(SIDE / interval))
    if len(angle) < 4 * side:
        return
    before, after = _means(angle, side)
    # A rest at the edge of a code flickers by more than codes err elsewhere.
    flicker = np.pad(np.diff(angle, 2) ** 2, 1) / 6.0
    noise = np.sqrt(np.maximum(variance, uniform_filter1d(flicker, 2 * side + 1)))
    still = np.abs(after - before) <= MOVED * noise * np.sqrt(2.0 / side)
    core = binary_erosion(still, np.ones(2 * side + 1))
    edges = np.flatnonzero(np.diff(np.concatenate([[False], core, [False]]).astype(int)))
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if (last - first) * interval >= SHORTEST:
            rest = _rest(angle, interval, noise, first, last)
            if rest is not None:
                yield rest


def _means(angle: np.ndarray, side: int) -> tuple[np.ndarray, np.ndarray]:
    """(n,) of `side` samples before each one, and from it on; NaN where there are fewer."""
    total = np.concatenate([[0.0], np.cumsum(angle - angle[0])])
    means = (total[side:] - total[:-side]) / side
    missing = np.full(side, np.nan)
    before = np.concatenate([missing, means])[: len(angle)]
    return before, np.concatenate([means, missing])[: len(angle)]


def _rest(
    angle: np.ndarray, interval: float, noise: np.ndarray, first: int, last: int
) -> Rest | None:
    """The rest around samples that stand still; None where they follow a slope, shake, or are too
    few to show it.
    """
    count = last - first
    if count < 2:  # of an encoder that is read slowly: one sample shows no slope
        return None
    place = np.arange(count) - 0.5 * (count - 1)
    spread = float((place**2).sum())
    slope = float(place @ angle[first:last]) / spread
    usual = float(np.sqrt((noise[first:last] ** 2).mean()))
    u = usual / spread**0.5
    scatter = float(np.std(angle[first:last] - slope * place))
    if abs(slope) > max(SLOPING * u, usual / count) or scatter > SHAKING * usual:
        return None
    near = 3 * max(FEWEST_AHEAD, round(SIDE / interval))  # more than what the core is short of
    start, end = max(0, first - near), min(len(angle), last + near)
    line = slope * (np.arange(start, end) - first - place[-1]) + angle[first:last].mean()
    off, own_noise = angle[start:end] - line, noise[start:end]
    ahead = max(FEWEST_AHEAD, round(AHEAD / interval))
    forward = _reach(off[last - start :], own_noise[last - start :], ahead)
    back = _reach(off[: first - start][::-1], own_noise[: first - start][::-1], ahead)
    if first - back >= last + forward:
        return None
    return Rest(first - back, last + forward, slope / interval, u / interval)


def _reach(off: np.ndarray, noise: np.ndarray, ahead: int) -> int:
    """How many samples go on as the rest did, until the motion that then shows began.

    off, noise: (m,) rad, distance of the samples from the rest and its standard deviation. What
    begins to turn is four times as far off when twice the time has passed: so it began as long
    before it showed as it then took to be four times as far off, or later. May be negative.
    """
    if len(off) < ahead:
        return 0
    means = np.abs(np.convolve(off, np.ones(ahead) / ahead, "valid"))
    limit = LEFT * noise[: len(means)] / np.sqrt(ahead)
    gone, far = means > limit, means > 4.0 * limit
    turned = int(far.argmax()) if far.any() else len(far)
    shown = turned - int(np.append(~gone[:turned][::-1], True).argmax())  # not what shows by chance
    if shown == len(far):
        return len(off)
    return 2 * shown - turned - 1 if far.any() else shown - 1
