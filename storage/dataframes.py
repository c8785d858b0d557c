"""What a home holds as pandas DataFrames, for questions over many runs.

    from storage import dataframes
    from storage.home import home

    table = dataframes.results(home())
    bias = table[(table["item"] == "gyro_bias") & table["newest"]]
    bias.pivot_table("value", "made_at", ["serial", "element"]).plot()

Units are those of the columns' names, or of the column `unit`. pandas is imported when a table
is asked for.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from schemas.calibration import Calibration, SegmentUsed
from schemas.uncertainty import BudgetInput
from storage.catalogue import listing
from storage.catalogue import results as kept_results
from storage.catalogue.listing import Run
from storage.catalogue.results import Result
from storage.home import Home

if TYPE_CHECKING:
    import pandas as pd

OF_RUN = ("recording_id", "manufacturer", "model", "serial")
OF_RESULT = ("method", "code_version", "made_at")
OF_ELEMENT = ("item", "element", "value", "u", "U", "k", "unit")


def runs(home: Home) -> "pd.DataFrame":
    """A row for each run in the order of import, with the columns of `Run`."""
    return _frame([run.model_dump() for run in listing.all_runs(home)], list(Run.model_fields))


def results(home: Home) -> "pd.DataFrame":
    """A row for each element of each item of each result, the oldest result first.

    result, run: their ids; of the run recording_id, manufacturer, model, serial; of the result
    method, code_version, made_at, and newest: whether no other supersedes it; then item, element
    (the axis that reads, then the input axis), value, u, U, k and their unit. What the recording
    cannot determine is NaN.
    """
    columns = ["result", "run", *OF_RUN, *OF_RESULT, "newest", *OF_ELEMENT]
    kept = kept_results.all_results(home)
    superseded = {result.supersedes for result in kept}
    rows = (
        row
        | {"newest": result.id not in superseded, "item": name, "element": element, "value": value}
        | {"u": item.u.get(element), "U": item.U.get(element), "k": item.k, "unit": item.unit}
        for result, row in _of_runs(kept, home)
        for name, item in result.calibration.items.items()
        for element, value in item.value.items()
    )
    return _frame(rows, columns).astype(dict.fromkeys(("value", "u", "U", "k"), float))


def segments(home: Home) -> "pd.DataFrame":
    """A row for each segment that a result used, with the columns of `SegmentUsed`.

    Before them the columns of the result and its run, as in `results`. t_start and t_end: s.
    """
    columns = ["result", "run", *OF_RUN, *OF_RESULT, *SegmentUsed.model_fields]
    rows = (
        row | segment.model_dump()
        for result, row in _of_runs(kept_results.all_results(home), home)
        for segment in result.calibration.segments
    )
    return _frame(rows, columns)


def budgets(calibration: Calibration) -> "pd.DataFrame":
    """A row for each input quantity of each uncertainty budget of a calibration.

    item and element say of what the budget is, u_c is the combined standard uncertainty in the
    item's unit; the other columns are those of `BudgetInput`.
    """
    columns = ["item", "element", "u_c", *BudgetInput.model_fields]
    rows = (
        {"item": name, "element": element, "u_c": budget.u_c} | line.model_dump()
        for name, item in calibration.items.items()
        for element, budget in item.budgets.items()
        for line in budget.inputs
    )
    return _frame(rows, columns)


def _of_runs(kept: Sequence[Result], home: Home) -> Iterable[tuple[Result, dict[str, Any]]]:
    """Each result with the columns that it and its run have in every table."""
    by_id = {run.id: run for run in listing.all_runs(home)}
    for result in kept:
        row = {"result": result.id, "run": result.run}
        row |= {name: getattr(by_id[result.run], name) for name in OF_RUN}
        yield result, row | {name: getattr(result, name) for name in OF_RESULT}


def _frame(rows: Iterable[Mapping[str, Any]], columns: Sequence[str]) -> "pd.DataFrame":
    """The columns are there even where there is no row."""
    import pandas as pd

    return pd.DataFrame(list(rows), columns=list(columns))
