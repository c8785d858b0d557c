"""Earth's rotation as the rests show it, relative to its rate: north, east and up."""

from dataclasses import dataclass

import numpy as np

from tasks.motion.table import EARTH_RATE
from tasks.motion.whole import unit_vector
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.linear import birge_ratio, solve

LEVEL, GRAVITY, PARAMETERS = slice(0, 2), slice(3, 6), 6  # north, east, zero, three axes up

KNOWN = 10.0  # Earth rates: what is less certain hangs on rounding alone


@dataclass(frozen=True)
class EarthRate:
    """level: (2,) along north and east, with its covariance (2, 2); NaN where not determined.

    vertical: along up, and how far the unit's own sensitivity to gravity may shift it; NaN where
    not determined.
    """

    level: np.ndarray
    covariance: np.ndarray
    vertical: float
    u_vertical: float

    def chi2(self, expected: np.ndarray) -> float:
        """How far the level part (2,) is from one that is expected."""
        away = self.level - expected
        return float(away @ np.linalg.solve(self.covariance, away))


def earth_rate(evidence: ClauseEvidence) -> EarthRate | None:
    """By least squares over the rests: zero, sensitivity to gravity, and the level part of each.

    None where fewer rests than that have a gyro and a known attitude. A scale factor of 1 is taken.
    """
    rests = [
        i
        for i in evidence.of_kind("static")
        if evidence.segments[i].has_gyro and evidence.up[i] is not None
    ]
    north = evidence.north[rests]
    if len(rests) <= PARAMETERS or not np.isfinite(north).all():
        return None
    up = np.array([unit_vector(evidence.up[i]) for i in rests])
    east = np.cross(north, up)
    weight, weighted, sensitivity = np.zeros((2, 2)), np.zeros(2), np.full((3, 3), np.nan)
    for c in range(3):
        design = np.column_stack([north[:, c], east[:, c], np.ones(len(rests)), up])
        solution = solve(design)
        readings = evidence.means[rests, c] / EARTH_RATE
        covariance = evidence.covariance(c)[np.ix_(rests, rests)] / EARTH_RATE**2
        excess = birge_ratio(solution, design, readings, covariance).factor
        values, used = solution.of(readings), np.flatnonzero(solution.estimable[LEVEL])
        known = solution.uncertainty(covariance)[GRAVITY] < KNOWN
        sensitivity[c] = np.where(known, values[GRAVITY], np.nan)
        operator = solution.operator[used]
        spread = excess**2 * operator @ covariance @ operator.T
        if len(used) and np.linalg.det(spread) > 0.0:
            of_gyro = np.linalg.inv(spread)
            weight[np.ix_(used, used)] += of_gyro
            weighted[used] += of_gyro @ values[used]
    level, by_all = np.full(2, np.nan), np.full((2, 2), np.nan)
    if np.linalg.det(weight) > 0.0:
        by_all = np.linalg.inv(weight)
        level = by_all @ weighted
    return EarthRate(level, by_all, *_vertical(sensitivity))


def _vertical(sensitivity: np.ndarray) -> tuple[float, float]:
    """What the diagonal has in common, and the standard deviation that the rest gives it."""
    diagonal = np.diag(sensitivity)
    apart = np.concatenate(
        [sensitivity[~np.eye(3, dtype=bool)], np.sqrt(1.5) * (diagonal - diagonal.mean())]
    )
    apart = apart[np.isfinite(apart)]
    spread = float(np.sqrt(np.mean(apart**2) / 3.0)) if len(apart) else float("nan")
    return float(diagonal.mean()), spread
