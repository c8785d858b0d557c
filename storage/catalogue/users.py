"""The users of the pages and the hashes of their passwords; each change is in the trail."""

import secrets
from datetime import UTC, datetime

import sqlalchemy as sql

from schemas.access import Role, User
from schemas.base import Unusable
from storage.catalogue import audit_trail, database, tables
from storage.home import Home


def add(name: str, role: Role, password: str, home: Home, person: str) -> None:
    """Adds a user, or gives an existing one another role and password (as its Argon2 hash)."""
    user = User(name=name, role=role, password=password, added_at=datetime.now(UTC))
    table = tables.users
    with database.changing(home) as connection:
        connection.execute(sql.delete(table).where(table.c.name == name))
        connection.execute(sql.insert(table).values(user.model_dump()))
        audit_trail.add(connection, person, "add user", name, role=role)


def remove(name: str, home: Home, person: str) -> None:
    """Removes a user; raises Unusable for an unknown name."""
    table = tables.users
    with database.changing(home) as connection:
        gone = connection.execute(sql.delete(table).where(table.c.name == name)).rowcount
        if not gone:
            raise Unusable(f"There is no user {name!r}; `mimucal user list` names them.")
        audit_trail.add(connection, person, "remove user", name)


def users(home: Home) -> dict[str, User]:
    """Every user by name."""
    rows = database.rows(home, sql.select(tables.users).order_by(tables.users.c.name))
    return {row.name: User.model_validate(row, from_attributes=True) for row in rows}


# The sessions of the pages: begun at login, open until logout; both are in the trail.


def begin(name: str, address: str, home: Home) -> str:
    """The id of a new session of a user."""
    session, now = secrets.token_hex(16), datetime.now(UTC)
    with database.changing(home) as connection:
        row = {"id": session, "name": name, "address": address, "begun_at": now}
        connection.execute(sql.insert(tables.sessions).values(row))
        audit_trail.add(connection, name, "log in", name, at=now, address=address)
    return session


def end(session: str, address: str, home: Home) -> None:
    """Ends a session; one that is over already stays so."""
    now, table = datetime.now(UTC), tables.sessions
    over = sql.update(table).where(table.c.id == session, table.c.ended_at.is_(None))
    with database.changing(home) as connection:
        for name in connection.scalars(over.values(ended_at=now).returning(table.c.name)).all():
            audit_trail.add(connection, name, "log out", name, at=now, address=address)


def is_open(session: str, name: str, home: Home) -> bool:
    """Whether a session of this user was begun and not ended."""
    table = tables.sessions
    which = (table.c.id == session, table.c.name == name, table.c.ended_at.is_(None))
    return bool(database.rows(home, sql.select(table.c.id).where(*which)))
