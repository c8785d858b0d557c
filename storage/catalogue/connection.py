"""Connections to the catalogue's database, and its errors as sentences."""

import os
import sqlite3
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache, partial
from typing import Any

import sqlalchemy as sql
from sqlalchemy.pool import NullPool, QueuePool

from schemas.base import Unusable
from schemas.secret_urls import escaped, shown
from schemas.text import Message
from storage.home import Home

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
        raise (Busy if _may_pass(error) else Unusable)(
            f"The catalogue {shown(repr(made.url))} cannot be used ({reason}); see that it can be "
            "reached and written and that its disk has room, or let MIMUCAL_HOME or "
            "MIMUCAL_DATABASE name another.",
            Message("station-cause.catalogue"),
        ) from error


def _may_pass(error: sql.exc.DatabaseError) -> bool:
    """Whether the error is transient: a lock in SQLite, any operational error in PostgreSQL."""
    if isinstance(error.orig, sqlite3.Error):
        return _is_locked(error.orig)
    return isinstance(error, sql.exc.OperationalError)


def _is_locked(error: sqlite3.Error) -> bool:
    """Whether another process holds the file; one that cannot be written stays so."""
    return error.sqlite_errorname.startswith(("SQLITE_BUSY", "SQLITE_LOCKED"))
