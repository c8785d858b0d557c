"""First-pass yield: the share of first runs that passed, with a confidence interval."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import norm

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
