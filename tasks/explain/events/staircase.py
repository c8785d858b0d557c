"""The staircase that lost samples leave in the delays of short windows."""

from dataclasses import dataclass

import numpy as np

from tasks.explain.events.delays import WindowDelays

MIN_WINDOWS = 6
MAX_LOST = 30  # samples in all
CHANGE_POINT_COST = 30.0  # chi-squared that a further loss must gain
MIN_GAIN = 75.0  # chi-squared that losses must gain against a constant and a running delay
CLOSE = 0.2  # sample intervals: half of the windows lie nearer to the staircase
WHOLE = 0.25  # sample intervals that a step may be off a whole number


@dataclass(frozen=True)
class Staircase:
    """Whole samples lost (m,) before each window of the delays, from 0 up."""

    delays: WindowDelays
    lost: np.ndarray

    @property
    def first(self) -> float:
        """The delay before the first loss, in sample intervals."""
        return float(np.median(self.delays.delay - self.lost))

    @property
    def gain(self) -> float:
        """Chi-squared against a constant delay."""
        constant = self.delays.cost(np.median(self.delays.delay)).sum()
        return float(constant - self.delays.cost(self.first + self.lost).sum())

    @property
    def u(self) -> float:
        """Standard uncertainty of the number of samples that a step is high."""
        levels = (self.delays.u[self.lost == level] for level in np.unique(self.lost))
        return max(float(np.median(level)) / len(level) ** 0.5 for level in levels)

    def delay(self, t: np.ndarray) -> np.ndarray:
        """The delay (n,) at times t (n,) s, in sample intervals."""
        window = np.clip(np.searchsorted(self.delays.at, t), 0, len(self.lost) - 1)
        return self.first + self.lost[window]


def fit_staircase(delays: WindowDelays) -> Staircase | None:
    """The staircase of the delays; None if they do not form one."""
    if len(delays.at) < MIN_WINDOWS:
        return None
    path, start = _best_path(delays)
    if path[0] != 0 or path[-1] == 0 or path[-1] >= MAX_LOST:
        return None
    constant = delays.cost(np.median(delays.delay)).sum()
    if min(constant, _drift_cost(delays)) - _cost(delays, path, start) < MIN_GAIN:
        return None
    close = float(np.median(np.abs(delays.delay - start - path))) < CLOSE
    if not close and 2 * delays.cost(start + path).sum() > constant:
        return None
    levels = [float(np.median(delays.delay[path == step])) - step for step in np.unique(path)]
    return Staircase(delays, path) if np.ptp(levels) < WHOLE else None


def _cost(delays: WindowDelays, path: np.ndarray, start: float) -> float:
    """Chi-squared of a staircase, its change points included."""
    steps = CHANGE_POINT_COST * np.count_nonzero(np.diff(path))
    return float(delays.cost(start + path).sum() + steps)


def _best_path(delays: WindowDelays) -> tuple[np.ndarray, float]:
    """The cheapest staircase (m,) and its first delay, from several first delays to begin with."""
    candidates = []
    for first in np.unique(np.round(delays.delay[: max(3, len(delays.at) // 4)], 1)):
        path = _cheapest_path(delays, float(first))
        for _ in range(3):
            start = float(np.median(delays.delay - path))
            path = _cheapest_path(delays, start)
        candidates.append((path, start))
    return min(candidates, key=lambda candidate: _cost(delays, *candidate))


def _cheapest_path(delays: WindowDelays, start: float) -> np.ndarray:
    """The rising staircase of least cost, by dynamic programming over the samples lost."""
    states = np.arange(MAX_LOST + 1)
    cost = delays.cost(start + states[:, None])  # (states, windows)
    total = np.where(states == 0, cost[:, 0], np.inf)
    came_from = np.zeros(cost.shape, int)
    for k in range(1, cost.shape[1]):
        best = np.minimum.accumulate(total)
        first = np.maximum.accumulate(np.where(total == best, states, 0))
        jump = np.concatenate([[np.inf], best[:-1]]) + CHANGE_POINT_COST
        stay = total <= jump
        came_from[:, k] = np.where(stay, states, np.concatenate([[0], first[:-1]]))
        total = np.where(stay, total, jump) + cost[:, k]
    path = [int(total.argmin())]
    for k in range(cost.shape[1] - 1, 0, -1):
        path.append(int(came_from[path[-1], k]))
    return np.array(path[::-1], float)


def _drift_cost(delays: WindowDelays) -> float:
    """Chi-squared of a delay that grows evenly, as of a clock that runs fast (robust line fit)."""
    weight = 1 / delays.u
    line = np.polyfit(delays.at, delays.delay, 1, w=weight)
    for _ in range(5):
        off = np.abs(delays.delay - np.polyval(line, delays.at)) * weight
        line = np.polyfit(delays.at, delays.delay, 1, w=weight / np.sqrt(np.maximum(off / 2, 1)))
    return float(delays.cost(np.polyval(line, delays.at)).sum())
