"""What the migrations make of a fresh catalogue, kept: every home of a test begins with it."""

import sqlite3
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import sqlalchemy as sql

from storage.catalogue import database
from storage.catalogue.database import engine_of, explained, url_of
from storage.home import Home

every_revision = database._migrate


def as_migrated(made: sql.Engine) -> None:
    """Does as `every_revision`; an empty file is given the tables at once, in one transaction."""
    if made.dialect.name == "sqlite":
        with explained(made), made.execution_options(writes=True).begin() as connection:
            if not sql.inspect(connection).get_table_names():
                for statement in statements():
                    connection.exec_driver_sql(statement)
                return
    every_revision(made)


@cache
def statements() -> tuple[str, ...]:
    """The statements that make a migrated catalogue."""
    with TemporaryDirectory() as folder:
        home = Home(Path(folder))
        every_revision(engine_of(url_of(home), database.BUSY_S))
        return dump(home)


def dump(home: Home) -> tuple[str, ...]:
    """A catalogue in SQLite as statements, without those around the transaction."""
    opened = sqlite3.connect(home.path / "catalog.sqlite")
    try:
        return tuple(opened.iterdump())[1:-1]
    finally:
        opened.close()
