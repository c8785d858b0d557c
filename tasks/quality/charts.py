"""Control charts of individual values and moving ranges, with the Nelson rules.

D. C. Montgomery, Introduction to Statistical Quality Control, 6.4; NIST/SEMATECH e-Handbook of
Statistical Methods, 6.3.2.2; L. S. Nelson, The Shewhart control chart: tests for special causes,
J. Quality Technology 16 (1984) 237.
"""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from schemas.base import Finite, Frozen
from tasks.quality.capability import sigma_within

K = 2.0
SAME_DAY = 1e-4  # years
COVERED = 0.9545  # what k = 2 covers of a normal distribution
D4 = 3.267  # upper limit of ranges of two, in their mean
RULES = 8


class DriftRate(Frozen):
    """Change in a year with U, in the element's unit, by so many readings of valid runs."""

    per_year: Finite
    U: Finite
    readings: int


@dataclass(frozen=True)
class Chart:
    """A chart of (n,) values in the order of time.

    centre, sigma: of the values. ranges: (n,) from the value before; NaN for the first.
    mean_range, range_limit: centre and upper limit of the ranges. broken: (8, n) bool, at which
    value each rule of Nelson was broken: the last one of those that break it.
    """

    centre: float
    sigma: float
    ranges: np.ndarray
    mean_range: float
    range_limit: float
    broken: np.ndarray

    @property
    def limits(self) -> tuple[float, float]:
        """Three sigma on either side of the centre."""
        return self.centre - 3.0 * self.sigma, self.centre + 3.0 * self.sigma


def individuals(values: np.ndarray, history: int | None = None) -> Chart | None:
    """The chart of values (n,); the mean and moving ranges of the first `history` of them, else of
    all, are the process. None where there are fewer than two of these.
    """
    process = values[:history]
    if len(process) < 2:
        return None
    ranges = np.concatenate([[np.nan], np.abs(np.diff(values))])
    centre, sigma = float(process.mean()), sigma_within(process)
    mean = float(np.nanmean(ranges[: len(process)]))
    standard = (values - centre) / sigma if sigma > 0.0 else np.zeros(len(values))
    return Chart(centre, sigma, ranges, mean, D4 * mean, nelson(standard))


def nelson(z: np.ndarray) -> np.ndarray:
    """(8, n) bool: at which value each rule is broken. z: (n,) distance from the centre in sigma.

    1: beyond 3 sigma. 2: nine in a row on one side. 3: six in a row rising, or falling. 4: fourteen
    in a row up and down in turn. 5: two of three beyond 2 sigma on one side. 6: four of five beyond
    1 sigma on one side. 7: fifteen in a row within 1 sigma. 8: eight in a row beyond 1 sigma.
    """
    step = np.sign(np.diff(z, prepend=np.nan))
    turns = np.concatenate([[False], step[1:] * step[:-1] < 0])
    return np.stack([
        np.abs(z) > 3.0,
        _one_side(z, 0.0, 9, 9),
        _row(step > 0, 5) | _row(step < 0, 5),
        _row(turns, 12),
        _one_side(z, 2.0, 2, 3),
        _one_side(z, 1.0, 4, 5),
        _row(np.abs(z) < 1.0, 15),
        _row(np.abs(z) > 1.0, 8),
    ])  # fmt: skip


def _one_side(z: np.ndarray, beyond: float, of: int, out_of: int) -> np.ndarray:
    """Where `of` of the last `out_of` are beyond on one side, the value itself among them."""
    found = np.zeros(len(z), bool)
    for side in (z, -z):
        is_out = side > beyond
        found |= is_out & (_counted(is_out, out_of) >= of)
    return found


def _row(holds: np.ndarray, length: int) -> np.ndarray:
    """Where it holds for the last `length` in a row."""
    return _counted(holds, length) >= length


def _counted(holds: np.ndarray, length: int) -> np.ndarray:
    """(n,) for how many of the last `length` it holds; fewer are there at the beginning."""
    total = np.concatenate([np.zeros(length, int), np.cumsum(holds)])
    return np.asarray(total[length:] - total[:-length])


def drift(
    years: np.ndarray, values: np.ndarray, u: np.ndarray, adjustments: np.ndarray
) -> DriftRate | None:
    """The slope by weighted least squares; None where no adjustment leaves two days to compare.

    All (n,). years: when. u: standard uncertainties of the values; one without (NaN or 0) is left
    out. adjustments: how many the unit had gone through by then; each moves the level and leaves
    the slope. U is the larger of what the stated u give with k = 2 and of what the scatter about
    the line gives with Student's t of 95.45 %. What all calibrations have in common, such as the
    error of a standard, takes no part in a slope, so that the former is an overestimate.
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
        return DriftRate(per_year=slope, U=float(stated), readings=len(t))
    chi2 = float(np.sum(weights * (y - slope * t) ** 2)) / freedom
    scattered = stats.t.ppf(0.5 + COVERED / 2, freedom) * np.sqrt(chi2 / spread)
    return DriftRate(per_year=slope, U=float(max(stated, scattered)), readings=len(t))


def _mean(x: np.ndarray, weights: np.ndarray, level: np.ndarray, total: np.ndarray) -> np.ndarray:
    """The weighted mean of each reading's level."""
    return (np.bincount(level, weights * x, minlength=len(total)) / total)[level]


# Golden units as the check of a station: what it reads of them today against its own history.

# Values that make a station's limits for a golden unit: sigma by moving ranges of 20 is known to
# 17 %, and more would include the drift of years. Later values are judged, and shift no limit.
HISTORY = 20
# Fewer give no limits: of 8 values sigma is known to 30 % only.
FEWEST = 8


def station_check(values: np.ndarray) -> Chart | None:
    """The chart of the values (n,) of a golden unit on a station, in the order of time.

    None where there are fewer than FEWEST.
    """
    return individuals(values, HISTORY) if len(values) >= FEWEST else None
