"""What somebody must see to: its cause, and what to do about it.

Of stations, of their files, of orders, of messages to clients and of Prefect's runs.
"""

from collections.abc import Iterable, Iterator
from datetime import UTC, datetime, timedelta
from hashlib import sha256

from flows.orders.outcomes import LATE, failed_since, shown_cause
from flows.pages.line.models import Acknowledged, AlarmShown, FlowRun, Flows, StationNow
from schemas.production import ProductionOrder
from schemas.run_log import Alarm
from storage.catalogue import orders, reminders, trail
from storage.catalogue.reminders import Reminder
from storage.home import Home
from tasks.words import Sayable, cause_of, known, message, statement

SHOWN = 20
ACKNOWLEDGE = "acknowledge alarm"
NO_SERVER = message("station-cause.no-server")
RECENT = timedelta(days=7)  # how long a failed order or a stopped run is shown


def newest(found: Iterable[AlarmShown]) -> tuple[AlarmShown, ...]:
    """The last ones first, those that somebody acknowledged at the end; what has no time stands
    now, and so before those that have.
    """
    latest = datetime.max.replace(tzinfo=UTC)
    last_first = sorted(found, key=lambda each: each.at or latest, reverse=True)
    return tuple(sorted(last_first, key=lambda each: each.acknowledged is not None)[:SHOWN])


def with_acknowledgement(found: Iterable[AlarmShown], home: Home) -> list[AlarmShown]:
    """The alarms, each with who acknowledged it last."""
    since = datetime.now(UTC) - RECENT
    known = {
        each.subject: Acknowledged(by=each.person, at=each.at)
        for each in trail.of_action(ACKNOWLEDGE, since, home)
    }
    return [each.model_copy(update={"acknowledged": known.get(each.key)}) for each in found]


def of_station(now: StationNow) -> Iterator[AlarmShown]:
    """Why a station's last run stopped or is silent, and what was noticed in it."""
    run = now.run
    if run is None or datetime.now(UTC) - run.at > RECENT:
        return
    units = ", ".join(run.units)
    if now.state in ("stopped", "lost", "silent"):
        cause: Sayable = message(f"pages-line-cause.{now.state}")
        if run.cause:
            cause = run.shown_cause or cause_of(run.cause)
        todo = message(f"pages-line-todo.{now.state}", station=now.station)
        yield _alarm(run.at, now.station, units, cause, todo, (now.state, run.began_at))
    for each in run.alarms:
        known_by = (each.code or each.en, run.began_at)
        yield _alarm(each.at or run.at, now.station, units, each, _todo(each), known_by)


def _todo(alarm: Alarm) -> Sayable:
    """By the kind of the anomaly; a status of an earlier version names none."""
    id_ = f"station-todo.{alarm.code.replace('_', '-')}"
    return message(id_) if known(id_) else message("pages-line-todo.look")


def of_file(name: str, fault: str) -> AlarmShown:
    """A file in the home's stations that cannot be used."""
    return _alarm(None, "", name, cause_of(fault), message("pages-line-todo.file"))


def of_flows(flows: Flows) -> Iterator[AlarmShown]:
    """A server that does not answer, and runs whose time has passed."""
    if flows.fault is not None:
        yield _alarm(None, "", "Prefect", NO_SERVER, message("pages-line-todo.server"))
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
    for order in failed_since(now - RECENT, home):
        yield _of_order(order, order.ended_at or now, "order")
    for order in orders.waiting(home):
        if order.fault is not None and now - order.ordered_at > LATE:
            yield _of_order(order, order.ordered_at, "waits")
    for each in reminders.all_reminders(home):
        if each.sent_at is None and each.fault is not None:
            yield _unsent(each)


def _of_order(order: ProductionOrder, at: datetime, todo: str) -> AlarmShown:
    cause = message("pages-line-cause.order", number=order.number, fault=shown_cause(order))
    what = message(f"pages-line-todo.{todo}")
    return _alarm(at, order.station, order.serials, cause, what, (order.number, at))


def _unsent(reminder: Reminder) -> AlarmShown:
    """The time of the last attempt is not kept."""
    cause = message(
        "pages-line-cause.reminder", channel=reminder.channel, fault=cause_of(reminder.fault or "")
    )
    todo = message("pages-line-todo.reminder")
    return _alarm(None, "", reminder.certificate, cause, todo)


def _alarm(
    at: datetime | None, station: str, about: str, cause: Sayable, todo: Sayable,
    known_by: tuple[object, ...] = (),
) -> AlarmShown:  # fmt: skip
    """known_by: what distinguishes it from the next alarm about the same; else its cause."""
    cause = statement(cause)
    parts = (station, about, *(known_by or (cause.en,)))
    key = sha256("\n".join(map(str, parts)).encode()).hexdigest()[:16]
    return AlarmShown(
        key=key, at=at, station=station, about=about, cause=cause, todo=statement(todo)
    )
