"""The catalogue: which units, runs, results and certificates there are (SQLite or PostgreSQL).

Results and certificates are only added. Whoever writes and first reads does so in `changing`,
which lets one writer at a time at what it locks.
"""

import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

import sqlalchemy as sql
from sqlalchemy.pool import NullPool

from schemas.base import Unusable
from storage.catalog_tables import (
    certificates,
    metadata,
    numbers,
    reminders,
    results,
    runs,
    sources,
    units,
)
from storage.home import Home

__all__ = [
    "HEAD",
    "Busy",
    "add_new",
    "certificates",
    "changing",
    "engine",
    "metadata",
    "next_number",
    "numbers",
    "reminders",
    "results",
    "rows",
    "runs",
    "sources",
    "units",
]

HEAD = "0002"  # the newest revision in storage/migrations/versions
BUSY_S = 60  # how long a writer waits for another one
WAY_OUT = "give it as postgresql://user@host/name, or leave it out for a file in the home"
MIGRATION_LOCK = 0x6D696D75  # any number that every mimucal agrees on


class Busy(Unusable):
    """The catalogue is locked by another process or out of reach: the same again may succeed."""


def engine(home: Home) -> sql.Engine:
    """The catalogue's engine, made and migrated when needed. Safe to use after a fork."""
    made = _engine(_url(home))
    if made.dialect.name == "sqlite":
        _make_folder(home)
    with _explained(made), made.connect() as connection:
        if _revision(connection) == HEAD:
            return made
    _migrate(made)
    return made


def rows(home: Home, statement: sql.Select[Any]) -> Sequence[sql.Row[Any]]:
    """What a query finds; a home without a catalogue holds nothing, and none is made."""
    database = _url(home)
    if database.get_backend_name() == "sqlite" and not Path(database.database or "").exists():
        return []
    made = engine(home)
    with _explained(made), made.connect() as connection:
        return connection.execute(statement).all()


@contextmanager
def changing(home: Home) -> Iterator[sql.Connection]:
    """A transaction that writes: all of it or nothing."""
    made = engine(home)
    with _explained(made), _writer(made) as connection:
        yield connection


def add_new(connection: sql.Connection, table: sql.Table, **values: Any) -> bool:
    """Adds a row unless one with the same key is there, whoever writes at the same time.

    Gives whether the row is new.
    """
    insert = _dialect(connection).insert(table).values(values)
    return connection.execute(insert.on_conflict_do_nothing()).rowcount == 1


def next_number(connection: sql.Connection, prefix: str, year: int) -> int:
    """Counts up from 1 for each prefix and year; no two transactions get the same."""
    insert = _dialect(connection).insert(numbers).values(prefix=prefix, year=year, last=1)
    counted = insert.on_conflict_do_update(
        index_elements=[numbers.c.prefix, numbers.c.year], set_={"last": numbers.c.last + 1}
    )
    return int(connection.execute(counted.returning(numbers.c.last)).scalar_one())


def _dialect(connection: sql.Connection) -> Any:
    return import_module(f"sqlalchemy.dialects.{connection.dialect.name}")


def _url(home: Home) -> sql.URL:
    try:
        url = sql.make_url(home.database_url)
    except sql.exc.ArgumentError as error:
        raise Unusable(f"MIMUCAL_DATABASE is no database URL; {WAY_OUT}.") from error
    if url.drivername in ("postgresql", "postgres"):
        return url.set(drivername="postgresql+psycopg")
    if url.drivername == "postgresql+psycopg" or (url.drivername == "sqlite" and url.database):
        return url
    raise Unusable(f"MIMUCAL_DATABASE is {url!r}, which cannot be used; {WAY_OUT}.")


@lru_cache
def _engine(url: sql.URL) -> sql.Engine:
    """Connections are opened for each use: cheap, and nothing is shared between processes."""
    if url.get_backend_name() != "sqlite":
        return sql.create_engine(url, poolclass=NullPool)
    made = sql.create_engine(url, poolclass=NullPool, connect_args={"timeout": BUSY_S})
    sql.event.listen(made, "connect", _prepare_sqlite)
    sql.event.listen(made, "begin", _begin_sqlite)
    return made


def _prepare_sqlite(connection: Any, _: object) -> None:
    connection.isolation_level = None  # transactions begin where we say, DDL included
    connection.execute("PRAGMA foreign_keys = ON")
    connection.execute("PRAGMA journal_mode = WAL")


def _begin_sqlite(connection: sql.Connection) -> None:
    """A writer begins as one: what only becomes one later is refused when another was faster."""
    writes = connection.get_execution_options().get("writes")
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


@contextmanager
def _writer(made: sql.Engine) -> Iterator[sql.Connection]:
    with made.execution_options(writes=True).begin() as connection:
        yield connection


def _make_folder(home: Home) -> None:
    try:
        home.path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Unusable(
            f"{home.path} cannot be made ({error.strerror}); let MIMUCAL_HOME name a folder that "
            "can be written."
        ) from error


def _revision(connection: sql.Connection) -> str | None:
    if not sql.inspect(connection).has_table("alembic_version"):
        return None
    return connection.scalar(sql.text("SELECT version_num FROM alembic_version"))


def _migrate(made: sql.Engine) -> None:
    """Brings the catalogue to HEAD in one transaction; others wait and find it done."""
    from alembic import command, config, util

    settings = config.Config()
    settings.set_main_option("script_location", str(Path(__file__).parent / "migrations"))
    with _explained(made), _writer(made) as connection:
        if made.dialect.name == "postgresql":
            connection.execute(sql.select(sql.func.pg_advisory_xact_lock(MIGRATION_LOCK)))
        settings.attributes["connection"] = connection
        try:
            command.upgrade(settings, "head")
        except util.CommandError as error:
            raise Unusable(
                f"The catalogue {made.url!r} has revision {_revision(connection)}, which this "
                f"program (revision {HEAD}) does not know; update mimucal."
            ) from error


@contextmanager
def _explained(made: sql.Engine) -> Iterator[None]:
    """Turns a database that cannot be reached, or refuses, into a sentence."""
    try:
        yield
    except sql.exc.DatabaseError as error:
        if type(error) not in (sql.exc.OperationalError, sql.exc.DatabaseError):
            raise  # a fault of the program, not of the place
        said = str(error.orig).splitlines()[0].rstrip(".")
        raise (Busy if _may_pass(error) else Unusable)(
            f"The catalogue {made.url!r} cannot be used ({said}); see that it can be reached and "
            "written, or let MIMUCAL_HOME or MIMUCAL_DATABASE name another."
        ) from error


def _may_pass(error: sql.exc.DatabaseError) -> bool:
    """Whether waiting helps: a lock in SQLite, any trouble of operation in PostgreSQL."""
    if isinstance(error.orig, sqlite3.Error):
        return error.orig.sqlite_errorname.startswith(("SQLITE_BUSY", "SQLITE_LOCKED"))
    return isinstance(error, sql.exc.OperationalError)
