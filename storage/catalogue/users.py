"""The users of the pages and the hashes of their passwords; each change is in the trail."""

from datetime import UTC, datetime

import sqlalchemy as sql

from schemas.access import Role, User
from schemas.base import Unusable
from storage.catalogue import database, tables, trail
from storage.home import Home


def add(name: str, role: Role, password: str, home: Home, person: str) -> None:
    """Adds a user, or gives an existing one another role and password (as its Argon2 hash)."""
    user = User(name=name, role=role, password=password, added_at=datetime.now(UTC))
    table = tables.users
    with database.changing(home) as connection:
        connection.execute(sql.delete(table).where(table.c.name == name))
        connection.execute(sql.insert(table).values(user.model_dump()))
        trail.add(connection, person, "add user", name, role=role)


def remove(name: str, home: Home, person: str) -> None:
    """Removes a user; raises Unusable for an unknown name."""
    table = tables.users
    with database.changing(home) as connection:
        gone = connection.execute(sql.delete(table).where(table.c.name == name)).rowcount
        if not gone:
            raise Unusable(f"There is no user {name!r}; `mimucal user list` names them.")
        trail.add(connection, person, "remove user", name)


def users(home: Home) -> dict[str, User]:
    """Every user by name."""
    rows = database.rows(home, sql.select(tables.users).order_by(tables.users.c.name))
    return {row.name: User.model_validate(row, from_attributes=True) for row in rows}
