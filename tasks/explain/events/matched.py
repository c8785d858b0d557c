"""Delays of cells by trying them all, where a motion oscillates too fast for a slope to tell them.

A delay of more than a quarter of a period is no longer told by the slope of what is predicted;
and what then is left over drowns the noise by which slopes would be weighed.
"""

from dataclasses import dataclass

import numpy as np

from tasks.motion.whole import Motion

CELL = 4.0  # s: shorter ones tell an oscillation one turn off
STEP = 0.1  # of a sample interval: delays that are tried
BEFORE, BEYOND = 8, 40  # sample intervals: the earliest and the latest delay that is tried
OUTLIER = 100.0  # chi-squared that one cell may cost at most
SECOND = 1.0  # s
MOVING, MOSTLY = 0.05, 0.5  # rad/s within a second, and the share of seconds
SHARP = 100.0  # chi-squared between a cell's best delay and the worst: else it tells none
U = 0.05  # of a sample interval


@dataclass(frozen=True)
class Matched:
    """Delays of cells in sample intervals: at (m,) s, best delay and u (m,), table (m, tried).

    width: of a cell, s.
    """

    at: np.ndarray
    delay: np.ndarray
    u: np.ndarray
    table: np.ndarray
    width: float = CELL

    def cost(self, delay: np.ndarray) -> np.ndarray:
        """Chi-squared (..., m) of supposed delays, of no cell more than an outlier's."""
        place = np.round((np.asarray(delay) + BEFORE) / STEP).astype(int)
        place = np.clip(place, 0, self.table.shape[1] - 1)
        return np.asarray(self.table[np.arange(len(self.at)), place])


def keeps_swinging(motion: Motion) -> bool:
    """Whether the rate changes most of the time, without dwells."""
    count = int(SECOND / max(motion.interval, 1e-9))
    whole = len(motion.t) // max(count, 1) * count
    if not whole:
        return False
    rate = np.nan_to_num(motion.rate[:whole]).reshape(-1, count, 3)
    return bool((np.linalg.norm(rate.std(axis=1), axis=1) > MOVING).mean() > MOSTLY)


def matched(t: np.ndarray, gyros: np.ndarray, predicted: np.ndarray) -> Matched:
    """The misfit of each cell at each delay; gyros, predicted: (n, 3), NaN where not usable.

    Within a cell a gyro has a scale factor and a bias
    of its own. The noise of each gyro is what the best delays leave in the middle of all cells.
    """
    interval = float(np.median(np.diff(t)))
    lags = np.arange(-BEFORE, BEYOND + STEP / 2, STEP)
    cell = ((t - t[0]) / CELL).astype(int)
    count = int(cell[-1]) + 1
    total = np.zeros((count, len(lags)))
    for course, told in zip(gyros.T, predicted.T, strict=True):
        known = np.isfinite(course) & np.isfinite(told)
        if not known.any() or not np.ptp(told[known]):
            continue
        rows, number = np.bincount(cell[known], minlength=count), cell[known]
        left = np.column_stack([
            _left(course[known], np.interp(t[known] + lag * interval, t, told), number, rows)
            for lag in lags
        ])  # fmt: skip
        free = np.maximum(rows - 2, 1)
        full = rows > 0.5 * rows.max()
        variance = float(np.median(left.min(axis=1)[full] / free[full]))
        total += np.where(full[:, None], left, 0.0) / max(variance, 1e-300)
    table = total - total.min(axis=1, keepdims=True)
    sharp = table.max(axis=1) > SHARP
    middle = t[0] + (np.arange(count) + 0.5) * CELL
    best = lags[table.argmin(axis=1)]
    table = np.minimum(table, OUTLIER)
    return Matched(middle[sharp], best[sharp], np.full(int(sharp.sum()), U), table[sharp])


def _left(y: np.ndarray, x: np.ndarray, number: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Sum of squares (cells,) that a straight line in x leaves of y in each cell."""
    held = np.maximum(rows, 1)
    sx, sy = (np.bincount(number, each, len(rows)) for each in (x, y))
    sxx, sxy, syy = (
        np.bincount(number, each, len(rows)) - one * other / held
        for each, one, other in ((x * x, sx, sx), (x * y, sx, sy), (y * y, sy, sy))
    )
    gained = np.divide(sxy**2, sxx, out=np.zeros(len(rows)), where=sxx > 0)
    return np.asarray(np.maximum(syy - gained, 0.0))
