"""The catalogue of units, runs, results and certificates (SQLite or PostgreSQL).

Results and certificates are only added. A transaction that reads before it writes uses `changing`,
which admits one writer at a time to what it locks.
"""

import os
import sqlite3
import threading
import time
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache, lru_cache, partial, wraps
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar, cast
from urllib.parse import quote, unquote

import sqlalchemy as sql
from sqlalchemy.pool import NullPool, QueuePool

from schemas.base import Frozen, Unusable, escaped, shown
from schemas.text import Message
from storage.catalogue.tables import results, units
from storage.home import RESTORING, Home
from storage.whole_files import make_folder

# Connections to the catalogue's database, and its errors as sentences.

SWITCH_PAUSE_S = 0.02
WAY_OUT = "give it as postgresql://user@host/name, or leave it out for a file in the home"


class Busy(Unusable):
    """The catalogue is locked by another process or out of reach; trying again may succeed."""


def url_of(home: Home) -> sql.URL:
    """The URL of the catalogue; raises Unusable for an unsupported kind of database."""
    try:
        url = sql.make_url(escaped(home.database_url))
    except sql.exc.ArgumentError as error:
        raise Unusable(f"MIMUCAL_DATABASE is not a database URL; {WAY_OUT}.") from error
    if url.drivername in ("postgresql", "postgres"):
        return url.set(drivername="postgresql+psycopg")
    if url.drivername == "postgresql+psycopg" or (url.drivername == "sqlite" and url.database):
        return url
    raise Unusable(
        f"MIMUCAL_DATABASE is {shown(home.database_url)}, which cannot be used; {WAY_OUT}."
    )


def name_of(home: Home) -> str:
    """The URL of the catalogue, without a password."""
    return shown(url_of(home).render_as_string(hide_password=True))


_of_thread = threading.local()  # `once`: whether it keeps its file open


@contextmanager
def opened_once(home: Home, busy_s: float) -> Iterator[None]:
    """Within it, and in its thread, a file is opened once instead of for each use. Do not fork
    within it: the child would share the connection.
    """
    url = url_of(home)
    _of_thread.once = True
    try:
        yield
    finally:
        if url.get_backend_name() == "sqlite":
            engine_of(url, busy_s).dispose()
        _of_thread.once = False


def engine_of(url: sql.URL, busy_s: float) -> sql.Engine:
    """The engine of a database; a writer in SQLite waits `busy_s` for another one.

    A file is opened for each use, but in `opened_once`. A server starts a process for each
    connection, so that one is kept, tried before it is used again, and left to its parent by a
    forked process.
    """
    if url.get_backend_name() == "sqlite":
        # A pool for each thread, so that one can close its connection while others read.
        once = getattr(_of_thread, "once", False) and "mode" not in url.query
        return _engine_of_file(url, busy_s, threading.get_ident() if once else None)
    return _engine_of_server(url)


@lru_cache
def _engine_of_server(url: sql.URL) -> sql.Engine:
    kept = sql.create_engine(url, pool_size=1, max_overflow=-1, pool_pre_ping=True)
    os.register_at_fork(after_in_child=partial(kept.dispose, close=False))
    return kept


@lru_cache
def _engine_of_file(url: sql.URL, busy_s: float, thread: int | None) -> sql.Engine:
    """thread: id of the thread that keeps its connection open; None opens one for each use."""
    pool = NullPool if thread is None else QueuePool
    made = sql.create_engine(url, poolclass=pool, connect_args={"timeout": busy_s})
    sql.event.listen(made, "connect", _prepare_sqlite)
    if "mode" not in url.query:
        sql.event.listen(made, "connect", partial(_log_ahead, busy_s=busy_s))
    sql.event.listen(made, "begin", _begin_sqlite)
    return made


def _prepare_sqlite(connection: Any, _: object) -> None:
    connection.isolation_level = None  # transactions begin where we say, DDL included
    connection.execute("PRAGMA foreign_keys = ON")


def _log_ahead(connection: Any, _: object, *, busy_s: float) -> None:
    """Switches the file to a write-ahead log, which it then keeps.

    Where two processes switch a fresh file at once, SQLite refuses one of them without waiting.
    """
    end_s = time.monotonic() + busy_s
    while True:
        try:
            connection.execute("PRAGMA journal_mode = WAL")
        except sqlite3.OperationalError as error:
            if not _is_locked(error) or time.monotonic() > end_s:
                raise
            time.sleep(SWITCH_PAUSE_S)
        else:
            return


def _begin_sqlite(connection: sql.Connection) -> None:
    """Begins writing transactions as such: upgrading one later fails if another was faster."""
    writes = connection.get_execution_options().get("writes")
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


@contextmanager
def explained(made: sql.Engine) -> Iterator[None]:
    """Turns a database that cannot be reached, or refuses, into a sentence."""
    try:
        yield
    except sql.exc.DatabaseError as error:
        if type(error) not in (sql.exc.OperationalError, sql.exc.DatabaseError):
            raise  # an error of the program, not of the database
        reason = str(error.orig).splitlines()[0].rstrip(".")
        raise (Busy if _is_transient(error) else Unusable)(
            f"The catalogue {shown(repr(made.url))} cannot be used ({reason}); see that it can be "
            "reached and written and that its disk has room, or let MIMUCAL_HOME or "
            "MIMUCAL_DATABASE name another.",
            Message("station-cause.catalogue"),
        ) from error


def _is_transient(error: sql.exc.DatabaseError) -> bool:
    """Whether the error is transient: a lock in SQLite, any operational error in PostgreSQL."""
    if isinstance(error.orig, sqlite3.Error):
        return _is_locked(error.orig)
    return isinstance(error, sql.exc.OperationalError)


def _is_locked(error: sqlite3.Error) -> bool:
    """Whether another process holds the file; one that cannot be written stays so."""
    return error.sqlite_errorname.startswith(("SQLITE_BUSY", "SQLITE_LOCKED"))


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


# Caches answers for as long as nothing is written to the catalogue.


INDEX_HEADER = 48  # bytes

Function = TypeVar("Function", bound=Callable[..., Any])


def version(home: Home) -> Hashable:
    """A value that changes with each commit; raises Busy if the database does not answer.

    PostgreSQL: its snapshot, which names the visible transactions. SQLite: size and time of its
    file and of the write-ahead log, and the header of that log's index, which counts transactions
    (SQLite, WAL-mode file format, 2.1), since two may fall within one tick of the clock.
    """
    url = url_of(home)
    if url.get_backend_name() == "sqlite":
        file = url.database or ""
        log = _stamp(Path(f"{file}-wal"))
        return file, _stamp(Path(file)), log, log and _index_header(Path(f"{file}-shm"))
    snapshot = sql.select(sql.cast(sql.func.pg_current_snapshot(), sql.Text))
    return url, rows(home, snapshot)[0][0]


def _stamp(file: Path) -> tuple[int, ...] | None:
    """None for a missing or empty file, such as the log that a reader leaves."""
    try:
        found = file.stat()
    except OSError:
        return None
    return (found.st_ino, found.st_size, found.st_mtime_ns) if found.st_size else None


def _index_header(file: Path) -> bytes | None:
    try:
        with file.open("rb") as index:
            return index.read(INDEX_HEADER)
    except OSError:
        return None


def cached_until_commit(most: int) -> Callable[[Function], Function]:
    """Caches the last `most` answers of a function that reads only the catalogue.

    Its last argument is the home; all are hashable. Answers must not be modified.
    """

    def decorate(function: Function) -> Function:
        @lru_cache(most)
        def kept(_: Hashable, *asked: Hashable) -> Any:
            return function(*asked)

        @wraps(function)
        def ask(*asked: Hashable) -> Any:
            return kept(version(cast(Home, asked[-1])), *asked)

        return cast(Function, ask)

    return decorate
