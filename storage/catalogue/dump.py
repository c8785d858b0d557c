"""The catalogue's tables as lines of JSON and back, whatever the revision and the database.

A row is a list of its columns' values, in the order of the columns' names; rows are in the order
of their keys. So the same rows are the same bytes on SQLite and PostgreSQL.
"""

import json
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, date, datetime
from itertools import islice
from typing import Any

import sqlalchemy as sql

from storage.catalogue import database
from storage.catalogue.database import engine_of, explained, url_of
from storage.home import Home

AT_ONCE = 500  # rows that are written together
VERSION = "alembic_version"


@contextmanager
def snapshot(home: Home) -> Iterator[sql.Connection | None]:
    """A transaction that sees the catalogue as it is at its beginning, while others write.

    None where there is no catalogue yet.
    """
    made = database.for_reading(home)
    if made is None:
        yield None
        return
    if made.dialect.name == "postgresql":
        made = made.execution_options(isolation_level="REPEATABLE READ")
    with explained(made), made.connect() as connection, connection.begin():
        yield connection


@contextmanager
def alone(home: Home) -> Iterator[sql.Connection]:
    """A transaction in which nobody else writes to the catalogue, whatever its revision."""
    made = engine_of(url_of(home), database.BUSY_S)
    writer = made.execution_options(writes=True)
    with explained(made), writer.connect() as connection, connection.begin():
        if made.dialect.name == "sqlite":
            connection.exec_driver_sql("PRAGMA defer_foreign_keys = ON")
        else:
            database.lock_migrations(connection)
            for table in tables_of(connection):
                connection.exec_driver_sql(f'LOCK TABLE "{table.name}" IN EXCLUSIVE MODE')
        yield connection


def tables_of(connection: sql.Connection) -> list[sql.Table]:
    """The tables as the database has them, those that others point to first."""
    found = sql.MetaData()
    found.reflect(connection)
    return [table for table in found.sorted_tables if table.name != VERSION]


def lines(connection: sql.Connection, table: sql.Table) -> Iterator[bytes]:
    """The rows of a table."""
    asked = sql.select(*(table.c[name] for name in columns_of(table)))
    asked = asked.order_by(*(_by_bytes(column, connection) for column in table.primary_key))
    for row in connection.execute(asked.execution_options(yield_per=AT_ONCE)):
        text = json.dumps([_plain(value) for value in row], ensure_ascii=False)
        yield text.encode() + b"\n"


def columns_of(table: sql.Table) -> tuple[str, ...]:
    """The names of the columns in the order of a line."""
    return tuple(sorted(table.c.keys()))


def load(
    connection: sql.Connection, table: sql.Table, columns: Sequence[str], rows: Iterable[bytes]
) -> Iterator[dict[str, Any]]:
    """Adds rows to a table whose own rows, if any, are what a migration put there.

    Gives of each row that points to another one of its table the key and where it points: `point`
    adds that when all are there.
    """
    if connection.scalar(sql.select(sql.func.count()).select_from(table)):
        connection.execute(sql.delete(table))
    own = [key.parent.name for key in table.foreign_keys if key.column.table is table]
    named, rest = [*table.primary_key.columns.keys(), *own], iter(rows)
    while values := [_row(table, columns, line) for line in islice(rest, AT_ONCE)]:
        connection.execute(sql.insert(table), [row | dict.fromkeys(own) for row in values])
        pointing = (row for row in values if any(row[name] is not None for name in own))
        yield from ({name: row[name] for name in named} for row in pointing)


def point(connection: sql.Connection, table: sql.Table, rows: Sequence[dict[str, Any]]) -> None:
    """Writes to which rows of its own table each row points."""
    for row in rows:
        key = [column == row[column.name] for column in table.primary_key]
        connection.execute(sql.update(table).where(*key).values(row))


def count_on(connection: sql.Connection, tables: Sequence[sql.Table]) -> None:
    """Advances PostgreSQL's key sequences past the rows that were added."""
    if connection.dialect.name != "postgresql":
        return
    for table in tables:
        for column in table.primary_key:
            counter = sql.func.pg_get_serial_sequence(table.name, column.name)
            if connection.scalar(sql.select(counter)) is not None:
                newest = sql.select(sql.func.max(column)).scalar_subquery()
                connection.execute(sql.select(sql.func.setval(counter, newest)))


def drop(connection: sql.Connection) -> None:
    """Removes all tables of the catalogue, and the triggers that protect the trail."""
    found = tables_of(connection)
    if connection.dialect.name == "postgresql":
        for function in connection.scalars(sql.text(TRIGGERED), {"names": [t.name for t in found]}):
            connection.exec_driver_sql(f"DROP FUNCTION {function} CASCADE")
    for table in [*reversed(found), sql.Table(VERSION, sql.MetaData())]:
        table.drop(connection)


TRIGGERED = """
SELECT DISTINCT tgfoid::regprocedure::text FROM pg_trigger
WHERE NOT tgisinternal AND tgrelid::regclass::text = ANY(:names)
"""


def _by_bytes(column: sql.Column[Any], connection: sql.Connection) -> sql.ColumnElement[Any]:
    """Text in the order of its bytes, which is SQLite's."""
    is_text = isinstance(column.type, sql.String) and connection.dialect.name == "postgresql"
    return sql.collate(column, "C") if is_text else column


def _plain(value: Any) -> Any:
    """A value as JSON has it; moments in UTC, as SQLite keeps them without saying so."""
    if isinstance(value, datetime):
        aware = value.astimezone(UTC) if value.tzinfo else value.replace(tzinfo=UTC)
        return aware.isoformat(timespec="microseconds")
    return value.isoformat() if isinstance(value, date) else value


def _row(table: sql.Table, columns: Sequence[str], line: bytes) -> dict[str, Any]:
    values = zip(columns, json.loads(line), strict=True)
    return {name: _typed(table.c[name].type, value) for name, value in values}


def _typed(kind: sql.types.TypeEngine[Any], value: Any) -> Any:
    if value is None:
        return None
    if isinstance(kind, sql.DateTime):
        return datetime.fromisoformat(value)
    return date.fromisoformat(value) if isinstance(kind, sql.Date) else value
