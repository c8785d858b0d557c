"""What became of an order, said once to whoever operates the line."""

from collections.abc import Iterator
from contextlib import suppress
from datetime import UTC, datetime, timedelta
from typing import Any

from sqlalchemy import Connection

from schemas.base import Unusable
from schemas.orders import ENDED, OPEN, ProductionOrder, ProductionState
from storage import settings
from storage.catalogue import audit_trail, database, orders
from storage.home import Home
from storage.stations import lockout_of
from tasks.stages.remind import alert
from tasks.words import Message, Sayable, cause_of, message

LINE = "line"  # the person of what the program itself enters in the trail
UNSENT = "alert not sent"
RECENT = timedelta(days=1)  # an older outcome is no news
LATE = timedelta(minutes=15)  # a person mounts a unit, a computer starts, within that


def tell(home: Home) -> None:
    """Alert the operators to every outcome that they were not alerted to yet.

    Those are orders that failed or were refused, and the next order of a station that nothing takes
    although nothing runs there. Whoever comes here first alerts, and the trail says so.
    """
    now = datetime.now(UTC)
    with suppress(Unusable):  # without the catalogue nobody knows what was said
        for order in failed_since(now - RECENT, home):
            outcome = "failed" if order.attempts else "refused"
            say_once(order, outcome, shown_cause(order), home)
        for order in _never_begun(now, home):
            say_once(order, "never-begun", message("order-outcome.nothing-takes-it"), home)


def say_once(order: ProductionOrder, outcome: str, cause: Sayable, home: Home) -> None:
    """Alert the operators, where the home names any and nobody did it for this attempt before.

    A channel by which it could not be sent is tried once more, by whoever comes next.
    """
    asked = settings.reminders(home)
    if asked is None or asked.operators is None:
        return
    about: dict[str, Any] = {"outcome": outcome, "attempt": order.attempts}
    with database.changing(home) as connection:
        due = [
            channel
            for channel in asked.operators.channels
            if _is_due(connection, order.number, **about, channel=channel)
        ]
    sent = alert(home, sentence_of(order, outcome, cause), only=due) if due else []
    if unsent := [each.channel for each in sent if each.fault]:
        with database.changing(home) as connection:
            for channel in unsent:
                audit_trail.add(connection, LINE, UNSENT, order.number, **about, channel=channel)


def _is_due(connection: Connection, number: str, **alert_: Any) -> bool:
    """Whether an alert is to be sent by a channel now, of which the trail has that it was."""
    if audit_trail.add_once(connection, LINE, "alert", number, **alert_):
        return True
    again = audit_trail.has(connection, UNSENT, number, **alert_)
    return again and audit_trail.add_once(connection, LINE, "alert again", number, **alert_)


def failed_since(moment: datetime, home: Home) -> list[ProductionOrder]:
    """The orders that failed since then, of the last ones."""
    states: tuple[ProductionState, ...] = ("failed",)
    failed = orders.listed(home, states=states, last=orders.MANY)
    return [each for each in failed if each.ended_at and each.ended_at > moment]


def sentence_of(order: ProductionOrder, outcome: str, cause: Sayable) -> Message:
    """Which order of which unit, what became of it on which station, why, and what to do."""
    about = {"number": order.number, "unit": order.serials, "station": order.station}
    minutes = f"{LATE.total_seconds() / 60:.0f}"
    return message(f"order-outcome.{outcome}", **about, minutes=minutes, cause=cause)


def shown_cause(order: ProductionOrder) -> Sayable:
    """Why an order failed, or does not begin, as pages and alerts show it."""
    return order.cause or cause_of(order.fault or "")


def _never_begun(now: datetime, home: Home) -> Iterator[ProductionOrder]:
    """The next order of each station where none is carried out, or kept from beginning."""
    next_of: dict[str, ProductionOrder | None] = {}
    for each in orders.listed(home, states=OPEN):
        next_of.setdefault(each.station, each)
        if each.state == "running" or each.fault:
            next_of[each.station] = None
    for order in filter(None, next_of.values()):
        last = orders.listed(home, order.station, ENDED, last=1)
        ended = [each.ended_at for each in last if each.ended_at]
        is_late = now - max((order.ordered_at, *ended)) > LATE
        if is_late and not lockout_of(order.station, home):
            yield order
