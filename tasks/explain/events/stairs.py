"""Whole samples lost by the delays of cells: stairs that rise, and nothing else."""

from dataclasses import dataclass

import numpy as np

from tasks.explain.events.matched import Matched

CELL = 1.0  # s, within which a delay is told
MOST = 30  # samples lost in all
OUTLIER = 25.0  # chi-squared that one cell may cost at most
STEP = 30.0  # chi-squared that a further loss must gain
GAIN = 100.0  # chi-squared that losses must gain against a constant and a running delay
CLOSE = 0.2  # sample intervals: half of the cells lie nearer to the stairs
WHOLE = 0.25  # sample intervals that a jump may be off a whole number


@dataclass(frozen=True)
class Delays:
    """Delays of cells in sample intervals: at (m,) s, delay, u (m,); width: of a cell, s."""

    at: np.ndarray
    delay: np.ndarray
    u: np.ndarray
    width: float = CELL

    def cost(self, delay: np.ndarray) -> np.ndarray:
        """Chi-squared (..., m) of supposed delays, of no cell more than an outlier's."""
        return np.minimum(((self.delay - delay) / self.u) ** 2, OUTLIER)


Cells = Delays | Matched


def stairs_of(cells: Cells) -> np.ndarray | None:
    """Whole samples lost (m,) before each cell; None where that is not what the delays do."""
    if len(cells.at) < 6:
        return None
    path, start = _stairs(cells)
    if path[0] != 0 or path[-1] == 0 or path[-1] >= MOST:
        return None
    stairs = cells.cost(start + path).sum() + STEP * np.count_nonzero(np.diff(path))
    constant = cells.cost(np.median(cells.delay)).sum()
    if min(constant, _running_cost(cells)) - stairs < GAIN:
        return None
    close = float(np.median(np.abs(cells.delay - start - path))) < CLOSE
    if not close and 2 * cells.cost(start + path).sum() > constant:
        return None
    if not _whole(cells, path):
        return None
    return path


def _stairs(cells: Cells) -> tuple[np.ndarray, float]:
    """The cheapest stairs (m,) and the delay of their foot, from several feet to begin with."""
    found = []
    for start in np.unique(np.round(cells.delay[: max(3, len(cells.at) // 4)], 1)):
        path = _cheapest(cells, float(start))
        for _ in range(3):
            start = float(np.median(cells.delay - path))
            path = _cheapest(cells, start)
        cost = cells.cost(start + path).sum() + STEP * np.count_nonzero(np.diff(path))
        found.append((float(cost), start, path))
    _, start, path = min(found, key=lambda each: each[0])
    return path, start


def _cheapest(cells: Cells, start: float) -> np.ndarray:
    """The rising stairs of least cost, by dynamic programming over the samples lost."""
    states = np.arange(MOST + 1)
    cost = cells.cost(start + states[:, None])  # (states, cells)
    total = np.where(states == 0, cost[:, 0], np.inf)
    came_from = np.zeros(cost.shape, int)
    for k in range(1, cost.shape[1]):
        best = np.minimum.accumulate(total)
        first = np.maximum.accumulate(np.where(total == best, states, 0))
        jump = np.concatenate([[np.inf], best[:-1]]) + STEP
        stay = total <= jump
        came_from[:, k] = np.where(stay, states, np.concatenate([[0], first[:-1]]))
        total = np.where(stay, total, jump) + cost[:, k]
    path = [int(total.argmin())]
    for k in range(cost.shape[1] - 1, 0, -1):
        path.append(int(came_from[path[-1], k]))
    return np.array(path[::-1], float)


def _running_cost(cells: Cells) -> float:
    """Chi-squared of a delay that grows evenly, as of a clock that runs fast."""
    weight = 1 / cells.u
    line = np.polyfit(cells.at, cells.delay, 1, w=weight)
    for _ in range(5):
        off = np.abs(cells.delay - np.polyval(line, cells.at)) * weight
        line = np.polyfit(cells.at, cells.delay, 1, w=weight / np.sqrt(np.maximum(off / 2, 1)))
    return float(cells.cost(np.polyval(line, cells.at)).sum())


def _whole(cells: Cells, path: np.ndarray) -> bool:
    """Whether every stair stands a whole number of samples above the first."""
    level = [float(np.median(cells.delay[path == step])) - step for step in np.unique(path)]
    return bool(np.ptp(level) < WHOLE)
