"""Statistics of a line: capability, control charts, yield, station against station."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy import stats

from schemas.base import Finite, Frozen

if TYPE_CHECKING:
    import pandas as pd

# Capability and performance of values within their limits, with confidence intervals.
#
# Cp and Cpk take the deviation from neighbour to neighbour in time (moving ranges), Pp and Ppk that
# of all values together (NIST/SEMATECH e-Handbook of Statistical Methods, 6.1.6; ISO 22514-2).


D2 = 2.0 / np.sqrt(np.pi)  # mean range of two values of a normal distribution, in sigma
LEVEL = 0.95
# Values for an index: of 10 the 95 % interval of Cp reaches from 0.44 to 1.57 of it, and an index
# of fewer says nothing that could be acted on.
FEWEST_IN_INDEX = 10


class CapabilityIndex(Frozen):
    """An index of capability with its 95 % interval; null where limits or values give none."""

    value: Finite | None
    low: Finite | None = None
    high: Finite | None = None


@dataclass(frozen=True)
class Capability:
    """Of n values. mean, within, overall: in their unit; within: sigma of the moving ranges.

    cp, pp: None where the limits are one-sided.
    """

    n: int
    mean: float | None
    within: float | None
    overall: float | None
    cp: CapabilityIndex
    cpk: CapabilityIndex
    pp: CapabilityIndex
    ppk: CapabilityIndex


NONE = CapabilityIndex(value=None)


def capability(values: np.ndarray, lower: float | None, upper: float | None) -> Capability:
    """The indices of values (n,) in the order of time against limits; one alone is one-sided."""
    n = len(values)
    if n < 2:
        mean = float(values[0]) if n else None
        return Capability(n, mean, None, None, NONE, NONE, NONE, NONE)
    mean, within = float(values.mean()), sigma_within(values)
    overall = float(values.std(ddof=1))
    if n < FEWEST_IN_INDEX:
        return Capability(n, mean, within, overall, NONE, NONE, NONE, NONE)
    short, whole = dof_within(n), n - 1.0
    return Capability(
        n, mean, within, overall,
        cp=_two_sided(within, short, lower, upper),
        cpk=_nearer(mean, within, n, short, lower, upper),
        pp=_two_sided(overall, whole, lower, upper),
        ppk=_nearer(mean, overall, n, whole, lower, upper),
    )  # fmt: skip


def sigma_within(values: np.ndarray) -> float:
    """The standard deviation by the mean moving range of two, MR/1.128."""
    return float(np.abs(np.diff(values)).mean() / D2)


def dof_within(n: int) -> float:
    """Degrees of freedom of `sigma_within`, of which neighbouring ranges share a value.

    Its variance is (0.8264 n - 1.082) sigma²/(n - 1)² (P. G. Hoel, Ann. Math. Statist. 17 (1946)
    475; J. D. Cryer and T. P. Ryan, J. Quality Technology 22 (1990) 187), that of a deviation with
    v degrees sigma²/(2 v).
    """
    return max(1.0, (n - 1.0) ** 2 / (2.0 * (0.8264 * n - 1.082)))


def _two_sided(
    sigma: float, dof: float, lower: float | None, upper: float | None
) -> CapabilityIndex:
    """(U - L)/(6 sigma), with the interval that sigma has by chi-squared."""
    if lower is None or upper is None or sigma <= 0.0:
        return NONE
    value = (upper - lower) / (6.0 * sigma)
    low, high = (
        float(np.sqrt(stats.chi2.ppf(p, dof) / dof)) for p in ((1 - LEVEL) / 2, (1 + LEVEL) / 2)
    )
    return CapabilityIndex(value=value, low=value * low, high=value * high)


def _nearer(
    mean: float, sigma: float, n: int, dof: float, lower: float | None, upper: float | None
) -> CapabilityIndex:
    """The distance to the nearer limit in 3 sigma; its interval by A. F. Bissell's approximation
    (Applied Statistics 39 (1990) 331).
    """
    margins = [upper - mean] if upper is not None else []
    margins += [mean - lower] if lower is not None else []
    if not margins or sigma <= 0.0:
        return NONE
    value = min(margins) / (3.0 * sigma)
    half = float(
        stats.norm.ppf((1 + LEVEL) / 2) * np.sqrt(1.0 / (9.0 * n) + value**2 / (2.0 * dof))
    )
    return CapabilityIndex(value=value, low=value - half, high=value + half)


def margins(values: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """(n,) distance of each value to its nearer limit, negative outside; NaN without one.

    lower, upper: (n,), NaN where there is none.
    """
    with np.errstate(invalid="ignore"):
        return np.fmin(values - lower, upper - values)


def consumed(values: np.ndarray, U: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """(n,) share of the margin that U takes: 1 where the limit is U away; infinite on the limit
    and outside. NaN without a limit, a value or U.
    """
    margin = margins(values, lower, upper)
    share = np.divide(U, margin, out=np.full(len(margin), np.inf), where=margin > 0.0)
    return np.where(np.isnan(margin) | np.isnan(U), np.nan, share)


# Control charts of individual values and moving ranges, with the Nelson rules.
#
# D. C. Montgomery, Introduction to Statistical Quality Control, 6.4; NIST/SEMATECH e-Handbook of
# Statistical Methods, 6.3.2.2; L. S. Nelson, The Shewhart control chart: tests for special causes,
# J. Quality Technology 16 (1984) 237.

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


# First-pass yield: the share of first runs that passed, with a confidence interval.


RETEST_DAYS = 7  # within which a run of a unit is another try of the run before it
# First runs in a point of the yield over time. The interval of a share of 20 is ±20 % at its
# widest, that of 5 is ±33 %, and a single run is a point at 0 or 100 % that says nothing.
FEWEST_IN_POINT = 20


def wilson(
    passed: np.ndarray, of: np.ndarray, level: float = LEVEL
) -> tuple[np.ndarray, np.ndarray]:
    """The score interval of a proportion (E. B. Wilson, JASA 22 (1927) 209); NaN of none.

    passed, of: (n,) how many of how many, whole numbers or not. Gives its lower and its upper
    bound, (n,) each. scipy's `binomtest` has the same for one pair of whole numbers, and takes a
    millisecond for it.
    """
    passed, of = np.asarray(passed, float), np.asarray(of, float)
    z2 = float(stats.norm.ppf(0.5 + level / 2.0)) ** 2
    centre = passed + z2 / 2.0
    with np.errstate(invalid="ignore"):
        half = np.sqrt(z2 * (passed * (of - passed) / of + z2 / 4.0))
        low, high = (centre - half) / (of + z2), (centre + half) / (of + z2)
    return np.where(of > 0, np.maximum(low, 0.0), np.nan), np.where(of > 0, high, np.nan)


def yields(runs: "pd.DataFrame", by: str) -> "pd.DataFrame":
    """The yield of each group of first runs.

    runs: a row for each first run that was decided on, with the column `passed` (bool) and that of
    `by`. Gives a row for each group in its order: passed, of, share, low, high.
    """
    table = runs.groupby(by, sort=True)["passed"].agg(["sum", "size"])
    return shares(table["sum"].tolist(), table["size"].tolist(), table.index)


def shares(
    passed: Sequence[int], of: Sequence[int], names: "Sequence[str] | pd.Index[str]"
) -> "pd.DataFrame":
    """The same of groups that were counted already: so many of so many passed."""
    import pandas as pd

    counted = np.array(passed, int), np.array(of, int)
    low, high = wilson(*counted)
    columns = {"passed": counted[0], "of": counted[1]}
    share = columns["passed"] / columns["of"]
    return pd.DataFrame(columns | {"share": share, "low": low, "high": high}, index=pd.Index(names))


def pooled(of: Sequence[int]) -> list[slice]:
    """Adjacent periods, with so many first runs each, put together to FEWEST_IN_POINT at least.

    What is left at the end joins the point before it, so that only a single point may have fewer.
    """
    slices: list[slice] = []
    first, count = 0, 0
    for number, runs in enumerate(of, start=1):
        count += runs
        if count >= FEWEST_IN_POINT:
            slices.append(slice(first, number))
            first, count = number, 0
    if first < len(of):
        begin = slices.pop().start if slices else first
        slices.append(slice(begin, len(of)))
    return slices


def first_runs(runs: "pd.DataFrame") -> "pd.Series[bool]":
    """Whether each run is a first pass, and no retest.

    A run is a retest where the same unit was run in the RETEST_DAYS days before it, on whatever
    station and however that ended; a row of retests belongs to the visit that it began with.
    runs: columns `unit`, `day` (datetime64) and `order`, which orders the runs of a day; the
    answer has the frame's own index. All runs of the units are asked for, not a selection: what a
    selection leaves out makes a retest all the same.
    """
    ordered = runs.sort_values(["unit", "day", "order"], kind="stable")
    pause = ordered.groupby("unit")["day"].diff().dt.days
    return (pause.isna() | (pause > RETEST_DAYS)).reindex(runs.index)


# Station against station, by units that were run on several of them.

FEWEST_UNITS = 2  # for a deviation between them
CONSISTENT = 0.05  # p, from which stations may differ by chance


@dataclass(frozen=True)
class Compared:
    """The reading of each of s stations relative to the mean of those that are consistent.

    difference, U: (s,) in the values' unit, k = 2; NaN for a station that no unit links to the
    others, U if fewer than two units link it. pairs: (s,) number of pairs of runs used.
    """

    difference: np.ndarray
    U: np.ndarray
    pairs: np.ndarray


def against_each_other(
    unit: np.ndarray, station: np.ndarray, values: np.ndarray, adjusted: np.ndarray, stations: int
) -> Compared:
    """The stations' differences by least squares of the steps between a unit's successive runs.

    All (n,), in order of time. unit, station: numbers. adjusted: bool, whether a run's unit was
    adjusted since its previous run: that step is not used. Steps remove the unit's own value and
    nearly all of its drift; U is from the scatter of the steps between units (covariance clustered
    by units: A. C. Cameron, D. L. Miller, J. Human Resources 50 (2015) 317), so that it includes
    drift and runs shared by two steps. Their reference is the mean of the largest consistent subset
    (M. G. Cox, Metrologia 44 (2007) 187): one deviating station does not shift the others.
    """
    order = np.argsort(unit, kind="stable")
    before, after = order[:-1], order[1:]
    is_step = (unit[before] == unit[after]) & ~adjusted[after]
    is_step &= np.isfinite(values[before]) & np.isfinite(values[after])
    before, after = before[is_step], after[is_step]
    design = np.zeros((len(after), stations))
    rows = np.arange(len(after))
    np.add.at(design, (rows, station[after]), 1.0)
    np.add.at(design, (rows, station[before]), -1.0)
    tied = np.abs(design).sum(axis=0)
    inverse = np.linalg.pinv(design.T @ design, rcond=1e-9, hermitian=True)
    step = values[after] - values[before]
    found = inverse @ (design.T @ step)
    clusters = np.zeros((int(unit.max(initial=-1)) + 1, stations))
    np.add.at(clusters, unit[after], design * (step - design @ found)[:, None])
    count = len(np.unique(unit[after]))
    scale = count / (count - 1.0) if count >= FEWEST_UNITS else np.nan
    covariance = scale * inverse @ (clusters.T @ clusters) @ inverse
    known = tied > 0
    beside = np.eye(stations) - _reference(found, covariance, known)
    found, covariance = beside @ found, beside @ covariance @ beside.T
    expanded = K * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return Compared(
        np.where(known, found, np.nan), np.where(known, expanded, np.nan), tied.astype(int)
    )


def _reference(found: np.ndarray, covariance: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Weights (s,) of the mean of the stations that agree; half of them at the least.

    While they disagree by more than chance, the one farthest from the others' mean is left out.
    """
    stays = known.copy()
    while True:
        weights = stays / max(1, stays.sum())
        if not np.isfinite(covariance).all() or 2 * (stays.sum() - 1) < known.sum():
            return weights
        beside = (np.eye(len(found)) - weights)[stays]
        off, spread = beside @ found, beside @ covariance @ beside.T
        statistic = off @ np.linalg.pinv(spread, rcond=1e-9, hermitian=True) @ off
        if stats.chi2.sf(statistic, stays.sum() - 1) >= CONSISTENT:
            return weights
        stays[np.flatnonzero(stays)[np.argmax(off**2 / np.diag(spread))]] = False
