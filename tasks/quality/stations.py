"""Station against station, by units that were run on several of them."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

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
