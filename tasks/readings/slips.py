"""Stamps that slip where a logger closes the gaps that lost samples leave.

It numbers the rows that arrive, so that after each loss the stamps are that many samples early. In
windows in which the motion changes, the delay of the readings beside the motion tells it: a
staircase of whole samples.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from tasks.motion.samples import interpolated, noise_by_differences

WINDOW = 4.0  # s: in a shorter one, one oscillation passes for the next
ROWS = 120  # of a window that are compared
REACH = 0.35  # s that all stamps may be late or early from the beginning
MAX_LOST = 300  # samples in all
STEP = 0.1  # sample intervals between delays whose misfit is looked up
ORDER = 4  # of the differences that the readings' noise is read off
OUTLIER = 50.0  # chi-squared that one window may cost at most
MAX_U = 0.25  # of a sample interval: windows that know the delay worse are left out
MODEL_U = 0.08  # of a sample interval: what else may look like a delay in a window
MIN_WINDOWS = 6
CHANGE_POINT_COST = 40.0  # chi-squared that a further loss must gain: less than one window has
MIN_GAIN = 75.0  # chi-squared that losses must gain against a constant and a running delay
CHANGE_IN_ROWS = 300.0  # chi-squared, of rows: a small error of the model adds up over hundreds
LIKELY = 25.0  # chi-squared: what the model misses at rest makes a few
SHARP, SURE = 10, 4.0  # rows that are likely, and chi-squared: where it moves, that is enough
CLOSE = 0.2  # sample intervals: half of the windows lie nearer to the staircase
FEW = 3  # windows: a level of fewer may be those in which samples were lost
WHOLE = 0.25  # sample intervals that a step may be off a whole number


@dataclass(frozen=True)
class WindowDelays:
    """Delays of m windows in sample intervals: at (m,) s, delay, u (m,); width: of a window, s.

    table: (m, tried) chi-squared of delays from `earliest` on, in steps of STEP.
    """

    at: np.ndarray
    delay: np.ndarray
    u: np.ndarray
    width: float
    table: np.ndarray
    earliest: float

    def cost(self, delay: np.ndarray | float) -> np.ndarray:
        """Chi-squared (..., m) of supposed delays, of no window more than an outlier's."""
        place = np.round((np.asarray(delay) - self.earliest) / STEP).astype(int)
        place = np.clip(place, 0, self.table.shape[1] - 1)
        return np.asarray(np.minimum(self.table[np.arange(len(self.at)), place], OUTLIER))


@dataclass(frozen=True)
class Staircase:
    """Whole samples lost (m,) before each window of the delays, from 0 up."""

    delays: WindowDelays
    lost: np.ndarray

    @cached_property
    def first(self) -> float:
        """The delay before the first loss, in sample intervals."""
        return float(np.median(self.delays.delay - self.lost))

    @property
    def gain(self) -> float:
        """Chi-squared against a constant delay."""
        constant = self.delays.cost(float(np.median(self.delays.delay))).sum()
        return float(constant - self.delays.cost(self.first + self.lost).sum())

    @property
    def u(self) -> float:
        """Standard uncertainty of the number of samples that a step is high."""
        levels = (self.delays.u[self.lost == level] for level in np.unique(self.lost))
        return max(float(np.median(level)) / len(level) ** 0.5 for level in levels)

    def delay(self, t: np.ndarray) -> np.ndarray:
        """The delay (n,) at times t (n,) s, in sample intervals."""
        window = np.clip(np.searchsorted(self.delays.at, t), 0, len(self.lost) - 1)
        return np.asarray(self.first + self.lost[window])


def window_delays(
    t: np.ndarray, interval: float, readings: np.ndarray, signal: np.ndarray
) -> WindowDelays | None:
    """The delay of readings (n, k) beside a signal (n, k), both at t (n,) s, window by window.

    Beside the delay, each channel of a window has a bias and a scale factor of its own, not below
    zero: those of the whole run are not known before the losses are. NaN where either is not known.
    None where no window tells a delay.
    """
    lags = np.arange(-np.ceil(REACH / interval), np.ceil(REACH / interval) + MAX_LOST + 1.0)
    noise = np.array([noise_by_differences(c[np.isfinite(c)], ORDER, 0.5) for c in readings.T])
    if not (noise > 0.0).any():
        return None
    own = noise > 0.0
    white, signal = readings[:, own] / noise[own], signal[:, own] / noise[own]
    known = np.isfinite(white).all(axis=1)
    unknown = np.concatenate([[0], np.cumsum(~np.isfinite(signal).all(axis=1))])
    window = ((t - t[0]) / WINDOW).astype(int)
    at, tables, rows = [], [], []
    for number in range(int(window[-1]) + 1):
        first, last = np.searchsorted(window, (number, number + 1))
        here = first + np.flatnonzero(known[first:last])
        if len(here) < 0.5 * WINDOW / interval:
            continue
        here = here[:: 1 + len(here) // ROWS]
        read = white[here] - white[here].mean(axis=0)
        if (read**2).mean() < 2.0:  # nothing but noise
            continue
        reach = np.searchsorted(t, t[here[[0, -1]]] + lags[[0, -1]] * interval) + np.array([-1, 1])
        if np.ptp(unknown[np.clip(reach, 0, len(t))]):
            continue
        moved = (t[here] + lags[:, None] * interval).ravel()
        tables.append(
            _misfits(read, interpolated(moved, t, signal).reshape(len(lags), *read.shape))
        )
        at.append(0.5 * (t[here[0]] + t[here[-1]]))
        rows.append(read.size)
    if not at:
        return None
    misfit, size = np.array(tables), np.array(rows, float)
    level = max(1.0, float(np.median(misfit.min(axis=1) / size)))
    chi2 = (misfit - misfit.min(axis=1, keepdims=True)) / level
    return _sharp(np.array(at), lags, chi2)


def _misfits(read: np.ndarray, signal: np.ndarray) -> np.ndarray:
    """Sums of squares (lags,) that a scale factor and a bias for each channel leave of readings
    (n, k) without their mean, given signals (lags, n, k).
    """
    about = signal - signal.mean(axis=1, keepdims=True)
    both, power = (about * read).sum(axis=1), (about**2).sum(axis=1)
    explained = np.maximum(both, 0.0) ** 2 / np.maximum(power, 1e-12)
    return np.asarray((read**2).sum() - explained.sum(axis=1))


def _sharp(at: np.ndarray, lags: np.ndarray, chi2: np.ndarray) -> WindowDelays | None:
    """The delays of windows at (m,) s that tell one, by the chi-squared (m, lags)."""
    best = chi2.argmin(axis=1)
    inside = (best > 0) & (best < len(lags) - 1)
    at, chi2, best = at[inside], chi2[inside], best[inside]
    own = np.arange(len(at))
    beside = np.minimum(chi2[own, best - 1], chi2[own, best + 1])
    beside_of_both = 0.5 * (chi2[own, best - 1] + chi2[own, best + 1])
    u = 1.0 / np.sqrt(np.maximum(beside_of_both, 1e-12))
    sharp = (u < MAX_U) & (beside > 0.0)
    if not sharp.any():
        return None
    chi2, u, at = chi2[sharp], u[sharp], at[sharp]
    fine = np.arange(lags[0], lags[-1] + STEP / 2, STEP)
    table = CubicSpline(lags, chi2, axis=1)(fine)
    table -= table.min(axis=1, keepdims=True)
    table *= (u**2 / (u**2 + MODEL_U**2))[:, None]
    delay = fine[table.argmin(axis=1)]
    return WindowDelays(at, delay, np.hypot(u, MODEL_U), WINDOW, table, float(lags[0]))


def fit_staircase(delays: WindowDelays) -> Staircase | None:
    """The staircase of the delays; None if they do not form one."""
    if len(delays.at) < MIN_WINDOWS:
        return None
    path, start = _best_path(delays)
    if path[0] != 0 or path[-1] == 0 or path[-1] >= MAX_LOST:
        return None
    constant = delays.cost(float(np.median(delays.delay))).sum()
    if min(constant, _drift_cost(delays)) - _cost(delays, path, start) < MIN_GAIN:
        return None
    close = float(np.median(np.abs(delays.delay - start - path))) < CLOSE
    if not close and 2 * delays.cost(start + path).sum() > constant:
        return None
    steps, held = np.unique(path, return_counts=True)
    levels = [np.median(delays.delay[path == step]) - step for step in steps[held >= FEW]]
    return Staircase(delays, path) if not levels or np.ptp(levels) < WHOLE else None


def _cost(delays: WindowDelays, path: np.ndarray, start: float) -> float:
    """Chi-squared of a staircase, its change points included."""
    steps = CHANGE_POINT_COST * np.count_nonzero(np.diff(path))
    return float(delays.cost(start + path).sum() + steps)


def _best_path(delays: WindowDelays) -> tuple[np.ndarray, float]:
    """The cheapest staircase (m,) and its first delay, from several first delays to begin with."""
    candidates = []
    for first in np.unique(np.round(delays.delay[: max(3, len(delays.at) // 4)], 1)):
        start, states = float(first), np.arange(MAX_LOST + 1)[:, None]
        path = cheapest_path(delays.cost(start + states))
        for _ in range(3):
            start = float(np.median(delays.delay - path))
            path = cheapest_path(delays.cost(start + states))
        candidates.append((path, start))
    return min(candidates, key=lambda candidate: _cost(delays, *candidate))


def cheapest_path(cost: np.ndarray, change: float = CHANGE_POINT_COST) -> np.ndarray:
    """The rising staircase (n,) from 0 up of least cost (states, n), each of its change points
    included, by dynamic programming over the samples lost.
    """
    states = np.arange(len(cost))
    total = np.where(states == 0, cost[:, 0], np.inf)
    came_from = np.zeros(cost.shape, int)
    for k in range(1, cost.shape[1]):
        best = np.minimum.accumulate(total)
        first = np.maximum.accumulate(np.where(total == best, states, 0))
        jump = np.concatenate([[np.inf], best[:-1]]) + change
        stay = total <= jump
        came_from[:, k] = np.where(stay, states, np.concatenate([[0], first[:-1]]))
        total = np.where(stay, total, jump) + cost[:, k]
    path = [int(total.argmin())]
    for k in range(cost.shape[1] - 1, 0, -1):
        path.append(int(came_from[path[-1], k]))
    return np.array(path[::-1], float)


def placed(cost: np.ndarray) -> Iterator[tuple[int, int, int]]:
    """The jumps of the cheapest staircase of a cost (states, n): the first and the last place that
    each may have, up to a chi-squared of LIKELY, and how high it is.
    """
    path = cheapest_path(cost, CHANGE_IN_ROWS).astype(int)
    after = np.flatnonzero(np.diff(path)) + 1
    for before, place, behind in zip(
        [0, *after[:-1].tolist()], after.tolist(), [*after[1:].tolist(), len(path) - 1], strict=True
    ):
        here = slice(before, behind)
        # What it costs that the jump comes later: what is before it, and after it.
        beside = cost[path[place - 1], here] - cost[path[place], here]
        course = np.concatenate([[0.0], np.cumsum(beside)])
        likely = before + np.flatnonzero(course <= course.min() + LIKELY)
        if len(likely) <= SHARP:
            likely = before + np.flatnonzero(course <= course.min() + SURE)
        yield int(likely[0]), int(likely[-1]), int(path[place] - path[place - 1])


def _drift_cost(delays: WindowDelays) -> float:
    """Chi-squared of a delay that grows evenly, as of a clock that runs fast (robust line fit)."""
    weight = 1 / delays.u
    line = np.polyfit(delays.at, delays.delay, 1, w=weight)
    for _ in range(5):
        off = np.abs(delays.delay - np.polyval(line, delays.at)) * weight
        line = np.polyfit(delays.at, delays.delay, 1, w=weight / np.sqrt(np.maximum(off / 2, 1)))
    return float(delays.cost(np.polyval(line, delays.at)).sum())
