"""First-pass yield: the share of first runs that passed, with its interval."""

from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import norm

if TYPE_CHECKING:
    import pandas as pd

LEVEL = 0.95


def wilson(
    passed: np.ndarray, of: np.ndarray, level: float = LEVEL
) -> tuple[np.ndarray, np.ndarray]:
    """The score interval of a proportion (E. B. Wilson, JASA 22 (1927) 209); NaN of none.

    passed, of: (n,) how many of how many. Gives its lower and its upper bound, (n,) each.
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
    grouped = runs.groupby(by, sort=True)["passed"]
    table = grouped.agg(["sum", "size"]).rename(columns={"sum": "passed", "size": "of"})
    low, high = wilson(table["passed"].to_numpy(), table["of"].to_numpy())
    return table.assign(share=table["passed"] / table["of"], low=low, high=high)
