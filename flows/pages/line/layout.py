"""The layout of the Line page."""

from collections.abc import Sequence

import dash_mantine_components as dmc
from dash.development.base_component import Component

from flows.pages.line.alarms import NO_SERVER
from flows.pages.line.card import card
from flows.pages.line.models import AlarmShown, Flows, LineNow, LineQuestion, Output, Queued, Waits
from flows.pages.line.stop_button import acknowledgement
from flows.pages.local_time import hour_of
from flows.pages.page import View
from flows.pages.parts import Cell, facts, heading, notice, table
from flows.pages.states import Kind, StepState, badge, stated

WAITS: dict[Waits, Kind] = {"running": "good", "waiting": "open"}
COLUMNS = 3  # of cards on a wide screen; more would be too small to be read from three metres


def layout(line: LineNow, view: View, _: LineQuestion) -> Component:
    """A card for each station, then alarms, orders, flow runs and the day."""
    parts = [
        _stations(line, view),
        heading("pages-line-heading.alarms", view),
        _alarms(line.alarms, view),
    ]
    if line.catalogue is not None:
        parts.insert(0, notice(view, "pages-no-database", "red"))
    if line.today is not None:
        parts += [heading("pages-line-heading.orders", view), _orders(line.orders, view)]
    parts += [heading("pages-line-heading.flows", view), _flows(line.flows, view)]
    if line.today is not None:
        title = view.text("pages-line-today", day=str(line.today.day))
        parts += [dmc.Title(title, order=3, mt="sm"), _today(line.today, view)]
    return dmc.Stack(parts, gap="sm")


def _stations(line: LineNow, view: View) -> Component:
    if not line.stations:
        return dmc.Text(view.text("pages-line-no-station"))
    widest = min(COLUMNS, len(line.stations))
    columns = {"base": 1, "sm": min(2, widest), "lg": widest}
    cards = [card(each, view) for each in line.stations]
    return dmc.SimpleGrid(cards, cols=columns, spacing="md")


def _alarms(alarms: Sequence[AlarmShown], view: View) -> Component:
    rows = [
        (
            hour_of(each.at) if each.at else None,
            each.station or None,
            each.about or None,
            view.say(each.cause),
            view.say(each.todo),
            acknowledgement(each, view),
        )
        for each in alarms
    ]
    names = "at station about cause todo acknowledged"
    return table("pages-line-alarm", names, rows, view, 760, none="pages-line-none.alarms")


def _orders(orders: Sequence[Queued], view: View) -> Component:
    """The queue of each station, what runs first."""
    rows = [
        (
            each.station,
            ", ".join(each.serials),
            each.procedure,
            badge(stated(f"pages-line-waits.{each.state}", WAITS[each.state]), view),
            hour_of(each.since),
            each.client or None,
            each.number,
        )
        for each in sorted(orders, key=lambda each: (each.station, each.state))
    ]
    names = "station serial procedure state since client number"
    return table("pages-line-order", names, rows, view, 760, none="pages-line-none.orders")


def _flows(flows: Flows, view: View) -> Component:
    if not flows.server:
        return dmc.Text(view.text("pages-line-no-server"), size="sm")
    if flows.fault is not None:
        return dmc.Alert(view.say(NO_SERVER), color="red")
    rows = [
        (
            each.deployment,
            each.subject or None,
            badge(StepState(each.state, "bad" if each.is_late else "none"), view),
            hour_of(each.expected_at) if each.expected_at else None,
        )
        for each in flows.runs
    ]
    return table(
        "pages-line-flow",
        "deployment subject state expected",
        rows,
        view,
        none="pages-line-none.flows",
    )


def _today(today: Output, view: View) -> Component:
    stations = ", ".join(f"{name} {count}" for name, count in today.by_station.items())
    counts = today.model_dump(exclude={"day", "by_station"})
    shown: dict[str, Cell] = {
        f"pages-line-output.{name.replace('_', '-')}": str(count) for name, count in counts.items()
    }
    return facts(shown | {"pages-line-output.by-station": stations}, view)
