"""The catalogue of units, runs, results and certificates (SQLite or PostgreSQL).

Results and certificates are only added. A transaction that reads before it writes uses `changing`,
which admits one writer at a time to what it locks.
"""

import os
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import quote, unquote

import sqlalchemy as sql

from schemas.base import Frozen, Unusable
from schemas.secret_urls import shown
from storage.catalogue.connection import engine_of, explained, url_of
from storage.catalogue.tables import results, units
from storage.home import RESTORING, Home
from storage.whole_files import make_folder

FIRST = "0013"  # the oldest revision in storage/catalogue/migrations/versions
HEAD = "0014"  # the newest
BUSY_S = 60  # how long a writer waits for another one
MIGRATION_LOCK = 0x6D696D75  # an arbitrary number, the same in every mimucal

Model = TypeVar("Model", bound=Frozen)


def rows(home: Home, statement: sql.Select[Any]) -> Sequence[sql.Row[Any]]:
    """The rows of a query; a home without a catalogue has none, and none is created."""
    made = for_reading(home)
    if made is None:
        return []
    with explained(made), _connected(made) as connection:
        return connection.execute(statement).all()


def with_units(
    home: Home,
    model: type[Model],
    table: sql.Table,
    which: sql.ColumnElement[bool],
    moment: sql.ColumnElement[Any],
) -> list[Model]:
    """Rows of a table with their units, ordered by a moment, as instances of a model."""
    found = rows(home, of_units(model, table, which).order_by(moment, *table.primary_key))
    return [model.model_validate(row, from_attributes=True) for row in found]


def of_units(
    model: type[Model], table: sql.Table, which: sql.ColumnElement[bool]
) -> sql.Select[Any]:
    """The query for the fields of a model from a table joined with its units."""
    columns = {column.name: column for column in (*units.c, *table.c)}
    asked = sql.select(*(columns[name] for name in model.model_fields))
    return asked.join_from(table, units).where(which)


@cache  # the same condition for every query
def newest_results() -> sql.ColumnElement[bool]:
    """The condition on `results` that no other result supersedes it."""
    newer = results.alias("newer")
    return ~sql.exists().where(newer.c.supersedes == results.c.id)


def for_reading(home: Home) -> sql.Engine | None:
    """The engine for reading, None if there is no catalogue; a read-only file is not changed."""
    if home.path.exists() and not home.path.is_dir():
        raise Unusable(f"{home.path} is not a folder; set MIMUCAL_HOME to the folder of the home.")
    _check_whole(home)
    url = url_of(home)
    if url.get_backend_name() != "sqlite":
        return engine_of(url, BUSY_S)
    file = Path(url.database or "")
    try:
        if not file.exists():
            return None
    except OSError as error:
        raise Unusable(f"{file} cannot be read ({error.strerror}); grant access to it.") from error
    if _is_lost(file, home):
        raise Unusable(
            f"{file} is empty, but there are raw recordings in {home.raw}; bring it back from a "
            "backup, or move it away and import those recordings again."
        )
    if os.access(file, os.W_OK) and os.access(file.parent, os.W_OK):
        return engine_of(url, BUSY_S)
    return _read_only(file)


def _check_whole(home: Home) -> None:
    """Raises Unusable for a home into which a backup was put in part."""
    if (home.path / RESTORING).exists():
        raise Unusable(
            f"{home.path} is being restored, or a restore was broken off: wait for its end, or run "
            "the same `mimucal restore` again."
        )


def _is_lost(file: Path, home: Home) -> bool:
    """Whether a catalogue is empty although there are recordings; a new one is filled at once."""
    for pause in (0.0, 0.5):
        time.sleep(pause)
        if file.stat().st_size:
            return False
    return any(home.raw.glob("*.mcap"))


def _read_only(file: Path) -> sql.Engine:
    """The engine of a catalogue that cannot be written.

    SQLite wants to make files beside a catalogue in WAL mode unless it is immutable, and so it
    is as long as no writer left a log.
    """
    query = {"mode": "ro", "uri": "true"}
    if not Path(f"{file}-wal").exists():
        query["immutable"] = "1"
    url = sql.URL.create("sqlite", database=f"file:{quote(str(file))}", query=query)
    return engine_of(url, BUSY_S)


@contextmanager
def changing(home: Home) -> Iterator[sql.Connection]:
    """A transaction that writes: all of it or nothing."""
    _check_whole(home)
    made = engine_of(url_of(home), BUSY_S)
    if made.dialect.name == "sqlite":
        try:
            make_folder(home.path)
        except OSError as error:
            raise Unusable(
                f"{home.path} cannot be made ({error.strerror}); let MIMUCAL_HOME name a folder "
                "that can be written."
            ) from error
        file = Path(made.url.database or "")
        # A catalogue contains password hashes: a new one is not world-readable, nor are its logs.
        # SQLite would fail on the same errors, with a better message.
        with suppress(OSError):
            rights = 0o600 | 0o060 & file.parent.stat().st_mode
            opened = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            os.fchmod(opened, rights)
            os.close(opened)
    writer = made.execution_options(writes=True)
    with explained(made), _connected(writer) as connection, connection.begin():
        yield connection


def add_new(connection: sql.Connection, table: sql.Table, **values: Any) -> bool:
    """Adds a row unless one with the same key exists, also when others write at the same time.

    Returns whether the row is new.
    """
    insert = dialect(connection).insert(table).values(values).on_conflict_do_nothing()
    # Without this option SQLAlchemy 2.1 keeps no count of inserted rows on PostgreSQL: -1 always.
    return connection.execute(insert.execution_options(preserve_rowcount=True)).rowcount == 1


def add_all_new(
    connection: sql.Connection, table: sql.Table, values: Sequence[dict[str, Any]]
) -> None:
    """Adds rows with the same columns, except those whose key exists."""
    if values:
        insert = dialect(connection).insert(table).on_conflict_do_nothing()
        connection.execute(insert, values)


def dialect(connection: sql.Connection) -> Any:
    """SQLAlchemy's module of the database, with its `insert` that knows conflicts."""
    return import_module(f"sqlalchemy.dialects.{connection.dialect.name}")


@contextmanager
def _connected(made: sql.Engine) -> Iterator[sql.Connection]:
    """A connection to a catalogue at HEAD, which is made if there is none; in no transaction.

    Raises Unusable for another revision.
    """
    connection = made.connect()
    try:
        if connection.info.get("revision") != HEAD:  # not known of this one of the pool
            revision = revision_of(connection)
            connection.rollback()
            check_revision(made, revision)
            if revision is None:
                connection.close()
                _migrate(made)
                connection = made.connect()
            connection.info["revision"] = HEAD
        yield connection
    finally:
        connection.close()


def check_revision(made: sql.Engine, revision: str | None) -> None:
    """Raises Unusable for a catalogue of another revision than HEAD; a new one has none.

    Nothing but `mimucal upgrade` changes a catalogue that is there: programs of the version that
    made it go on using it.
    """
    where, is_read_only = shown(repr(made.url)), "mode" in made.url.query
    if is_read_only:
        where = unquote(str(made.url.database).removeprefix("file:"))
    if revision is not None and revision > HEAD:
        raise Unusable(
            f"The catalogue {where} has revision {revision}, which this program (revision {HEAD}) "
            "does not know; update mimucal."
        )
    check_known(revision, where)
    if revision != HEAD and is_read_only:
        raise Unusable(
            f"{where} has revision {revision}, this program needs {HEAD}, and it cannot be "
            "written; copy the home to where it can be written."
        )
    if revision is not None and revision != HEAD:
        raise Unusable(
            f"The catalogue {where} has revision {revision}, this program needs {HEAD}: run "
            "`mimucal upgrade`, or go on with the version of mimucal that made it."
        )


def check_known(revision: str | None, where: str) -> None:
    """Raises Unusable for a revision of before FIRST."""
    if revision is not None and revision < FIRST:
        raise Unusable(
            f"{where} has revision {revision}, of a development version before release 0.2.0: "
            f"upgrade it to {FIRST} by the last of these, of 28 November 2026, first."
        )


def revision_of(connection: sql.Connection) -> str | None:
    """The revision of a catalogue; None: it has no tables yet."""
    if not sql.inspect(connection).has_table("alembic_version"):
        return None
    return connection.scalar(sql.text("SELECT version_num FROM alembic_version"))


def _migrate(made: sql.Engine) -> None:
    """Makes the tables in one transaction; others wait and find it done."""
    with explained(made), made.execution_options(writes=True).begin() as connection:
        if made.dialect.name == "postgresql":
            lock_migrations(connection)
        bring_to(connection, HEAD)


def lock_migrations(connection: sql.Connection) -> None:
    """Lets one transaction at a time of a PostgreSQL change tables."""
    connection.execute(sql.select(sql.func.pg_advisory_xact_lock(MIGRATION_LOCK)))


def bring_to(connection: sql.Connection, revision: str) -> None:
    """Migrates the catalogue of a transaction to a revision, from none or from an older one."""
    from alembic import command, config

    settings = config.Config()
    settings.set_main_option("script_location", str(Path(__file__).parent / "migrations"))
    settings.attributes["connection"] = connection
    command.upgrade(settings, revision)
