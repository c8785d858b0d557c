"""The sessions of the pages: begun at login, open until logout; both are in the trail."""

import secrets
from datetime import UTC, datetime

import sqlalchemy as sql

from storage.catalogue import database, tables, trail
from storage.home import Home


def begin(name: str, address: str, home: Home) -> str:
    """The id of a new session of a user."""
    session, now = secrets.token_hex(16), datetime.now(UTC)
    with database.changing(home) as connection:
        row = {"id": session, "name": name, "address": address, "begun_at": now}
        connection.execute(sql.insert(tables.sessions).values(row))
        trail.add(connection, name, "log in", name, at=now, address=address)
    return session


def end(session: str, address: str, home: Home) -> None:
    """Ends a session; one that is over already stays so."""
    now, table = datetime.now(UTC), tables.sessions
    over = sql.update(table).where(table.c.id == session, table.c.ended_at.is_(None))
    with database.changing(home) as connection:
        for name in connection.scalars(over.values(ended_at=now).returning(table.c.name)).all():
            trail.add(connection, name, "log out", name, at=now, address=address)


def is_open(session: str, name: str, home: Home) -> bool:
    """Whether a session of this user was begun and not ended."""
    table = tables.sessions
    which = (table.c.id == session, table.c.name == name, table.c.ended_at.is_(None))
    return bool(database.rows(home, sql.select(table.c.id).where(*which)))
