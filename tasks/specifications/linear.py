"""Least squares as the clauses write it, kept as a linear operator to propagate uncertainty."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

RANK_TOLERANCE = 1e-9
TINY = 1e-9  # of a variance: keeps a covariance invertible
EXCESS_LEVEL = 0.01  # scatter that noise alone would give in one case of a hundred
BLOCKING_EXCESS = 10.0  # beyond it no larger uncertainty makes up for what is wrong


@dataclass(frozen=True)
class Solution:
    """Parameters of U = H·θ.

    operator: (p, n), θ = operator·U.
    estimable: (p,) bool, which parameters the points determine (θ_j is a combination of the
        readings only where the unit vector lies in the row space of H).
    """

    operator: np.ndarray
    estimable: np.ndarray

    def of(self, readings: np.ndarray) -> np.ndarray:
        """θ of (n,) readings; NaN where not estimable."""
        return np.where(self.estimable, self.operator @ readings, np.nan)

    def uncertainty(self, covariance: np.ndarray) -> np.ndarray:
        """Standard uncertainty (p,) of θ, from the covariance (n, n) of the readings."""
        variance = (self.operator @ covariance * self.operator).sum(axis=1)
        return np.where(self.estimable, np.sqrt(np.maximum(variance, 0.0)), np.nan)


def solve(design: np.ndarray) -> Solution:
    """(HᵀH)⁻¹Hᵀ of a (n, p) design, by the pseudo-inverse where the points are too few."""
    return _solved(design.astype(float).tobytes(), design.shape)


@lru_cache(maxsize=8)  # the same points come for every channel
def _solved(numbers: bytes, shape: tuple[int, int]) -> Solution:
    design = np.frombuffer(numbers).reshape(shape)
    scale = np.linalg.norm(design, axis=0)
    scale[scale == 0] = 1.0
    operator = np.linalg.pinv(design / scale, rcond=RANK_TOLERANCE) / scale[:, None]
    resolution = np.diag(operator @ design)
    return Solution(operator=operator, estimable=np.abs(resolution - 1.0) < 1e-6)


def last_shown(
    design: np.ndarray, readings: np.ndarray, covariance: np.ndarray, count: int
) -> tuple[np.ndarray, float]:
    """θ (p,) by generalised least squares, and how often noise alone makes the last ones so large.

    1 where points or noise do not tell.
    """
    from scipy.special import chdtrc  # late: a tenth of a start

    untold = np.full(design.shape[1], np.nan), 1.0
    if len(readings) <= design.shape[1] or not np.isfinite(readings).all():
        return untold
    sizes, ways = np.linalg.eigh(covariance)
    if not sizes[-1] > 0.0:
        return untold
    white = (ways / np.sqrt(np.maximum(sizes, TINY * sizes[-1]))).T
    solution = solve(white @ design)
    found, last = solution.of(white @ readings), solution.operator[-count:]
    if not solution.estimable[-count:].all():
        return untold
    chi2 = found[-count:] @ np.linalg.solve(last @ last.T, found[-count:])
    return found, float(chdtrc(count, chi2))


@dataclass(frozen=True)
class Residuals:
    """Residuals (n,) of a fit, their covariance (n, n) by that of the readings, and χ²."""

    values: np.ndarray
    covariance: np.ndarray
    chi2: float


def residuals_of(
    solution: Solution, design: np.ndarray, readings: np.ndarray, covariance: np.ndarray
) -> Residuals:
    """What the fit leaves of the readings."""
    maker = np.eye(len(readings)) - design @ solution.operator
    values, spread = maker @ readings, maker @ covariance @ maker.T
    variances, directions = np.linalg.eigh(spread)
    known = np.abs(variances) > 1e-6 * np.abs(variances).max(initial=0.0)
    along = values @ directions[:, known]
    return Residuals(values, spread, float((along**2 / variances[known]).sum()))


@dataclass(frozen=True)
class BirgeRatio:
    """By how much residuals exceed what the noise explains, 1 if they do not, and their dof."""

    factor: float = 1.0
    dof: float = math.inf


def birge_ratio(
    solution: Solution, design: np.ndarray, readings: np.ndarray, covariance: np.ndarray
) -> BirgeRatio:
    """√(χ²/dof) of the residuals where noise alone would reach it in fewer than 1 case of 100.

    The residuals' own covariance follows from the readings' covariance. The degrees of freedom
    are n − p.
    """
    from scipy.special import chdtrc  # late: a tenth of a start

    if not len(readings) or not np.isfinite(readings).all():
        return BirgeRatio()
    degrees = len(readings) - np.linalg.matrix_rank(design)
    if degrees < 1:
        return BirgeRatio()
    chi2 = residuals_of(solution, design, readings, covariance).chi2
    if chdtrc(degrees, chi2) < EXCESS_LEVEL:
        return BirgeRatio(float(np.sqrt(chi2 / degrees)), float(degrees))
    return BirgeRatio()
