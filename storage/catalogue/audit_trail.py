"""The audit trail: who did what and when, append-only, each entry chained to the previous one.

The hash of an entry is the SHA-256 of its fields as canonical JSON, the hash of the entry before
among them. `trail_end` holds the number and hash of the last one, so that a cut-off end is found.
"""

import hashlib
import json
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any

import sqlalchemy as sql

from schemas.base import Frozen
from storage.catalogue import database, tables
from storage.home import Home

NOTHING_BEFORE = "0" * 64
RESTORE = "bring the catalogue back from a backup, and keep this one for the auditor"


class TrailEntry(Frozen):
    """One entry. `subject`: what was done to, as the number of a certificate; details: JSON."""

    number: int
    at: datetime
    person: str
    action: str
    subject: str
    details: str
    previous_hash: str
    hash: str


def add(
    connection: sql.Connection,
    person: str,
    action: str,
    subject: str,
    *,
    at: datetime | None = None,
    **details: Any,
) -> None:
    """Adds an entry within the transaction of the action it records.

    at: time of the action, now unless given. details: JSON values. Writers wait here for the end of
    each other's transactions, so call it last.
    """
    end = tables.trail_end
    counted = sql.update(end).values(number=end.c.number + 1).returning(end.c.number, end.c.hash)
    number, before = connection.execute(counted).one()
    fields = {
        "number": number,
        "at": (at or datetime.now(UTC)).astimezone(UTC),
        "person": person,
        "action": action,
        "subject": subject,
        "details": _canonical(details),
        "previous_hash": before,
    }
    hash_ = _hash(fields)
    connection.execute(sql.insert(tables.trail).values(**fields, hash=hash_))
    connection.execute(sql.update(end).values(hash=hash_))


def add_once(
    connection: sql.Connection,
    person: str,
    action: str,
    subject: str,
    *,
    at: datetime | None = None,
    **details: Any,
) -> bool:
    """Adds an entry unless there is one of this action, subject and details; whether it was new."""
    end = tables.trail_end
    connection.execute(sql.update(end).values(number=end.c.number))  # others wait from here
    if has(connection, action, subject, **details):
        return False
    add(connection, person, action, subject, at=at, **details)
    return True


def has(connection: sql.Connection, action: str, subject: str, **details: Any) -> bool:
    """Whether there is an entry of this action, subject and details."""
    entry = tables.trail.c
    alike = (entry.action == action, entry.subject == subject, entry.details == _canonical(details))
    return connection.execute(sql.select(entry.number).where(*alike).limit(1)).first() is not None


def of_action(action: str, since: datetime, home: Home) -> list[TrailEntry]:
    """The entries of an action since a moment, the oldest first."""
    entry = tables.trail.c
    mine = sql.select(tables.trail).where(entry.action == action, entry.at >= since)
    found = database.rows(home, mine.order_by(entry.number))
    return [TrailEntry.model_validate(row, from_attributes=True) for row in found]


def entries(home: Home) -> list[TrailEntry]:
    """The whole trail, in the order in which it was written."""
    asked = sql.select(tables.trail).order_by(tables.trail.c.number)
    return [
        TrailEntry.model_validate(row, from_attributes=True) for row in database.rows(home, asked)
    ]


def faults(home: Home) -> Iterator[str]:
    """Signs that the trail was changed: a gap, an edit, another order, a missing end."""
    ends = database.rows(home, sql.select(tables.trail_end))  # first: others may go on writing
    hashes = {0: NOTHING_BEFORE}
    number = 0
    for entry in entries(home):
        if entry.number != number + 1:
            yield f"entry {number + 1} is missing; {RESTORE}"
        elif entry.previous_hash != hashes[number]:
            yield f"entry {entry.number} does not follow the entry before it; {RESTORE}"
        if entry.hash != _hash(entry.model_dump(exclude={"hash"})):
            yield f"entry {entry.number} was changed after it was written; {RESTORE}"
        number = entry.number
        hashes[number] = entry.hash
    for end in ends:
        if hashes.get(end.number) != end.hash:
            yield f"it does not end with entry {end.number} as it was written; {RESTORE}"


def _hash(fields: dict[str, Any]) -> str:
    dated = fields | {"at": fields["at"].astimezone(UTC).isoformat(timespec="microseconds")}
    return hashlib.sha256(_canonical(dated).encode()).hexdigest()


def _canonical(document: dict[str, Any]) -> str:
    return json.dumps(document, ensure_ascii=False, sort_keys=True, separators=(",", ":"))
