"""Readings that were kept in coarse steps: their step, and which way they were rounded."""

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import norm

from schemas.recording import Recording

CELLS = 64
LEVELS = np.arange(-8, 10)


def step_of(readings: np.ndarray) -> float:
    """The step of which all readings are whole multiples."""
    levels = np.unique(readings)
    return float(np.diff(levels).min())


def dead_zone_misfit(recording: Recording, *, towards_zero: bool) -> float:
    """What a + b·sin θ + c·cos θ, noisy and kept in steps, leaves of accelerometer y, m/s².

    Root mean square over cells of the shaft's angle θ. Rounded to the nearest step, or cut off
    towards zero, which makes the step at zero twice as wide.
    """
    angle, y = _over_angle(recording)
    step = step_of(recording.imu.columns["accel_y"])
    A = np.column_stack([np.ones(len(angle)), np.sin(angle), np.cos(angle)])
    first = np.append(np.linalg.lstsq(A, y, rcond=None)[0], 0.3 * step)

    def left(values: np.ndarray) -> np.ndarray:
        return _kept(A @ values[:3], abs(values[3]) + 1e-3, step, towards_zero) - y

    return float(np.std(least_squares(left, first).fun))


def _over_angle(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    assert recording.table is not None
    angle, y = recording.table.columns["shaft_angle"], recording.imu.columns["accel_y"]
    cell = np.digitize(angle, np.linspace(angle.min(), angle.max(), CELLS))
    full = [k for k in np.unique(cell) if (cell == k).sum() > 50]
    return (np.array([angle[cell == k].mean() for k in full]),
            np.array([y[cell == k].mean() for k in full]))  # fmt: skip


def _kept(mean: np.ndarray, noise: float, step: float, towards_zero: bool) -> np.ndarray:
    """The mean of what is kept of noisy readings (n,)."""
    if towards_zero:
        low = np.where(LEVELS > 0, LEVELS, LEVELS - 1.0)
        high = np.where(LEVELS < 0, LEVELS, LEVELS + 1.0)
    else:
        low, high = LEVELS - 0.5, LEVELS + 0.5
    below, above = ((edge[:, None] * step - mean) / noise for edge in (low, high))
    return np.asarray(((norm.cdf(above) - norm.cdf(below)) * LEVELS[:, None] * step).sum(axis=0))
