"""Delays of the time stamps in short windows.

A delay is estimated from the slope of the signal, or by a grid search where the signal oscillates.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d

from tasks.motion.samples import in_blocks, interpolated, sample_interval
from tasks.motion.whole import Motion

SLOPE_WINDOW = 1.0  # s, within which the delay is read off the slope
SLOPE_OUTLIER = 50.0  # chi-squared that one window may cost at most
MAX_U = 0.15  # of a sample interval: windows that know the delay worse are left out
MODEL_U = 0.08  # of a sample interval: what else may look like a delay in a window
MIN_INDEPENDENT = 0.1  # of a window's information that must remain beside a bias
APART = 4  # rows: slopes that encoder noise makes are unrelated at this distance
MIN_COHERENT = 0.5  # of the slopes' power that must be the same that far apart

GRID_WINDOW = 4.0  # s: in a shorter one, one oscillation passes for the next
GRID_ROWS = 200  # of a window that are compared
GRID_STEP = 0.2  # of a sample interval: delays that are tried
EARLIEST, LATEST = -32, 40  # sample intervals that are tried
GRID_OUTLIER = 100.0  # chi-squared that one window may cost at most
GRID_U = 0.05  # of a sample interval
MIN_CONTRAST = 100.0  # chi-squared between a window's best delay and the worst

OSCILLATION_WINDOW = 1.0  # s
MIN_OSCILLATION, MIN_SHARE = 0.05, 0.5  # rad/s within a window, and the share of such windows


@dataclass(frozen=True)
class WindowDelays:
    """Delays of m windows in sample intervals: at (m,) s, delay, u (m,); width: of a window, s."""

    at: np.ndarray
    delay: np.ndarray
    u: np.ndarray
    width: float

    def cost(self, delay: np.ndarray) -> np.ndarray:
        """Chi-squared (..., m) of supposed delays, of no window more than an outlier's."""
        return np.minimum(((self.delay - delay) / self.u) ** 2, SLOPE_OUTLIER)


@dataclass(frozen=True)
class GridDelays(WindowDelays):
    """The same with the chi-squared of every delay tried: table (m, tried)."""

    table: np.ndarray

    def cost(self, delay: np.ndarray) -> np.ndarray:
        place = np.round((np.asarray(delay) - EARLIEST) / GRID_STEP).astype(int)
        place = np.clip(place, 0, self.table.shape[1] - 1)
        return np.asarray(self.table[np.arange(len(self.at)), place])


def oscillates(motion: Motion) -> bool:
    """Whether the rate changes most of the time, without dwells."""
    count = int(OSCILLATION_WINDOW / max(motion.interval, 1e-9))
    if not 0 < count <= len(motion.t):
        return False
    rate = np.nan_to_num(in_blocks(motion.rate, count))
    moving = np.linalg.norm(rate.std(axis=1), axis=1) > MIN_OSCILLATION
    return bool(moving.mean() > MIN_SHARE)


def delays_by_slope(
    t: np.ndarray, residual: np.ndarray, predicted: np.ndarray, slope: np.ndarray, noise: np.ndarray
) -> WindowDelays:
    """The delay of each window, linearised in the slope (n, 6) of the signal per sample interval.

    From the gyros where they are recorded, for levers disturb accelerometers. Beside the delay a
    window may have a scale factor and a bias of its own: those of the whole run are fitted to
    readings that the losses have put off. Rows about a corner of the motion count less, which a
    delay moves past them.
    """
    channels = range(3) if np.isfinite(residual[:, :3]).any() else range(3, 6)
    window, count = _windows(t, SLOPE_WINDOW)
    weighted, information = np.zeros(count), np.zeros(count)
    for c in channels:
        rows = np.flatnonzero(np.isfinite(residual[:, c] + slope[:, c] + noise[:, c]))
        if not len(rows):
            continue
        corners = maximum_filter1d(np.abs(np.gradient(slope[rows, c])), 2 * APART + 1)
        number, weight = window[rows], 1.0 / (noise[rows, c] ** 2 + corners**2)
        regressors = (slope[rows, c], residual[rows, c], predicted[rows, c], np.ones(len(rows)))
        gram = np.array([
            [np.bincount(number, weight * x * y, count) for x in regressors] for y in regressors
        ])  # fmt: skip
        scaled = _projected(gram, 2)
        both = _projected(scaled, 3)
        # Where a ramp is straight a delay looks like a bias.
        gram = np.where(both[0, 0] > MIN_INDEPENDENT * scaled[0, 0], both, scaled)
        gram = np.where(_coherent(slope[rows, c], number, count), gram, 0.0)
        weighted += gram[0, 1]
        information += np.maximum(gram[0, 0], 0.0)
    sharp = information > MAX_U**-2
    middle = t[0] + (np.flatnonzero(sharp) + 0.5) * SLOPE_WINDOW
    u = np.sqrt(1 / information[sharp] + MODEL_U**2)
    return WindowDelays(middle, weighted[sharp] / information[sharp], u, SLOPE_WINDOW)


def _coherent(slope: np.ndarray, window: np.ndarray, count: int) -> np.ndarray:
    """(count,) windows in which a slope (n,) is a motion's, not mostly the reference's noise: that
    has no relation to the readings, and would pull their delay towards nothing.
    """
    same = np.bincount(window[APART:], slope[APART:] * slope[:-APART], count)
    return np.asarray(same > MIN_COHERENT * np.bincount(window, slope**2, count))


def _projected(gram: np.ndarray, q: int) -> np.ndarray:
    """Products of regressors (k, k, windows) after projecting one of them out of the others."""
    shares = np.divide(gram[:, q], gram[q, q], out=np.zeros_like(gram[q]), where=gram[q, q] > 0)
    return np.asarray(gram - shares[:, None] * gram[q][None])


def delays_by_grid(t: np.ndarray, gyros: np.ndarray, rates: np.ndarray) -> GridDelays:
    """The misfit of each window at each delay; gyros, rates of the motion: (n, 3), NaN: unknown.

    For a motion that oscillates: a delay of more than a quarter of a period cannot be read off
    the slope. Within a window each gyro follows the three rates in a way of its own, and has a
    bias: a matrix fitted to readings that the losses have put off would look like delays. The
    noise is what the best delays leave in the median window.
    """
    interval = sample_interval(t)
    lags = np.arange(EARLIEST, LATEST + GRID_STEP / 2, GRID_STEP)
    window, count = _windows(t, GRID_WINDOW)
    some = np.isfinite(gyros).any(axis=0)
    known = np.isfinite(gyros[:, some]).all(axis=1)
    unknown = np.concatenate([[0], np.cumsum(np.isnan(rates).any(axis=1))])
    total, rows = np.zeros((count, len(lags))), np.zeros(count)
    for number in range(count):
        first, last = np.searchsorted(window, (number, number + 1))
        own = first + np.flatnonzero(known[first:last])
        reach = (first + EARLIEST, last + LATEST)
        if len(own) < 0.5 * GRID_WINDOW / interval or np.ptp(unknown[np.clip(reach, 0, len(t))]):
            continue
        own = own[:: 1 + len(own) // GRID_ROWS]
        read = gyros[own][:, some]
        rows[number] = read.size
        delayed = interpolated((t[own] + lags[:, None] * interval).ravel(), t, rates)
        total[number] = _matrix_misfits(read, delayed.reshape(len(lags), len(own), 3))
    if not rows.any():
        nothing = np.zeros(0)
        return GridDelays(nothing, nothing, nothing, GRID_WINDOW, total[:0])
    full = rows > 0
    variance = float(np.median(total[full].min(axis=1) / rows[full]))
    table = (total - total.min(axis=1, keepdims=True)) / max(variance, 1e-300)
    sharp = table.max(axis=1) > MIN_CONTRAST
    middle = t[0] + (np.flatnonzero(sharp) + 0.5) * GRID_WINDOW
    best = lags[table.argmin(axis=1)][sharp]
    costs = np.minimum(table, GRID_OUTLIER)[sharp]
    return GridDelays(middle, best, np.full(len(best), GRID_U), GRID_WINDOW, costs)


def _matrix_misfits(read: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Sums of squares (lags,) that a matrix and a bias leave of readings (n, k), given rates
    (lags, n, 3).
    """
    basis, _ = np.linalg.qr(rates - rates.mean(axis=1, keepdims=True))
    off = read - read.mean(axis=0)
    explained = ((np.swapaxes(basis, 1, 2) @ off) ** 2).sum(axis=(1, 2))
    return np.asarray((off**2).sum() - explained)


def _windows(t: np.ndarray, width: float) -> tuple[np.ndarray, int]:
    """The window (n,) of each row, and how many there are."""
    window = ((t - t[0]) / width).astype(int)
    return window, int(window[-1]) + 1
