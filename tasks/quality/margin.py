"""The share of the margin to the limits that the uncertainty consumes."""

import numpy as np


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
