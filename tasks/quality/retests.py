"""The retest rule: which runs are the first of a unit's visit."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

RETEST_DAYS = 7  # within which a run of a unit is another try of the run before it


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
