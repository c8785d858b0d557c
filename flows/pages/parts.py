"""Layout parts that several pages share."""

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from contextvars import ContextVar, copy_context
from dataclasses import dataclass, field
from datetime import UTC, date, datetime
from typing import Any, Literal, NamedTuple, TypeVar
from urllib.parse import parse_qsl, urlencode

import dash_ag_grid as dag
import dash_mantine_components as dmc
import plotly.io
from dash import ALL, MATCH, ClientsideFunction, Dash, Input, Output, State, dcc, html
from dash.development.base_component import Component
from flask import Blueprint, Response, g, request
from pydantic import ValidationError

from schemas.access import Visitor
from schemas.base import Frozen, NotAllowed, Unusable, faults
from schemas.certificate import LIVE
from schemas.tolerance import LimitDecision, Verdict
from storage.catalogue.database import Busy
from storage.catalogue.run_states import RunLine
from storage.home import Home
from tasks.conformity.limits import verdict_title
from tasks.specifications.estimate import ITEMS
from tasks.words import (
    LANGUAGES,
    MAIN,
    Argument,
    Message,
    Sayable,
    cause_of,
    identifiers,
    message,
)
from tasks.words import say as translated

# Times as people on the line read them: by the clock of the computer that serves the pages.
#
# That is the laboratory's (TZ), whoever looks from wherever: two persons who speak of the same
# run read the same time, and a day begins and ends for all at once.


def today() -> date:
    """The present day there."""
    return day_of(datetime.now(UTC))


def day_of(moment: datetime) -> date:
    """The day of a moment there."""
    return moment.astimezone().date()


def second_of(moment: datetime) -> str:
    """“2026-11-27 15:04:05”."""
    return f"{moment.astimezone():%F %T}"


def minute_of(moment: datetime) -> str:
    """“2026-11-27 15:04”."""
    return f"{moment.astimezone():%F %R}"


def day_in(text: str) -> str:
    """The day there of a moment in ISO 8601, its own day where it has no zone; any other text."""
    try:
        moment = datetime.fromisoformat(text)
    except ValueError:
        return text
    return str(day_of(moment) if moment.tzinfo else moment.date())


def hour_of(moment: datetime) -> str:
    """“15:04” of the present day; of another one with its day."""
    there = moment.astimezone()
    return f"{there:%R}" if there.date() == today() else f"{there:%F %R}"


def zone() -> Message:
    """The sentence that says once on a page which times it shows."""
    now = datetime.now(UTC).astimezone()
    return message("pages-times", zone=f"{now:%Z}", offset=now.isoformat()[-len("+08:00") :])


# The numbers of a page's tables and charts as CSV, for a spreadsheet or a script of one's own.

Row = Mapping[str, Any]
Numbers = Mapping[str, Callable[[Any], Sequence[Row]]]  # rows of an answer, by the name of the part
BOM = "\ufeff"  # without it, spreadsheets do not recognise UTF-8
FORMULA = ("=", "+", "-", "@", "\t", "\r")  # characters with which a spreadsheet formula begins


def rows_of(shown: Sequence[Frozen], **same: Any) -> list[Row]:
    """Each model as a row, after fields that are the same in all of them."""
    return [{**same, **_flat(each.model_dump(mode="json"))} for each in shown]


def _flat(fields: Row) -> dict[str, Any]:
    """A model inside a model is a column for each of its fields, a text one for each language."""
    flat: dict[str, Any] = {}
    for name, value in fields.items():
        if isinstance(value, Mapping):
            inside = ((inner, each) for inner, each in value.items() if inner != "message")
            flat |= {f"{name}_{inner}": each for inner, each in inside}
        else:
            flat[name] = value
    return flat


def csv_of(rows: Sequence[Row]) -> str:
    """CSV (RFC 4180) with a heading; nothing at all of no rows."""
    written = io.StringIO()
    if rows:
        writer = csv.DictWriter(written, list(rows[0]))
        writer.writeheader()
        writer.writerows({name: _csv_cell(value) for name, value in row.items()} for row in rows)
    return BOM + written.getvalue()


def _csv_cell(value: Any) -> Any:
    if isinstance(value, list):
        return " ".join(map(str, value))
    is_formula = isinstance(value, str) and value.startswith(FORMULA)
    return f"'{value}" if is_formula else value


def csv_link(page: str, part: str, question: Frozen) -> Component:
    """A link that downloads a part of the answer to the same question."""
    asked = {name: str(value) for name, value in question if value is not None}
    href = f"/api/v1/{page}/{part}.csv?{urlencode(asked)}"
    return html.A("CSV ↓", href=href, className="csv", download=f"{page}-{part}.csv")


# The record of a page, and the view (language, theme, visitor) for which it is laid out.

LANGUAGE, THEME = "mimucal_language", "mimucal_theme"
Theme = Literal["light", "dark"]


def parameters(search: str) -> dict[str, str]:
    """The fields of a query string, as `?id=r1` is one."""
    return dict(parse_qsl(search.removeprefix("?")))


@dataclass(frozen=True)
class View:
    """How somebody looks at the pages."""

    language: str = MAIN
    theme: Theme = "light"
    visitor: Visitor = field(default_factory=Visitor)


_VIEW: ContextVar[View] = ContextVar("view")
Made = TypeVar("Made")


def seen_by(view: View, make: Callable[..., Made], *given: Any) -> Made:
    """What a function makes of what it is given, for a view, whoever asks."""
    context = copy_context()
    context.run(_VIEW.set, view)
    return context.run(make, *given)


def view() -> View:
    """For whom is laid out: as `seen_by` says, else as the request asks by its cookies, or else in
    the browser's language, and light.
    """
    given = _VIEW.get(None)
    if given is not None:
        return given
    chosen = request.cookies.get(LANGUAGE)
    accepted = request.accept_languages.best_match(LANGUAGES, default=MAIN)
    theme: Theme = "dark" if request.cookies.get(THEME) == "dark" else "light"
    language = chosen if chosen in LANGUAGES else accepted
    return View(language=language, theme=theme, visitor=g.get("visitor") or Visitor())


def say(sayable: Sayable) -> str:
    """A message in the language of the view."""
    return translated(sayable, view().language)


def said(id_: str, /, **arguments: Argument) -> str:
    """A message of the catalogues, by its identifier, in that language."""
    return say(message(id_, **arguments))


@dataclass(frozen=True)
class Page:
    """A page at /NAME, its JSON at /api/v1/NAME and its words in pages.ftl at pages-NAME.

    question: the model of the query string, with a default for each field that may be left out.
    answer: the model that `data` gives, which is the JSON; `data` raises Unusable for what cannot
    be answered. layout: shows the answer to a question. in_navigation: whether the
    header leads to it. has_grid: whether its lists are grids. refresh_s: after how long it is asked
    for again, for a page that is live. callbacks: registers what the page does by itself. numbers:
    its tables and charts as rows, at /api/v1/NAME/PART.csv.
    """

    name: str
    question: type[Frozen]
    answer: type[Frozen]
    data: Callable[[Any, Home], Frozen]
    layout: Callable[[Any, Any], Component]
    in_navigation: bool = True
    has_grid: bool = False
    refresh_s: float | None = None
    callbacks: Callable[[Dash, Home], None] | None = None
    numbers: Numbers = field(default_factory=dict)

    def title(self) -> str:
        """What the navigation and the heading call it."""
        return said(f"pages-{self.name}")

    def about(self) -> str:
        """One sentence of what it shows."""
        return said(f"pages-{self.name}.about")


OWN_WORDS = "pages-grid-"
GRID_OPTIONS: dict[str, Any] = {
    "theme": "themeQuartz",
    "rowHeight": 44,  # px, room for a finger
    "suppressCellFocus": True,
    "enableCellTextSelection": True,
    "animateRows": False,
}
Cell = str | Component | None
ON_ONE_LINE = 32  # bytes: Latin letters, or ten Chinese ones, which are as wide


def table(
    group: str,
    names: str,
    rows: Sequence[Sequence[Cell]],
    min_width: int = 600,
    none: str = "",
    **arguments: Argument,
) -> Component:
    """A plain table; what is missing is a dash. names: of the columns, whose headings are the
    messages GROUP.NAME, or the one that is named whole, with these arguments. min_width: px, below
    which it scrolls. none: the message in the place of a table without rows.
    """
    if none and not rows:
        return dmc.Text(said(none), size="sm")
    ids = [name if name.startswith("pages-") else f"{group}.{name}" for name in names.split()]
    head = dmc.TableThead(dmc.TableTr([dmc.TableTh(said(id_, **arguments)) for id_ in ids]))
    body = [dmc.TableTr([_cell(cell) for cell in row]) for row in rows]
    shown = dmc.Table(
        [head, dmc.TableTbody(body)], striped=True, withTableBorder=True, verticalSpacing=4
    )
    return dmc.TableScrollContainer(shown, minWidth=min_width)


def _cell(cell: Cell) -> Component:
    """What is short, as a symbol or a link, stands on one line: the table scrolls instead."""
    is_short = (
        len(cell.encode()) <= ON_ONE_LINE if isinstance(cell, str) else isinstance(cell, dcc.Link)
    )
    shown = "–" if cell is None else cell
    return dmc.TableTd(shown, maw=480, className="whole" if is_short else None)


def heading(id_: str, more: str = "") -> Component:
    """The heading of a part of a page, a message by its identifier."""
    return dmc.Title(said(id_) + more, order=3, mt="sm")


def note(text: str) -> Component:
    """What explains what stands beside it."""
    return dmc.Text(text, size="sm", c="dimmed")


def notice(words: str, color: str, fault: Exception | str = "") -> Component:
    """What stands in the place of a page or of what was asked for, with the cause of the fault."""
    cause = say(cause_of(fault)) if fault else ""
    return dmc.Alert(cause, title=said(words), color=color, className="notice")


def asking(question: str) -> dict[str, str]:
    """What a button carries that acts after a question alone; `asking.js` puts it."""
    yes, no = (said(f"pages-asking.{word}") for word in ("yes", "no"))
    return {"data-ask": question, "data-yes": yes, "data-no": no}


def link(text: str, path: str, **fields: str) -> Component:
    """A link to a page with the fields of its question."""
    return dcc.Link(text, href=f"{path}?{urlencode(fields)}")


def facts(named: Mapping[str, Cell], across: int = 4) -> Component:
    """Names, as messages by their identifiers, and what they are, side by side."""
    cards = [
        dmc.Box(
            [
                dmc.Text(said(id_), size="xs", c="dimmed"),
                value if isinstance(value, Component) else dmc.Text(value or "–", lineClamp=3),
            ]
        )
        for id_, value in named.items()
    ]
    return dmc.SimpleGrid(cards, cols={"base": 2, "sm": across}, spacing="xs")


def grid(
    id_: str, group: str, names: str, rows: Sequence[Any], height: str, min_width: int,
    own: Mapping[str, Mapping[str, Any]],
) -> Component:  # fmt: skip
    """Rows that are sorted and filtered as somebody looks at them. group, names: as of a table;
    own: what a column has of its own. min_width: of a column, px.
    """
    columns = [
        {"field": name, "headerName": said(f"{group}.{name}"), **own.get(name, {})}
        for name in names.split()
    ]
    return dag.AgGrid(
        id=id_, columnDefs=columns, rowData=rows,
        defaultColDef={"resizable": True, "sortable": True, "flex": 1, "minWidth": min_width,
                       "filter": "agTextColumnFilter", "floatingFilter": True},
        dashGridOptions=GRID_OPTIONS | {"localeText": locale()},
        style={"height": height},
    )  # fmt: skip


def locale() -> dict[str, str]:
    """The grid's words by its own keys, which are the ends of the identifiers."""
    return {id_.removeprefix(OWN_WORDS): said(id_) for id_ in identifiers(OWN_WORDS)}


# Controls that reload a page with another question: each is a parameter of the address.


def control_id(field: str, value: object) -> dict[str, str]:
    """The id of a control that asks for a field of the question and holds a value now."""
    return {"asks": field, "was": "" if value is None else str(value)}


def choice(
    field: str, label: str, values: Sequence[Any], value: object, every: str = ""
) -> Component:
    """A choice of one of some values, or with `every` of all. label, every: messages."""
    return dmc.Select(
        id=control_id(field, value), label=said(label), data=list(values),
        value=None if value is None else str(value), searchable=True, clearable=bool(every),
        placeholder=said(every) if every else "", allowDeselect=False,
    )  # fmt: skip


def callbacks(app: Dash) -> None:
    """Another choice is another address."""
    control = {"asks": ALL, "was": ALL}
    app.clientside_callback(
        ClientsideFunction("asked", "ask"),
        Output("address", "search", allow_duplicate=True),
        Input(control, "value"),
        State(control, "id"),
        State("address", "search"),
        prevent_initial_call=True,
    )


# The outcome of a step of a run, in words and as one of four kinds that pages.css colours.
#
# Nothing that failed, is missing, is invalid or was taken back is good: `good` is stated, never
# the rest of a case distinction.

Kind = Literal["good", "open", "bad", "none"]
KINDS: dict[Verdict, Kind] = {"pass": "good", "fail": "bad", "inconclusive": "open"}


class StepState(NamedTuple):
    """A step's state as it is shown."""

    words: Sayable
    kind: Kind


def stated(id_: str, kind: Kind, **arguments: Argument) -> StepState:
    """A state whose words are a message by its identifier."""
    return StepState(message(id_, **arguments), kind)


def validity_state(verdict: str | None) -> StepState:
    """The verdict on a run."""
    kinds: dict[str | None, Kind] = {"valid": "good", "remarks": "open", "invalid": "bad"}
    return stated(f"pages-validity.{verdict or 'missing'}", kinds.get(verdict, "none"))


def result_state(run: RunLine) -> StepState:
    """Whether a run has a result, and a whole one."""
    kinds: dict[str, Kind] = {"failed": "bad", "missing": "none", "partial": "open"}
    kind = kinds.get(run.result_state) or ("bad" if run.validity == "invalid" else "good")
    return stated(f"pages-result.{run.result_state}", kind, count=run.missing or 0)


def certificate_state(state: str | None) -> StepState:
    """Where a certificate stands in its life."""
    kinds: dict[str | None, Kind] = {
        "draft": "open", "checked": "open", "issued": "good", "amended": "none", "withdrawn": "bad",
    }  # fmt: skip
    return stated(f"pages-certificate.{state or 'missing'}", kinds.get(state, "none"))


def decision_state(verdict: Verdict | None) -> StepState:
    """The verdict of a certificate."""
    if verdict is None:
        return stated("pages-verdict-missing", "none")
    return stated(f"conformity-verdict.{verdict}", KINDS[verdict])


def verdict_state(run: RunLine) -> StepState:
    """The verdict on the unit; a pass is good only on a run that bears it."""
    state = decision_state(run.verdict)
    stands = run.validity == "valid" and run.fault is None and run.state in LIVE
    return StepState(state.words, "open") if state.kind == "good" and not stands else state


def limit_state(decision: LimitDecision) -> StepState:
    """The verdict on one limit."""
    return StepState(verdict_title(decision), KINDS[decision.verdict])


def badge(state: StepState) -> Component:
    """A state as a word on its colour."""
    return html.Span(say(state.words), className=f"state state-{state.kind}")


# The order of items and elements on the pages: that of the specifications.

ORDER = {item: place for place, item in enumerate(ITEMS)}


def place(item: str, element: str = "") -> tuple[int, str, int, str]:
    """What to sort by; an item or element that no specification has comes last, by its name."""
    elements = ITEMS[item].elements if item in ITEMS else ()
    within = elements.index(element) if element in elements else len(elements)
    return ORDER.get(item, len(ORDER)), item, within, element


# Answers in JSON, and refusals with their reason.

STATUS = {NotAllowed: 403, Busy: 503}  # of a refusal; of any other 400


class Unanswered(Frozen):
    """Why there is no answer, as one sentence."""

    error: str


def refusal(status: int, sentence: str) -> Response:
    """An answer that gives nothing but the reason."""
    return json_answer(Unanswered(error=sentence).model_dump_json(), status)


def json_answer(text: str, status: int = 200) -> Response:
    """A document as an answer."""
    return Response(text, status, mimetype="application/json")


def refuse_what_is_raised(made: Blueprint) -> None:
    """Has each address of a blueprint answer with what it raises: every fault of a document, or the
    one sentence.
    """
    made.register_error_handler(
        ValidationError, lambda error: refusal(400, "; ".join(faults(error)))
    )
    made.register_error_handler(
        Unusable, lambda error: refusal(STATUS.get(type(error), 400), str(error))
    )


# Charts, drawn after the text of their page and in the colours of the theme.


BLUE, RED, ORANGE, GREY = "#1c7ed6", "#e03131", "#f08c00", "#868e96"
GRAPH: Any = {"displaylogo": False, "responsive": True}
Figure = dict[str, Any]


def figure(traces: Sequence[Figure], height: int, **layout: Any) -> Figure:
    """Traces and layout as plotly takes them. height: px."""
    name = f"mantine_{view().theme}"
    if name not in plotly.io.templates:
        dmc.add_figure_templates()
    template = plotly.io.templates[name].to_plotly_json()
    usual = {"margin": {"t": 20, "r": 20, "l": 70, "b": 50}, "height": height, "showlegend": False}
    return {"data": list(traces), "layout": {"template": template, **usual, **layout}}


def picture(id_: str, drawn: Figure) -> Component:
    """A picture that is drawn once the text stands, in a place of its height."""
    graph = dcc.Graph(id=id_, figure=drawn, config=GRAPH)
    kept = dcc.Store(id={"type": "picture-kept", "name": id_}, data=graph.to_plotly_json())
    place = dmc.Box(id={"type": "picture", "name": id_}, mih=drawn["layout"]["height"])
    return dmc.Box([kept, place])


def picture_callbacks(app: Dash) -> None:
    """Each picture into its place."""
    app.clientside_callback(
        ClientsideFunction("pictures", "show"),
        Output({"type": "picture", "name": MATCH}, "children"),
        Input({"type": "picture-kept", "name": MATCH}, "data"),
    )
