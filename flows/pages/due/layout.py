"""Lays the Due page out."""

from typing import Any

import dash_mantine_components as dmc
from dash.development.base_component import Component

from flows.pages.due.data import due_state
from flows.pages.due.models import DueQuestion, DueShown, MessageShown, StandardDue, UnitDue
from flows.pages.local_time import minute_of
from flows.pages.page import View
from flows.pages.parts import grid, heading, table
from flows.pages.pictures import BLUE, Figure, figure, picture
from flows.pages.query_controls import choice
from flows.pages.states import Kind, badge, stated
from schemas.text import text_in
from tasks.words import cause_of

HORIZONS = (0, 30, 60, 90, 180, 365)  # days
EVERY = "pages-due-all"
MESSAGE_KINDS: dict[str, Kind] = {"sent": "good", "failed": "bad", "waiting": "open"}
OWN: dict[str, dict[str, Any]] = {
    "name": {"cellRenderer": "UnitLink", "flex": 2, "minWidth": 190},
    "client": {"minWidth": 150}, "certificate": {"minWidth": 165},
    "state": {"cellRenderer": "State", "sortable": False, "minWidth": 175},
    "messages": {"filter": "agNumberColumnFilter"},
}  # fmt: skip
ROW_PX, FRAME_PX, MOST_PX = 38, 115, 560


def layout(shown: DueShown, view: View, question: DueQuestion) -> Component:
    """What is asked for; units, clients and months; messages; equipment."""
    return dmc.Stack(
        [
            _choices(shown, view, question),
            heading("pages-due-heading.units", view),
            *_units(shown, view, question),
            heading("pages-due-heading.clients", view),
            dmc.SimpleGrid(
                [_clients(shown, view, question), picture("due-months", _months(shown, view))],
                cols={"base": 1, "md": 2},
            ),
            heading("pages-due-heading.messages", view),
            _messages(shown, view),
            heading("pages-due-heading.equipment", view),
            _equipment(shown, view),
        ],
        gap="sm",
    )


def _choices(shown: DueShown, view: View, question: DueQuestion) -> Component:
    horizons = [
        {"value": str(days), "label": view.text("pages-due-within", days=days)}
        for days in sorted({*HORIZONS, question.within})
    ]
    named = {each[0]: {"value": each[0], "label": _client(each, view)} for each in shown.clients}
    clients = list(named.values())
    controls = [
        choice("client", "pages-due-asked.client", clients, question.client, view, EVERY),
        choice("model", "pages-due-asked.model", shown.models, question.model, view, EVERY),
        choice("within", "pages-due-asked.within", horizons, question.within, view),
    ]  # fmt: skip
    return dmc.SimpleGrid(controls, cols={"base": 1, "sm": 3}, spacing="xs")


def _client(client: tuple[str, str], view: View) -> str:
    return view.say(text_in(client) or "")


def _units(shown: DueShown, view: View, question: DueQuestion) -> list[Component]:
    overdue = sum(each.days < 0 for each in shown.units)
    counts = view.text(
        "pages-due-counts", overdue=overdue, coming=len(shown.units) - overdue,
        days=question.within, today=str(shown.today),
    )  # fmt: skip
    text = dmc.Text(counts, size="sm")
    if not shown.units:
        return [text]
    names = "name client due state certificate messages"
    rows = [_row(each, shown, view) for each in shown.units]
    height = f"{min(FRAME_PX + ROW_PX * len(rows), MOST_PX)}px"
    return [text, grid("due-units", "pages-due-column", names, rows, view, height, 130, OWN)]


def _row(each: UnitDue, shown: DueShown, view: View) -> dict[str, Any]:
    state = due_state(each.due, shown.today)
    return {
        "unit": each.unit, "name": each.name, "client": _client(each.client, view),
        "due": str(each.due), "state": view.say(state.words), "state_kind": state.kind,
        "certificate": each.certificate, "messages": each.messages,
    }  # fmt: skip


def _clients(shown: DueShown, view: View, question: DueQuestion) -> Component:
    rows = [
        (_client(each.client, view), str(each.overdue), str(each.coming))
        for each in shown.by_client
    ]
    names = "client pages-due-overdue pages-due-within"
    return table(
        "pages-due-column",
        names,
        rows,
        view,
        320,
        days=question.within,
        none="pages-due-none.clients",
    )


def _months(shown: DueShown, view: View) -> Figure:
    bars = {
        "type": "bar", "x": [each.month for each in shown.months],
        "y": [each.units for each in shown.months], "marker": {"color": BLUE},
        "hovertemplate": "%{x}: %{y}<extra></extra>",
    }  # fmt: skip
    title = view.text("pages-due-months")
    return figure([bars], view, 260, xaxis={"type": "category", "tickangle": -40},
                  yaxis={"rangemode": "tozero", "title": {"text": title}},
                  margin={"t": 10, "r": 10, "l": 55, "b": 60})  # fmt: skip


def _messages(shown: DueShown, view: View) -> Component:
    names = "at certificate occasion channel state tries fault"
    return table(
        "pages-due-message",
        names,
        [_message(e, view) for e in shown.messages],
        view,
        none="pages-due-none.messages",
    )


def _message(each: MessageShown, view: View) -> tuple[Any, ...]:
    side = "before" if each.days < 0 else "after"
    return (
        minute_of(each.at),
        each.certificate,
        view.text(f"pages-due-occasion.{side}", days=abs(each.days)),
        each.channel,
        badge(stated(f"pages-due-sent.{each.state}", MESSAGE_KINDS[each.state]), view),
        str(each.tries),
        each.fault and view.say(cause_of(each.fault)),
    )


def _equipment(shown: DueShown, view: View) -> Component:
    rows = [_standard(each, shown, view) for each in shown.equipment]
    return table(
        "pages-due-standard",
        "name serial certificate until state",
        rows,
        view,
        none="pages-due-none.equipment",
    )


def _standard(each: StandardDue, shown: DueShown, view: View) -> tuple[Any, ...]:
    return (
        view.say(each.name),
        each.serial,
        each.certificate,
        str(each.valid_until or "–"),
        badge(due_state(each.valid_until, shown.today), view),
    )
