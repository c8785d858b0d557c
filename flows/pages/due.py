"""The Due page: due dates of units and equipment, and the messages sent to clients."""

from collections import Counter
from collections.abc import Sequence
from datetime import date, datetime, timedelta
from typing import Any, Literal

import dash_mantine_components as dmc
from dash.development.base_component import Component
from dateutil.relativedelta import relativedelta
from pydantic import Field

from flows.pages.parts import (
    BLUE,
    Kind,
    Page,
    StepState,
    badge,
    choice,
    figure,
    grid,
    heading,
    minute_of,
    picture,
    said,
    say,
    stated,
    table,
    today,
)
from schemas.base import Frozen
from schemas.store import DueUnit
from schemas.text import Statement, text_in
from storage.catalogue import equipment
from storage.catalogue.equipment import Reminder
from storage.home import Home
from tasks.conformity.capabilities import name_of
from tasks.stages import remind
from tasks.words import cause_of, statement

# Due dates of units and equipment, and the messages sent to clients.

HORIZON_DAYS = 90
MessageState = Literal["sent", "failed", "waiting"]


class DueQuestion(Frozen):
    """What falls due within so many days from now, of a client and a model where they are named."""

    within: int = Field(default=HORIZON_DAYS, ge=0, le=36_500)
    client: str | None = Field(default=None, max_length=1000)
    model: str | None = Field(default=None, max_length=1000)


class UnitDue(Frozen):
    """A unit whose issued certificate has an agreed date. unit: its number in the catalogue;
    client: in English and in Chinese; days: to the date, negative where it is overdue; messages:
    how many went out.
    """

    unit: int
    name: str
    model: str
    client: tuple[str, str]
    certificate: str
    due: date
    days: int
    messages: int


class Month(Frozen):
    """How many units fall due in a month, YYYY-MM."""

    month: str
    units: int


class ClientDue(Frozen):
    """How many units of a client are overdue, and how many more fall due within the time."""

    client: tuple[str, str]
    overdue: int
    coming: int


class MessageShown(Frozen):
    """A message to a client. days: of its occasion, after the due date; fault: of the last try."""

    certificate: str
    days: int
    channel: str
    state: MessageState
    at: datetime
    tries: int
    fault: str | None


class StandardDue(Frozen):
    """A measurement standard with the certificate that counts now."""

    serial: str
    name: Statement
    certificate: str
    valid_until: date | None
    days: int | None


class DueShown(Frozen):
    """units: overdue ones and those within the time, the longest overdue first; months: of the
    next twelve. today: from which the days count. clients, models: that there are to choose from.
    """

    today: date
    units: tuple[UnitDue, ...]
    by_client: tuple[ClientDue, ...]
    months: tuple[Month, ...]
    messages: tuple[MessageShown, ...]
    equipment: tuple[StandardDue, ...]
    clients: tuple[tuple[str, str], ...]
    models: tuple[str, ...]


# Reads what is due from the catalogue, by the functions that send the reminders.

SOON = timedelta(days=90)
MONTHS = 12
LAST_MESSAGES = 500


def data(question: DueQuestion, home: Home) -> DueShown:
    """Units, messages and equipment of a question; raises Unusable for a damaged certificate."""
    now, every = today(), remind.due_units(home)
    of = [each for each in every if _is_asked(each, question)]
    messages = equipment.all_reminders(home)
    sent = Counter(each.certificate for each in messages if each.sent_at is not None)
    if question.client is not None or question.model is not None:
        theirs = {each.certificate for each in of}
        messages = [each for each in messages if each.certificate in theirs]
    until = now + timedelta(days=question.within)
    return DueShown(
        today=now,
        units=tuple(_unit(each, now, sent) for each in of if each.due <= until),
        by_client=tuple(_clients(of, now, until)),
        months=tuple(_months(of, now)),
        messages=tuple(sorted(map(_message, messages), key=_at, reverse=True)[:LAST_MESSAGES]),
        equipment=tuple(_equipment(home, now)),
        clients=tuple(sorted({each.client for each in every})),
        models=tuple(sorted({each.model for each in every})),
    )


def _is_asked(due_unit: DueUnit, question: DueQuestion) -> bool:
    is_client = question.client is None or question.client in due_unit.client
    return is_client and question.model in (None, due_unit.model)


def _unit(due_unit: DueUnit, now: date, sent: Counter[str]) -> UnitDue:
    return UnitDue(
        unit=due_unit.key, name=due_unit.unit, model=due_unit.model, client=due_unit.client,
        certificate=due_unit.certificate, due=due_unit.due, days=(due_unit.due - now).days,
        messages=sent[due_unit.certificate],
    )  # fmt: skip


def _clients(of: Sequence[DueUnit], now: date, until: date) -> list[ClientDue]:
    overdue = Counter(each.client for each in of if each.due < now)
    coming = Counter(each.client for each in of if now <= each.due <= until)
    return [
        ClientDue(client=client, overdue=overdue[client], coming=coming[client])
        for client in sorted(overdue | coming)
    ]


def _months(of: Sequence[DueUnit], now: date) -> list[Month]:
    """What falls due from today on in this month and in those after it."""
    counts = Counter(f"{each.due:%Y-%m}" for each in of if each.due >= now)
    first = now.replace(day=1)
    names = [f"{first + relativedelta(months=number):%Y-%m}" for number in range(MONTHS)]
    return [Month(month=name, units=counts[name]) for name in names]


def _message(reminder: Reminder) -> MessageShown:
    state: MessageState = "sent" if reminder.sent_at else "failed" if reminder.fault else "waiting"
    return MessageShown(
        certificate=reminder.certificate, days=reminder.days, channel=reminder.channel,
        state=state, at=reminder.sent_at or reminder.next_try_at, tries=reminder.tries,
        fault=reminder.fault,
    )  # fmt: skip


def _at(shown: MessageShown) -> tuple[float, str]:
    return shown.at.timestamp(), shown.certificate


def _equipment(home: Home, now: date) -> list[StandardDue]:
    """Each standard with the certificate that counts now, the first that falls due first."""
    counted = [
        StandardDue(
            serial=each.serial, name=statement(name_of(each)), certificate=each.certificate,
            valid_until=each.valid_until,
            days=(each.valid_until - now).days if each.valid_until else None,
        )
        for each in equipment.on_day(home, now).values()
    ]  # fmt: skip
    return sorted(counted, key=lambda each: (each.valid_until or date.max, each.serial))


def due_state(due: date | None, day: date | None = None) -> StepState:
    """Overdue is bad, and what falls due within 90 days is open. day: the present one."""
    now = day or today()
    if due is None:
        return stated("pages-due-state.none", "none")
    if due < now:
        return stated("pages-due-state.overdue", "bad", days=(now - due).days)
    days = (due - now).days
    return stated("pages-due-state.in", "open" if due <= now + SOON else "good", days=days)


# Lays the Due page out.

HORIZONS = (0, 30, 60, 90, 180, 365)  # days
EVERY = "pages-due-all"
MESSAGE_KINDS: dict[str, Kind] = {"sent": "good", "failed": "bad", "waiting": "open"}
OWN: dict[str, dict[str, Any]] = {
    "name": {"cellRenderer": "UnitLink", "flex": 2, "minWidth": 190},
    "client": {"minWidth": 150},
    "certificate": {"minWidth": 165},
    "state": {"cellRenderer": "State", "sortable": False, "minWidth": 175},
    "messages": {"filter": "agNumberColumnFilter"},
}
ROW_PX, FRAME_PX, MOST_PX = 38, 115, 560


def layout(shown: DueShown, question: DueQuestion) -> Component:
    """What is asked for; units, clients and months; messages; equipment."""
    bars = {
        "type": "bar", "x": [each.month for each in shown.months],
        "y": [each.units for each in shown.months], "marker": {"color": BLUE},
        "hovertemplate": "%{x}: %{y}<extra></extra>",
    }  # fmt: skip
    title = said("pages-due-months")
    names = "at certificate occasion channel state tries fault"
    return dmc.Stack(
        [
            _choices(shown, question),
            heading("pages-due-heading.units"),
            *_units(shown, question),
            heading("pages-due-heading.clients"),
            dmc.SimpleGrid(
                [
                    _client_table(shown, question),
                    picture(
                        "due-months",
                        figure(
                            [bars],
                            260,
                            xaxis={"type": "category", "tickangle": -40},
                            yaxis={"rangemode": "tozero", "title": {"text": title}},
                            margin={"t": 10, "r": 10, "l": 55, "b": 60},
                        ),
                    ),
                ],
                cols={"base": 1, "md": 2},
            ),
            heading("pages-due-heading.messages"),
            table(
                "pages-due-message",
                names,
                [_message_row(e) for e in shown.messages],
                none="pages-due-none.messages",
            ),
            heading("pages-due-heading.equipment"),
            _equipment_table(shown),
        ],
        gap="sm",
    )


def _choices(shown: DueShown, question: DueQuestion) -> Component:
    horizons = [
        {"value": str(days), "label": said("pages-due-within", days=days)}
        for days in sorted({*HORIZONS, question.within})
    ]
    named = {each[0]: {"value": each[0], "label": _client(each)} for each in shown.clients}
    clients = list(named.values())
    controls = [
        choice("client", "pages-due-asked.client", clients, question.client, EVERY),
        choice("model", "pages-due-asked.model", shown.models, question.model, EVERY),
        choice("within", "pages-due-asked.within", horizons, question.within),
    ]
    return dmc.SimpleGrid(controls, cols={"base": 1, "sm": 3}, spacing="xs")


def _client(client: tuple[str, str]) -> str:
    return say(text_in(client) or "")


def _units(shown: DueShown, question: DueQuestion) -> list[Component]:
    overdue = sum(each.days < 0 for each in shown.units)
    counts = said(
        "pages-due-counts", overdue=overdue, coming=len(shown.units) - overdue,
        days=question.within, today=str(shown.today),
    )  # fmt: skip
    text = dmc.Text(counts, size="sm")
    if not shown.units:
        return [text]
    names = "name client due state certificate messages"
    rows = [_row(each, shown) for each in shown.units]
    height = f"{min(FRAME_PX + ROW_PX * len(rows), MOST_PX)}px"
    return [text, grid("due-units", "pages-due-column", names, rows, height, 130, OWN)]


def _row(each: UnitDue, shown: DueShown) -> dict[str, Any]:
    state = due_state(each.due, shown.today)
    return {
        "unit": each.unit, "name": each.name, "client": _client(each.client),
        "due": str(each.due), "state": say(state.words), "state_kind": state.kind,
        "certificate": each.certificate, "messages": each.messages,
    }  # fmt: skip


def _client_table(shown: DueShown, question: DueQuestion) -> Component:
    rows = [(_client(each.client), str(each.overdue), str(each.coming)) for each in shown.by_client]
    names = "client pages-due-overdue pages-due-within"
    return table(
        "pages-due-column",
        names,
        rows,
        320,
        days=question.within,
        none="pages-due-none.clients",
    )


def _message_row(each: MessageShown) -> tuple[Any, ...]:
    side = "before" if each.days < 0 else "after"
    return (
        minute_of(each.at),
        each.certificate,
        said(f"pages-due-occasion.{side}", days=abs(each.days)),
        each.channel,
        badge(stated(f"pages-due-sent.{each.state}", MESSAGE_KINDS[each.state])),
        str(each.tries),
        each.fault and say(cause_of(each.fault)),
    )


def _equipment_table(shown: DueShown) -> Component:
    rows = [_standard(each, shown) for each in shown.equipment]
    return table(
        "pages-due-standard",
        "name serial certificate until state",
        rows,
        none="pages-due-none.equipment",
    )


def _standard(each: StandardDue, shown: DueShown) -> tuple[Any, ...]:
    return (
        say(each.name),
        each.serial,
        each.certificate,
        str(each.valid_until or "–"),
        badge(due_state(each.valid_until, shown.today)),
    )


# The Due page: recalibration calendar, messages to clients, and the laboratory's equipment.

PAGE = Page("due", DueQuestion, DueShown, data, layout, has_grid=True)
