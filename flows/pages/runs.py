"""The Runs page: every run with the state of each step, filtered and sorted by the database."""

from typing import Any

import dash_ag_grid as dag
import dash_mantine_components as dmc
from dash import Dash, Input, Output
from dash.development.base_component import Component

from flows.pages.grid import GRID_OPTIONS, locale
from flows.pages.page import Page, View
from flows.pages.preferences import view_of_request
from flows.pages.run_grid import columns, conditions_from, conditions_of, filter_model, row
from schemas.pages.runs import AT_ONCE, RunsQuestion, RunsShown
from storage.catalogue.run_states import run_list
from storage.home import Home
from tasks.words import message


def data(question: RunsQuestion, home: Home) -> RunsShown:
    """Rows of the list of runs, from the catalogue alone."""
    order = [(question.sort, question.descending)]
    total, runs = run_list(conditions_of(question), order, question.start, question.count, home)
    return RunsShown(total=total, runs=tuple(runs))


def layout(shown: RunsShown, view: View, question: RunsQuestion) -> Component:
    """The list as a grid, which asks for its rows by itself as it is scrolled and filtered."""
    grid = dag.AgGrid(
        id="runs",
        columnDefs=columns(view),
        defaultColDef={"resizable": True, "sortable": True},
        rowModelType="infinite",
        filterModel=filter_model(question, view),
        dashGridOptions=GRID_OPTIONS | {"localeText": locale(view), "cacheBlockSize": AT_ONCE},
        style={"height": "calc(100vh - 190px)", "minHeight": "420px"},
    )
    count = view.say(message("pages-runs-count", count=shown.total))
    return dmc.Stack([dmc.Text(count, id="runs-count"), grid], gap="xs")


def callbacks(app: Dash, home: Home) -> None:
    """Rows for the grid, a block at a time."""

    @app.callback(
        Output("runs", "getRowsResponse"),
        Output("runs-count", "children"),
        Input("runs", "getRowsRequest"),
        prevent_initial_call=True,
    )
    def rows(request: dict[str, Any]) -> tuple[dict[str, Any], str]:
        view = view_of_request()
        conditions = conditions_from(request.get("filterModel") or {}, view)
        order = [(str(by["colId"]), by["sort"] == "desc") for by in request.get("sortModel") or ()]
        start = int(request["startRow"])
        total, runs = run_list(conditions, order, start, AT_ONCE, home)
        found = {"rowData": [row(run, view) for run in runs], "rowCount": total}
        return found, view.say(message("pages-runs-count", count=total))


PAGE = Page("runs", RunsQuestion, RunsShown, data, layout, has_grid=True, callbacks=callbacks)
