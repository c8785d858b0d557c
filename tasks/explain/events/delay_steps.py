"""Whole samples lost, as change points: a rising staircase fitted to the delays of windows."""

import numpy as np

from tasks.explain.events.window_delays import WindowDelays

MIN_WINDOWS = 6
MAX_LOST = 30  # samples in all
CHANGE_POINT_COST = 30.0  # chi-squared that a further loss must gain
MIN_GAIN = 100.0  # chi-squared that losses must gain against a constant and a running delay
CLOSE = 0.2  # sample intervals: half of the windows lie nearer to the staircase
WHOLE = 0.25  # sample intervals that a step may be off a whole number


def staircase(delays: WindowDelays) -> np.ndarray | None:
    """Whole samples lost (m,) before each window; None where the delays are no staircase."""
    if len(delays.at) < MIN_WINDOWS:
        return None
    path, start = _best_staircase(delays)
    if path[0] != 0 or path[-1] == 0 or path[-1] >= MAX_LOST:
        return None
    constant = delays.cost(np.median(delays.delay)).sum()
    if min(constant, _drift_cost(delays)) - _cost(delays, path, start) < MIN_GAIN:
        return None
    close = float(np.median(np.abs(delays.delay - start - path))) < CLOSE
    if not close and 2 * delays.cost(start + path).sum() > constant:
        return None
    return path if _steps_are_whole(delays, path) else None


def _cost(delays: WindowDelays, path: np.ndarray, start: float) -> float:
    """Chi-squared of a staircase, its change points included."""
    steps = CHANGE_POINT_COST * np.count_nonzero(np.diff(path))
    return float(delays.cost(start + path).sum() + steps)


def _best_staircase(delays: WindowDelays) -> tuple[np.ndarray, float]:
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


def _steps_are_whole(delays: WindowDelays, path: np.ndarray) -> bool:
    """Whether every step stands a whole number of samples above the first."""
    level = [float(np.median(delays.delay[path == step])) - step for step in np.unique(path)]
    return bool(np.ptp(level) < WHOLE)
