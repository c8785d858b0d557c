"""The catalogue on SQLite: made when needed, migrated once, safe with several writers."""

import sqlite3
from pathlib import Path

import pytest
import sqlalchemy as sql
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory

from schemas.base import Unusable
from storage.catalogue import certificates, database, runs, tables
from storage.catalogue import database as connections
from storage.catalogue.database import Busy, engine_of, url_of
from storage.home import Home
from tests.keep import take_number
from tests.migrated import as_migrated, dump, every_revision

TAKE_NUMBER = "from tests.keep import take_number\nnumber = take_number(home)"


@pytest.fixture(autouse=True)
def _every_revision(monkeypatch) -> None:
    monkeypatch.setattr(database, "_migrate", every_revision)


def test_the_tests_of_everything_else_begin_with_what_the_migrations_make(
    fresh, tmp_path, monkeypatch
):
    with database.changing(fresh):
        pass
    monkeypatch.setattr(database, "_migrate", as_migrated)
    other = Home(tmp_path / "other")
    with database.changing(other):
        pass
    assert sorted(dump(other)) == sorted(dump(fresh))


def test_migrations_and_tables_do_not_drift(either):
    with database.changing(either) as connection:
        context = MigrationContext.configure(connection, opts={"compare_server_default": True})
        assert compare_metadata(context, tables.metadata) == []


def test_head_is_the_newest_migration():
    settings = Config()
    settings.set_main_option("script_location", str(Path(database.__file__).parent / "migrations"))
    assert ScriptDirectory.from_config(settings).get_heads() == [database.HEAD]


def test_second_opening_needs_no_alembic(fresh, at_once):
    script = f"{TAKE_NUMBER}\nprint('alembic' in sys.modules)"
    assert at_once(script, fresh, processes=1) == ["False\n"]


def test_catalogue_keeps_readers_going_and_foreign_keys_honest(fresh):
    with database.changing(fresh) as connection:
        assert connection.exec_driver_sql("PRAGMA journal_mode").scalar() == "wal"
        assert connection.exec_driver_sql("PRAGMA foreign_keys").scalar() == 1
        assert connection.exec_driver_sql("PRAGMA busy_timeout").scalar() == 60_000


def test_reader_sees_the_old_state_while_a_writer_works(fresh):
    with database.changing(fresh) as connection:
        row = {"manufacturer": "M", "model": "U", "serial": "1"}
        connection.execute(sql.insert(tables.units).values(row))
        assert database.rows(fresh, sql.select(tables.units)) == []
    assert len(database.rows(fresh, sql.select(tables.units))) == 1


def test_change_that_fails_leaves_nothing(fresh):
    def change() -> None:
        with database.changing(fresh) as connection:
            certificates.next_number(connection, "MIMU-2026-{serial:04d}")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        change()
    assert take_number(fresh) == "MIMU-2026-0001"


def test_row_that_points_nowhere_is_refused(fresh):
    with (
        pytest.raises(sql.exc.IntegrityError),
        database.changing(fresh) as connection,
    ):
        database.add_new(connection, tables.sources, fingerprint="f", run="none", path="p")


def test_processes_that_open_a_fresh_home_at_once_make_one_catalogue(fresh, at_once):
    script = f"{TAKE_NUMBER}\nprint(len(number))"
    printed = at_once(script, fresh, processes=4, has_catalogue=False)
    assert printed == ["14\n"] * 4


class Refusing:
    """A connection that refuses twice, for a reason by SQLite's name."""

    def __init__(self, reason: str) -> None:
        self.asked, self.reason = 0, reason

    def execute(self, _: str) -> None:
        self.asked += 1
        if self.asked < 3:
            error = sqlite3.OperationalError("refused")
            error.sqlite_errorname = self.reason
            raise error


def test_switching_a_fresh_file_to_a_log_is_tried_again_when_sqlite_refuses_at_once():
    locked = Refusing("SQLITE_BUSY")
    connections._log_ahead(locked, None, busy_s=60.0)
    assert locked.asked == 3
    with pytest.raises(sqlite3.OperationalError):
        connections._log_ahead(Refusing("SQLITE_BUSY"), None, busy_s=0.0)


def test_a_file_that_cannot_be_opened_is_not_waited_for():
    closed = Refusing("SQLITE_CANTOPEN")
    with pytest.raises(sqlite3.OperationalError):
        connections._log_ahead(closed, None, busy_s=60.0)
    assert closed.asked == 1


def test_catalogue_of_a_newer_program_is_refused(either):
    with database.changing(either) as connection:
        connection.execute(sql.text("UPDATE alembic_version SET version_num = '9999'"))
    engine_of(url_of(either), database.BUSY_S).dispose()  # as in another process
    with pytest.raises(Unusable, match=r"revision 9999.*update mimucal"):
        runs.all_runs(either)


def test_catalogue_that_is_no_database_is_one_sentence(fresh):
    fresh.path.mkdir()
    (fresh.path / "catalog.sqlite").write_text("not a database, but longer than a header " * 9)
    with pytest.raises(Unusable, match=r"catalog\.sqlite cannot be used \(file is not a database"):
        runs.all_runs(fresh)


@pytest.mark.parametrize("url", ["mysql://lab@host/db", "sqlite://", "nonsense"])
def test_database_of_another_kind_is_refused(fresh, url, monkeypatch):
    monkeypatch.setenv("MIMUCAL_DATABASE", url)
    with pytest.raises(Unusable, match=r"MIMUCAL_DATABASE.*postgresql://"):
        runs.all_runs(fresh)


def test_password_of_the_database_is_not_printed(fresh, monkeypatch):
    monkeypatch.setenv("MIMUCAL_DATABASE", "postgresql://lab:secret@127.0.0.1:1/mimucal")
    with pytest.raises(Unusable, match=r"127\.0\.0\.1") as caught:
        runs.all_runs(fresh)
    assert "secret" not in str(caught.value)


def test_locked_catalogue_is_busy_and_a_damaged_one_is_not(fresh, monkeypatch):
    monkeypatch.setattr(database, "BUSY_S", 0.1)
    with database.changing(fresh):
        pass
    other = sqlite3.connect(fresh.path / "catalog.sqlite")
    other.execute("BEGIN IMMEDIATE")
    with pytest.raises(Busy, match="locked"):
        take_number(fresh)
    other.close()
    for file in fresh.path.glob("catalog.sqlite*"):
        file.unlink()
    (fresh.path / "catalog.sqlite").write_bytes(b"no database" * 100)
    with pytest.raises(Unusable) as refusal:
        take_number(fresh)
    assert not isinstance(refusal.value, Busy)
