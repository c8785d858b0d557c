"""What somebody must see to: its cause, and what to do about it.

Of stations, of their files, of orders, of messages to clients and of Prefect's runs.
"""

from collections.abc import Iterable, Iterator
from datetime import UTC, datetime, timedelta

from flows.pages.models.line import AlarmShown, FlowRun, Flows, StationNow
from schemas.production import ProductionState
from schemas.run_log import Alarm
from storage.catalogue import orders, reminders
from storage.catalogue.reminders import Reminder
from storage.home import Home
from tasks.words import Sayable, known, message, statement

SHOWN = 20
FAILED: tuple[ProductionState, ...] = ("failed",)
RECENT = timedelta(days=7)  # how long a failed order or a stopped run is shown


def newest(found: Iterable[AlarmShown]) -> tuple[AlarmShown, ...]:
    """The last ones first; what has no time stands now, and so before them."""
    latest = datetime.max.replace(tzinfo=UTC)
    return tuple(sorted(found, key=lambda each: each.at or latest, reverse=True)[:SHOWN])


def of_station(now: StationNow) -> Iterator[AlarmShown]:
    """Why a station's last run stopped or is silent, and what was noticed in it."""
    run = now.run
    if run is None or datetime.now(UTC) - run.at > RECENT:
        return
    units = ", ".join(run.units)
    if now.state in ("stopped", "lost", "silent"):
        cause = run.cause or message(f"pages-line-cause.{now.state}")
        todo = message(f"pages-line-todo.{now.state}", station=now.station)
        yield _alarm(run.at, now.station, units, cause, todo)
    for each in run.alarms:
        yield _alarm(each.at or run.at, now.station, units, each, _todo(each))


def _todo(alarm: Alarm) -> Sayable:
    """By the kind of the anomaly; a status of an earlier version names none."""
    id_ = f"station-todo.{alarm.code.replace('_', '-')}"
    return message(id_) if known(id_) else message("pages-line-todo.look")


def of_file(name: str, fault: str) -> AlarmShown:
    """A file in the home's stations that cannot be used."""
    return _alarm(None, "", name, fault, message("pages-line-todo.file"))


def of_flows(flows: Flows) -> Iterator[AlarmShown]:
    """A server that does not answer, and runs whose time has passed."""
    if flows.fault is not None:
        yield _alarm(None, "", "Prefect", flows.fault, message("pages-line-todo.server"))
    for run in flows.runs:
        if run.is_late:
            yield _late(run)


def _late(run: FlowRun) -> AlarmShown:
    about = f"{run.deployment} {run.subject}".strip()
    todo = message("pages-line-todo.late", pool=run.pool or "default")
    return _alarm(run.expected_at, "", about, message("pages-line-cause.late"), todo)


def of_catalogue(home: Home) -> Iterator[AlarmShown]:
    """Orders that failed, and messages to clients that could not be sent."""
    now = datetime.now(UTC)
    for order in orders.listed(home, states=FAILED, last=SHOWN):
        if order.ended_at is None or now - order.ended_at > RECENT:
            continue
        cause = message("pages-line-cause.order", number=order.number, fault=order.fault or "")
        todo = message("pages-line-todo.order")
        yield _alarm(order.ended_at, order.station, order.serials, cause, todo)
    for each in reminders.all_reminders(home):
        if each.sent_at is None and each.fault is not None:
            yield _unsent(each)


def _unsent(reminder: Reminder) -> AlarmShown:
    """The time of the last attempt is not kept."""
    cause = message(
        "pages-line-cause.reminder", channel=reminder.channel, fault=reminder.fault or ""
    )
    todo = message("pages-line-todo.reminder")
    return _alarm(None, "", reminder.certificate, cause, todo)


def _alarm(
    at: datetime | None, station: str, about: str, cause: Sayable, todo: Sayable
) -> AlarmShown:
    return AlarmShown(
        at=at, station=station, about=about, cause=statement(cause), todo=statement(todo)
    )
