"""Least squares as the clauses write it, kept as a linear operator so that u can follow."""

from dataclasses import dataclass

import numpy as np

RANK_TOLERANCE = 1e-9


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
        variance = np.einsum("pi,ij,pj->p", self.operator, covariance, self.operator)
        return np.where(self.estimable, np.sqrt(np.maximum(variance, 0.0)), np.nan)


def solve(design: np.ndarray) -> Solution:
    """(HᵀH)⁻¹Hᵀ of a (n, p) design, by the pseudo-inverse where the points are too few."""
    scale = np.linalg.norm(design, axis=0)
    scale[scale == 0] = 1.0
    operator = np.linalg.pinv(design / scale, rcond=RANK_TOLERANCE) / scale[:, None]
    resolution = np.diag(operator @ design)
    return Solution(operator=operator, estimable=np.abs(resolution - 1.0) < 1e-6)
