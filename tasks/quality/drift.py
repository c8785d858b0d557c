"""Drift of one unit's coefficient over its calibrations."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

K = 2.0
SAME_DAY = 1e-4  # years
COVERED = 0.9545  # what k = 2 covers of a normal distribution


@dataclass(frozen=True)
class Drift:
    """A rate of change in the values' unit per year with its U, of so many readings."""

    per_year: float
    U: float
    readings: int


def drift(
    years: np.ndarray, values: np.ndarray, u: np.ndarray, adjustments: np.ndarray
) -> Drift | None:
    """The slope by weighted least squares; None where no adjustment leaves two days to compare.

    All (n,). years: when. u: standard uncertainties of the values; one without (NaN or 0) is left
    out. adjustments: how many the unit had gone through by then; each moves the level and leaves
    the slope. U is the larger of what the stated u give with k = 2 and of what the scatter about
    the line gives with Student's t of 95.45 %. What all calibrations have in common, such as the
    error of a standard, takes no part in a slope, so that the former errs on the large side.
    """
    known = np.isfinite(values) & np.isfinite(u) & (u > 0)
    years, values, u = years[known], values[known], u[known]
    levels, level = np.unique(adjustments[known], return_inverse=True)
    weights = 1.0 / u**2
    of_level = np.bincount(level, weights, minlength=len(levels))
    t, y = (x - _mean(x, weights, level, of_level) for x in (years, values))
    spread = float(np.sum(weights * t**2))
    if np.max(np.abs(t), initial=0.0) < SAME_DAY:
        return None
    slope = float(np.sum(weights * t * y)) / spread
    stated, freedom = K / np.sqrt(spread), len(t) - len(levels) - 1
    if freedom < 1:
        return Drift(slope, float(stated), len(t))
    chi2 = float(np.sum(weights * (y - slope * t) ** 2)) / freedom
    scattered = stats.t.ppf(0.5 + COVERED / 2, freedom) * np.sqrt(chi2 / spread)
    return Drift(slope, float(max(stated, scattered)), len(t))


def _mean(x: np.ndarray, weights: np.ndarray, level: np.ndarray, total: np.ndarray) -> np.ndarray:
    """The weighted mean of each reading's level."""
    return (np.bincount(level, weights * x, minlength=len(total)) / total)[level]
