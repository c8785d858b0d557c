"""A catalogue of an earlier version is upgraded on request, after a check, with a way back."""

import shutil
import tarfile
from pathlib import Path

import pytest
import sqlalchemy as sql

from schemas.base import Unusable
from storage import backup as upgrading
from storage.backup import Objects, back, back_up, confirm, is_needed, rehearse, restore, upgrade
from storage.catalogue import database, dump, runs
from storage.home import Home
from storage.stations import one_run_on, write_status
from storage.verify import verify
from tests import postgres
from tests.keep import take_number
from tests.storage.test_stations import status

OLD = Path(__file__).parent.parent / "homes" / "0013.tar.xz"


def silent(_: int, __: int) -> None:
    pass


def contents(home: Home) -> dict[str, list[bytes]]:
    """Every table of the catalogue, of whatever revision, and its revision."""
    with dump.snapshot(home) as connection:
        assert connection is not None
        found = {t.name: list(dump.lines(connection, t)) for t in dump.tables_of(connection)}
        return found | {"revision": [str(database.revision_of(connection)).encode()]}


@pytest.fixture(params=["sqlite", "postgresql"])
def earlier(request, fresh, tmp_path, server, monkeypatch) -> Home:
    """A home that an earlier version left, in either database."""
    with tarfile.open(OLD) as archive:
        archive.extractall(fresh.path, filter="data")
    if request.param == "postgresql":
        back_up(fresh, tmp_path / "backups", "1", silent)
        shutil.rmtree(fresh.path)
        monkeypatch.setenv("MIMUCAL_DATABASE", postgres.empty_database(server))
        revision = Objects(tmp_path / "backups").manifest().revision
        with monkeypatch.context() as patched:
            patched.setattr(database, "HEAD", revision)
            restore(tmp_path / "backups", None, fresh, silent)
    return fresh


def test_reading_and_writing_an_older_catalogue_ask_for_the_upgrade_and_change_nothing(earlier):
    before = contents(earlier)
    for use in (runs.all_runs, take_number, verify):
        with pytest.raises(Unusable, match="`mimucal upgrade`"):
            use(earlier)
    assert contents(earlier) == before
    assert is_needed(earlier)


def test_upgrade_checks_on_a_copy_and_its_way_back_leads_to_what_was(earlier):
    before = contents(earlier)
    assert rehearse(earlier, "1", silent) == []
    assert contents(earlier) == before
    assert not (earlier.path / "upgrade").exists()
    assert upgrade(earlier, "1") == before["revision"][0].decode()
    assert not is_needed(earlier)
    assert verify(earlier)[1] == []
    take_number(earlier)  # which stands in `series`
    revision, newer = back(earlier, "1")
    assert (revision, contents(earlier)) == (before["revision"][0].decode(), before)
    assert newer
    assert (earlier.path / "upgrade-left").is_dir()
    assert rehearse(earlier, "1", silent) == []  # and forth again
    upgrade(earlier, "1")
    confirm(earlier)
    assert verify(earlier)[1] == []
    with pytest.raises(Unusable, match="no upgrade to go back"):
        back(earlier, "1")


def test_an_upgrade_that_fails_leaves_everything_as_it_was(earlier, monkeypatch):
    before = contents(earlier)
    real = database.bring_to

    def fails(connection: sql.Connection, revision: str) -> None:
        real(connection, revision)
        raise RuntimeError

    monkeypatch.setattr(database, "bring_to", fails)
    with pytest.raises(RuntimeError):
        upgrade(earlier, "1")
    assert contents(earlier) == before
    with pytest.raises(Unusable, match="no upgrade to go back"):
        back(earlier, "1")


@pytest.fixture
def of_sqlite(fresh) -> Home:
    with tarfile.open(OLD) as archive:
        archive.extractall(fresh.path, filter="data")
    return fresh


def test_a_damaged_store_is_not_upgraded(of_sqlite):
    next(of_sqlite.raw.iterdir()).unlink()
    before = contents(of_sqlite)
    faults = rehearse(of_sqlite, "1", silent)
    assert [fault for fault in faults if "raw" in fault.what]
    assert contents(of_sqlite) == before


def test_no_upgrade_while_a_run_goes_on_or_without_room_or_over_an_unconfirmed_one(
    of_sqlite, monkeypatch
):
    now = status("measuring")
    with one_run_on(now.station, of_sqlite):
        write_status(now, of_sqlite)
        with pytest.raises(Unusable, match=f"going on at station {now.station}"):
            rehearse(of_sqlite, "1", silent)
    monkeypatch.setattr(upgrading, "LEAST_ROOM", 2**60)
    with pytest.raises(Unusable, match="make room"):
        rehearse(of_sqlite, "1", silent)
    upgrade(of_sqlite, "1")
    with pytest.raises(Unusable, match="--confirm"):
        rehearse(of_sqlite, "1", silent)


def test_a_home_at_this_revision_needs_none(fresh):
    assert not is_needed(fresh)
    take_number(fresh)
    assert not is_needed(fresh)
    for way in (lambda: back(fresh, "1"), lambda: confirm(fresh)):
        with pytest.raises(Unusable, match="There is no upgrade"):
            way()


def test_a_backup_of_an_older_catalogue_is_restored_as_this_one(of_sqlite, tmp_path):
    back_up(of_sqlite, tmp_path / "backups", "1", silent)
    other = Home(tmp_path / "other")
    restore(tmp_path / "backups", None, other, silent)
    assert not is_needed(other)
    assert verify(other)[1] == []
