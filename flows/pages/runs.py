"""The Runs page: every run with the state of each step, filtered and sorted by the database."""

from collections.abc import Mapping
from datetime import date
from typing import Any, get_args

import dash_ag_grid as dag
import dash_mantine_components as dmc
from dash import Dash, Input, Output
from dash.development.base_component import Component
from pydantic import Field

from flows.pages.parts import (
    GRID_OPTIONS,
    Page,
    StepState,
    certificate_state,
    locale,
    result_state,
    said,
    say,
    validity_state,
    verdict_state,
)
from schemas.base import Frozen, Unusable
from schemas.certificate import State
from schemas.text import RunVerdict
from schemas.tolerance import Verdict
from storage.catalogue.run_states import Comparison, Condition, ResultState, RunLine, run_list
from storage.home import Home
from tasks.words import message

AT_ONCE = 100
MOST_AT_ONCE = 1000
EARLIEST, LATEST = date(1970, 1, 1), date(2999, 12, 31)  # where a question names no day
EQUALS = ("id", "manufacturer", "model", "serial", "station", "procedure", "method", "validity",
          "result_state", "state", "verdict", "certificate")  # fmt: skip
COMPARISONS: dict[str, Comparison] = {
    "contains": "contains", "notContains": "not_contains", "startsWith": "begins",
    "endsWith": "ends", "equals": "equals", "notEqual": "not_equals", "blank": "blank",
    "notBlank": "not_blank", "lessThan": "less", "lessThanOrEqual": "less_or_equal",
    "greaterThan": "greater", "greaterThanOrEqual": "greater_or_equal", "inRange": "between",
}  # fmt: skip
WORDED = {  # columns of states: their filter is on the words that are shown
    "validity": (get_args(RunVerdict), lambda code: message(f"pages-validity.{code or 'missing'}")),
    "result_state": (
        get_args(ResultState),
        lambda code: message(f"pages-result.{code or 'missing'}", count="…"),
    ),
    "state": (get_args(State), lambda code: message(f"pages-certificate.{code or 'missing'}")),
    "verdict": (
        get_args(Verdict),
        lambda code: message(f"conformity-verdict.{code}" if code else "pages-verdict-missing"),
    ),
}


class RunsQuestion(Frozen):
    """Which rows of the list: `count` of them after the first `start`.

    sort: a column of the rows; since, until: days of the recording, both included. The others
    are what a column must be equal to, without regard to case.
    """

    start: int = Field(default=0, ge=0, le=2**31)
    count: int = Field(default=AT_ONCE, ge=0, le=MOST_AT_ONCE)
    sort: str = Field(default="imported_at", max_length=40)
    descending: bool = True
    since: date | None = None
    until: date | None = None
    id: str | None = None
    manufacturer: str | None = None
    model: str | None = None
    serial: str | None = None
    station: str | None = None
    procedure: str | None = None
    method: str | None = None
    validity: RunVerdict | None = None
    result_state: ResultState | None = None
    state: State | None = None
    verdict: Verdict | None = None
    certificate: str | None = None


class RunsShown(Frozen):
    """Rows of the list, and how many runs meet the question in all."""

    total: int
    runs: tuple[RunLine, ...]


def data(question: RunsQuestion, home: Home) -> RunsShown:
    """Rows of the list of runs, from the catalogue alone."""
    order = [(question.sort, question.descending)]
    total, runs = run_list(conditions_of(question), order, question.start, question.count, home)
    return RunsShown(total=total, runs=tuple(runs))


def layout(shown: RunsShown, question: RunsQuestion) -> Component:
    """The list as a grid, which asks for its rows by itself as it is scrolled and filtered."""
    grid = dag.AgGrid(
        id="runs",
        columnDefs=columns(),
        defaultColDef={"resizable": True, "sortable": True, "wrapHeaderText": True,
                       "autoHeaderHeight": True},
        rowModelType="infinite",
        filterModel=filter_model(question),
        dashGridOptions=GRID_OPTIONS | {"localeText": locale(), "cacheBlockSize": AT_ONCE},
        style={"height": "calc(100vh - 190px)", "minHeight": "420px"},
    )  # fmt: skip
    count = said("pages-runs-count", count=shown.total)
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
        conditions = conditions_from(request.get("filterModel") or {})
        order = [(str(by["colId"]), by["sort"] == "desc") for by in request.get("sortModel") or ()]
        start = int(request["startRow"])
        total, runs = run_list(conditions, order, start, AT_ONCE, home)
        found = {"rowData": [row(run) for run in runs], "rowCount": total}
        return found, said("pages-runs-count", count=total)


def columns() -> list[dict[str, Any]]:
    """The columns of the grid; `State` and the links are renderers in assets/grid.js."""

    def column(name: str, width: int, kind: str = "Text", **more: Any) -> dict[str, Any]:
        heading = said(f"pages-column-{name.replace('_', '-')}")
        return {
            "field": name, "headerName": heading, "width": width, "minWidth": 90,
            "filter": f"ag{kind}ColumnFilter", "floatingFilter": True, **more,
        }  # fmt: skip

    def state(name: str, width: int) -> dict[str, Any]:
        return column(name, width, cellRenderer="State")

    # What an operator looks for stands within the width of a tablet held upright, 780 px.
    return [
        column("id", 120, cellRenderer="RunLink", pinned="left"),
        column("recorded_on", 150, "Date"),
        column("station", 80),
        column("serial", 100, cellRenderer="UnitLink"),
        state("validity", 105),
        state("verdict", 110),
        state("state", 105),
        state("result_state", 120),
        column("model", 120),
        column("certificate", 170),
        column("due", 210, "Date"),
        column("procedure", 120),
        column("method", 110),
        column("seconds", 110, "Number"),
        column("manufacturer", 140),
        column("recording_id", 220),
    ]


def row(run: RunLine) -> dict[str, Any]:
    """A run as a row of the grid; a state has its kind beside its words."""
    states: dict[str, StepState] = {
        "validity": validity_state(run.validity),
        "result_state": result_state(run),
        "verdict": verdict_state(run),
        "state": certificate_state(run.state),
    }
    plain = run.model_dump(mode="json", exclude=set(states)) | {"seconds": round(run.seconds, 1)}
    words = {name: say(each.words) for name, each in states.items()}
    kinds = {f"{name}_kind": each.kind for name, each in states.items()}
    return plain | words | kinds


def conditions_of(question: RunsQuestion) -> list[Condition]:
    """What a question asks of the rows."""
    asked = [
        Condition(column=name, value=value)
        for name in EQUALS
        if (value := getattr(question, name)) is not None
    ]
    if question.since or question.until:
        since, until = question.since or EARLIEST, question.until or LATEST
        asked.append(Condition(column="recorded_on", kind="between", value=since, to=until))
    return asked


def filter_model(question: RunsQuestion) -> dict[str, Any]:
    """The same as the grid's own filters, so that whoever looks at them sees them."""
    shown: dict[str, Any] = {}
    for condition in conditions_of(question):
        name = condition.column
        if isinstance(condition.value, date):
            shown[name] = {
                "filterType": "date", "type": "inRange", "dateFrom": f"{condition.value} 00:00:00",
                "dateTo": f"{condition.to} 00:00:00",
            }  # fmt: skip
        else:
            text = say(WORDED[name][1](condition.value)) if name in WORDED else condition.value
            shown[name] = {"filterType": "text", "type": "equals", "filter": text}
    return shown


def conditions_from(model: Mapping[str, Any]) -> list[Condition]:
    """What the grid's filters ask of the rows; raises Unusable for what is no filter of it."""
    try:
        return [_condition(name, each) for name, each in model.items()]
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise Unusable(f"the filter is not understood ({error}); take it out") from error


def _condition(name: str, model: Mapping[str, Any]) -> Condition:
    if "conditions" in model:
        parts = tuple(_condition(name, each) for each in model["conditions"])
        if model["operator"] == "OR":
            return Condition(column=name, any_of=parts)
        return Condition(column=name, all_of=parts)
    kind = COMPARISONS[model["type"]]
    if name in WORDED:
        return _by_words(name, kind, str(model.get("filter") or ""))
    if model.get("filterType") == "date":
        first, last = (_day(model.get(key)) for key in ("dateFrom", "dateTo"))
        return Condition(column=name, kind=kind, value=first, to=last)
    value = model.get("filter")
    return Condition(column=name, kind=kind, value=value, to=model.get("filterTo"))


def _by_words(name: str, kind: Comparison, text: str) -> Condition:
    """The states whose words meet the filter."""
    codes, words = WORDED[name]
    sought = text.casefold()
    meets = {
        "contains": lambda shown: sought in shown,
        "not_contains": lambda shown: sought not in shown,
        "equals": lambda shown: sought == shown,
        "not_equals": lambda shown: sought != shown,
        "begins": lambda shown: shown.startswith(sought),
        "ends": lambda shown: shown.endswith(sought),
    }
    if kind in ("blank", "not_blank"):
        return Condition(column=name, kind=kind)
    every: tuple[str | None, ...] = (*codes, None)
    found = tuple(code for code in every if meets[kind](say(words(code)).casefold()))
    return Condition(column=name, kind="among", values=found)


def _day(text: str | None) -> date | None:
    return date.fromisoformat(text[:10]) if text else None


PAGE = Page("runs", RunsQuestion, RunsShown, data, layout, has_grid=True, callbacks=callbacks)
