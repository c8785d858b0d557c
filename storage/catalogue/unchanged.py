"""Caches answers for as long as nothing is written to the catalogue."""

from collections.abc import Callable, Hashable
from functools import lru_cache, wraps
from pathlib import Path
from typing import Any, TypeVar, cast

import sqlalchemy as sql

from storage.catalogue import database
from storage.catalogue.database import url_of
from storage.home import Home

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
    return url, database.rows(home, snapshot)[0][0]


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


def while_unchanged(most: int) -> Callable[[Function], Function]:
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
