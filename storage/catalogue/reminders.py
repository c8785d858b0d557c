"""Which reminders were sent, and when the others will be tried again.

A reminder is a certificate, an occasion (days after the due date) and a channel.
"""

from collections.abc import Callable
from datetime import datetime, timedelta

import sqlalchemy as sql

from schemas.base import Frozen
from storage.catalogue import database, tables
from storage.home import Home


class Reminder(Frozen):
    """The state of a reminder; sent_at: null until it is sent; fault: of the last attempt."""

    certificate: str
    days: int
    channel: str
    tries: int
    next_try_at: datetime
    sent_at: datetime | None
    fault: str | None


def claim(
    home: Home,
    key: tuple[str, int, str],
    now: datetime,
    pause: Callable[[int], timedelta],
) -> bool:
    """Whether the caller is to send a reminder now: it was not sent, and no attempt is too recent.

    Of several processes that ask at once only one gets it. If that one dies before sending, another
    gets it after the pause.
    """
    table = tables.reminders
    certificate, days, channel = key
    with database.changing(home) as connection:
        database.add_new(
            connection, table, certificate=certificate, days=days, channel=channel,
            tries=0, next_try_at=now,
        )  # fmt: skip
        this = _is(key)
        row = connection.execute(sql.select(table).where(this).with_for_update()).one()
        if row.sent_at is not None or row.next_try_at > now:
            return False
        tries = row.tries + 1
        connection.execute(
            sql.update(table).where(this).values(tries=tries, next_try_at=now + pause(tries))
        )
        return True


def note(home: Home, key: tuple[str, int, str], now: datetime, fault: str | None) -> None:
    """Records that a reminder was sent, or why not."""
    sent_at = now if fault is None else None
    with database.changing(home) as connection:
        connection.execute(
            sql.update(tables.reminders).where(_is(key)).values(sent_at=sent_at, fault=fault)
        )


def all_reminders(home: Home) -> list[Reminder]:
    """Every reminder that was ever attempted, ordered by occasion."""
    table = tables.reminders
    asked = sql.select(table).order_by(table.c.certificate, table.c.days, table.c.channel)
    found = database.rows(home, asked)
    return [Reminder.model_validate(row, from_attributes=True) for row in found]


def _is(key: tuple[str, int, str]) -> sql.ColumnElement[bool]:
    table = tables.reminders.c
    certificate, days, channel = key
    return sql.and_(table.certificate == certificate, table.days == days, table.channel == channel)
