"""The content of a home as pandas DataFrames, for questions over many runs.

    from storage import dataframes
    from storage.home import home

    table = dataframes.results(home())
    bias = table[(table["item"] == "gyro_bias") & table["newest"]]
    bias.pivot_table("value", "made_at", ["serial", "element"]).plot()

Each is one question to the catalogue: no recording is opened. Units are those of the columns'
names, or of the column `unit`. `written` gives the same as text, without pandas, which takes a
third of a second to import.
"""

import csv
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TextIO

import sqlalchemy as sql

from schemas.calibration import BudgetInput, Calibration
from storage.catalogue import database, tables
from storage.catalogue.run_states import complete_results, complete_runs
from storage.home import Home

if TYPE_CHECKING:
    import pandas as pd


RUN, RESULT = tables.runs.c, tables.results.c
STANDARD, EXPANDED = "standard_uncertainty", "expanded_uncertainty"  # u and U: one name to SQL
OF_RUN = (
    RUN.recording_id,
    *(tables.units.c[name] for name in ("manufacturer", "model", "serial")),
    *(RUN[name] for name in ("station", "procedure", "recorded_on")),
)
OF_RESULT = (RESULT.method, tables.outcomes.c.terms, RESULT.code_version, RESULT.made_at)


def runs(home: Home) -> "pd.DataFrame":
    """A row for each run in the order of import: who, where, when, and how long."""
    return _frame(home, _runs(home))


def results(home: Home) -> "pd.DataFrame":
    """A row for each element of each item of each result, the oldest result first.

    result, run: their ids; then what is known of the run, and of the result method, terms (those
    adopted beside the standard's; empty: none), code_version, made_at, and newest: whether no other
    of its method and terms supersedes it; then item, element (the axis that reads,
    then the input axis), value, standard_uncertainty, expanded_uncertainty, k and their unit. What
    the recording cannot determine is NaN.
    """
    figures = ("value", STANDARD, EXPANDED, "k")
    return _frame(home, _results(home)).astype(dict.fromkeys(figures, float))


def segments(home: Home) -> "pd.DataFrame":
    """A row for each segment that a result used, with what `SegmentUsed` says of it.

    Before that what is known of the run and of the result, as in `results`. t_start and t_end: s;
    mean_* and deviation_* of a channel over the rows: gyro rad/s, accel m/s².
    """
    frame = _frame(home, _segments(home))
    means = [name for name in frame if str(name).startswith(("mean_", "deviation_"))]
    return frame.astype(dict.fromkeys(means, float))


def certificates(home: Home) -> "pd.DataFrame":
    """A row for each certificate in the order in which they were kept, with its run and result."""
    return _frame(home, _certificates(home))


def budgets(calibration: Calibration) -> "pd.DataFrame":
    """A row for each input quantity of each uncertainty budget of a calibration.

    item and element say of what the budget is, u_c is the combined standard uncertainty in the
    item's unit; the other columns are those of `BudgetInput`.
    """
    import pandas as pd

    columns = ["item", "element", "u_c", *BudgetInput.model_fields]
    rows = [
        {"item": name, "element": element, "u_c": budget.u_c} | line.model_dump()
        for name, item in calibration.items.items()
        for element, budget in item.budgets.items()
        for line in budget.inputs
    ]
    return pd.DataFrame(rows, columns=columns)


TABLES: Mapping[str, Callable[[Home], "pd.DataFrame"]] = {
    "runs": runs,
    "results": results,
    "segments": segments,
    "certificates": certificates,
}


def written(what: str, home: Home, file: TextIO) -> None:
    """A table of TABLES as CSV, as its DataFrame writes itself without its index."""
    asked = QUESTIONS[what](home)
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(column.name for column in asked.selected_columns)
    writer.writerows(database.rows(home, asked))


def records(what: str, home: Home) -> list[dict[str, Any]]:
    """The rows of a table of TABLES by the names of its columns; None: not known."""
    asked = QUESTIONS[what](home)
    names = [column.name for column in asked.selected_columns]
    return [dict(zip(names, row, strict=True)) for row in database.rows(home, asked)]


def _runs(home: Home) -> sql.Select[Any]:
    complete_runs(home)
    columns = (RUN.id, RUN.digest, *OF_RUN, RUN.standard, RUN.imported_at)
    asked = sql.select(*columns, RUN.seconds, RUN.rows).join_from(tables.runs, tables.units)
    return asked.order_by(RUN.imported_at, RUN.id)


def _results(home: Home) -> sql.Select[Any]:
    element = tables.elements.c
    columns = (
        *(element[name] for name in ("item", "element", "value")),
        element.u.label(STANDARD),
        element.expanded.label(EXPANDED),
        *(element[name] for name in ("k", "unit")),
    )
    return _of_results(home, tables.elements, columns)


def _segments(home: Home) -> sql.Select[Any]:
    segment = tables.segments.c
    columns = [column for column in segment if column is not segment.result]
    return _of_results(home, tables.segments, columns)


def _certificates(home: Home) -> sql.Select[Any]:
    complete_runs(home)
    paper = tables.certificates
    columns = [column for column in paper.c if column is not paper.c.unit]
    asked = sql.select(*columns, *OF_RUN).join_from(paper, tables.runs).join(tables.units)
    return asked.order_by(paper.c.kept_at, paper.c.number)


QUESTIONS: Mapping[str, Callable[[Home], sql.Select[Any]]] = {
    "runs": _runs,
    "results": _results,
    "segments": _segments,
    "certificates": _certificates,
}


def _of_results(
    home: Home, table: sql.Table, columns: Sequence[sql.ColumnElement[Any]]
) -> sql.Select[Any]:
    """Rows that belong to results, each with the columns of its run and its result before it."""
    complete_runs(home)
    complete_results(home)
    newest = database.newest_results().label("newest")
    first = (RESULT.id.label("result"), RESULT.run, *OF_RUN, *OF_RESULT, newest)
    joined = tables.results.join(tables.runs).join(tables.units).join(table)
    # A document that cannot be read has no outcome, but may have left its rows.
    joined = joined.outerjoin(tables.outcomes, tables.outcomes.c.result == RESULT.id)
    asked = sql.select(*first, *columns).select_from(joined)
    return asked.order_by(RESULT.made_at, RESULT.id, *table.primary_key)


def _frame(home: Home, asked: sql.Select[Any]) -> "pd.DataFrame":
    """The columns are there even where there is no row."""
    import pandas as pd

    names = [column.name for column in asked.selected_columns]
    return pd.DataFrame.from_records(database.rows(home, asked), columns=names)
