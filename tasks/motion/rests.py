"""Rests shown by a coarse encoder, each of which has one rate as a whole.

A window about each sample is short beside the ends of a ramp, so that the encoder's noise makes
rates there that nothing has; a unit that does not follow them seems to read small rates too small
(attenuation by errors in the regressor; Fuller, Measurement Error Models, 1987). A rest is a
stretch that a line of no slope fits, or of one by which it moves less than a sample's noise: that
slope, by all of its samples, is the rate of each.
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


@dataclass(frozen=True)
class Rest:
    """Samples `first` to `last` (exclusive) of one angle; rate and its uncertainty u, rad/s."""

    first: int
    last: int
    rate: float
    u: float


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
    """The rest around samples that stand still; None where they follow a slope, or shake."""
    count = last - first
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
