"""Capability and performance of values within their limits, with confidence intervals.

Cp and Cpk take the deviation from neighbour to neighbour in time (moving ranges), Pp and Ppk that
of all values together (NIST/SEMATECH e-Handbook of Statistical Methods, 6.1.6; ISO 22514-2).
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2, norm

from schemas.base import Finite, Frozen

D2 = 2.0 / np.sqrt(np.pi)  # mean range of two values of a normal distribution, in sigma
LEVEL = 0.95
# Values for an index: of 10 the 95 % interval of Cp reaches from 0.44 to 1.57 of it, and an index
# of fewer says nothing that could be acted on.
FEWEST = 10


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
    if n < FEWEST:
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
    low, high = (float(np.sqrt(chi2.ppf(p, dof) / dof)) for p in ((1 - LEVEL) / 2, (1 + LEVEL) / 2))
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
    half = float(norm.ppf((1 + LEVEL) / 2) * np.sqrt(1.0 / (9.0 * n) + value**2 / (2.0 * dof)))
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
