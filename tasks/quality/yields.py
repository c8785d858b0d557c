"""First-pass yield: the share of first runs that passed, with a confidence interval."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import chi2, norm

if TYPE_CHECKING:
    import pandas as pd


RETEST_DAYS = 7  # within which a run of a unit is another try of the run before it
LEVEL = 0.95
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
    z2 = float(norm.ppf(0.5 + level / 2.0)) ** 2
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

FEWEST = 2  # units, for a deviation between them
K = 2.0
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
    scale = count / (count - 1.0) if count >= FEWEST else np.nan
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
        if chi2.sf(statistic, stays.sum() - 1) >= CONSISTENT:
            return weights
        stays[np.flatnonzero(stays)[np.argmax(off**2 / np.diag(spread))]] = False
