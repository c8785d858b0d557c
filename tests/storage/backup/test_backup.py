"""A backup restored onto an empty home is the home that it was made of, or is refused."""

import json
import signal
import subprocess
import sys
from collections.abc import Callable

import pytest
import sqlalchemy as sql

from schemas.base import Unusable
from storage import backup as backing_up
from storage.backup import Objects, back_up, restore
from storage.catalogue import audit_trail, database, runs, tables
from storage.catalogue.dump import lines, snapshot, tables_of
from storage.home import RESTORING, Home
from storage.verify import verify
from tests import postgres
from tests.keep import take_number
from tests.storage.small import small

Fill = Callable[[Home], Home]


def silent(_: int, __: int) -> None:
    pass


def rows(home: Home) -> dict[str, list[bytes]]:
    """Every row of the catalogue as it is kept."""
    with snapshot(home) as connection:
        assert connection is not None
        return {table.name: list(lines(connection, table)) for table in tables_of(connection)}


def files(home: Home) -> dict[str, tuple[bytes, int]]:
    """The content and mode of every file that a backup has."""
    found = {}
    for path in sorted(home.path.rglob("*")):
        name = str(path.relative_to(home.path))
        if path.is_file() and not name.startswith(("catalog.sqlite", "columns/", "locks/")):
            found[name] = (path.read_bytes(), path.stat().st_mode)
    return found


@pytest.mark.parametrize("databases", [("sqlite", "postgresql"), ("postgresql", "sqlite")],
                         ids=" to ".join)  # fmt: skip
def test_a_home_comes_back_whole_from_either_database_to_either(
    databases, fresh, filled, backups, tmp_path,
    server, monkeypatch
):  # fmt: skip
    def use(kind: str) -> None:
        monkeypatch.delenv("MIMUCAL_DATABASE", raising=False)
        if kind == "postgresql":
            monkeypatch.setenv("MIMUCAL_DATABASE", postgres.empty_database(server))

    use(databases[0])
    filled(fresh)
    checked = verify(fresh)
    before = rows(fresh), files(fresh)
    name, manifest = back_up(fresh, backups, "1", silent)
    assert manifest.missing == ()
    use(databases[1])
    other = Home(tmp_path / "other")
    assert restore(backups, None, other, silent)[0] == name
    assert (rows(other), files(other)) == before
    found, faults = verify(other)
    assert (found, faults) == (checked[0] - 2, [])  # columns are made again when needed
    with database.changing(other) as connection:  # keys go on behind those that came
        unit = {"manufacturer": "M", "model": "U", "serial": "new"}
        connection.execute(sql.insert(tables.units).values(unit))
        audit_trail.add(connection, "Li", "add user", "Zhao")
    assert list(audit_trail.faults(other)) == []


def test_a_second_backup_copies_only_what_is_new(fresh, filled, backups):
    filled(fresh)
    first, _ = back_up(fresh, backups, "1", silent)
    before = {path: path.stat().st_mtime_ns for path in (backups / "objects").rglob("*")}
    run = runs.add(small(2.0, serial="3"), fresh)[0]
    second, manifest = back_up(fresh, backups, "1", silent)
    after = {path for path in (backups / "objects").rglob("*") if path.is_file()}
    recordings = [each.name for each in manifest.files if each.name.startswith("raw/")]
    assert f"raw/{run.digest}.mcap" in recordings
    new = after - before.keys()
    assert len(new) == 3  # the recording, and the tables `units` and `runs`
    assert all(path.stat().st_mtime_ns == then for path, then in before.items() if path.is_file())
    assert Objects(backups).names() == [first, second]


def test_what_is_written_meanwhile_is_in_the_next_backup_and_never_half_in_this_one(
    fresh, filled, backups, tmp_path, monkeypatch
):
    filled(fresh)
    real = backing_up.copied
    before = rows(fresh)

    def copied(connection: sql.Connection, objects: Objects) -> object:
        kept = real(connection, objects)
        runs.add(small(3.0, serial="late"), fresh)
        return kept

    monkeypatch.setattr(backing_up, "copied", copied)
    back_up(fresh, backups, "1", silent)
    other = Home(tmp_path / "other")
    restore(backups, None, other, silent)
    assert rows(other) == before
    assert verify(other)[1] == []
    assert len(runs.all_runs(fresh)) == len(runs.all_runs(other)) + 1


def test_what_is_missing_from_the_home_is_named(fresh, filled, backups):
    filled(fresh)
    lost = next(fresh.raw.iterdir())
    lost.unlink()
    _, manifest = back_up(fresh, backups, "1", silent)
    assert manifest.missing == (f"raw/{lost.name}",)


BACK_UP = """
import sys, time
from pathlib import Path
from storage.backup import back_up
from storage.home import Home
def slow(done, of):
    print(done, flush=True)
    time.sleep(0.3)
back_up(Home(Path(sys.argv[1])), Path(sys.argv[2]), "1", slow)
"""


def test_a_backup_that_was_killed_is_never_taken_for_whole(fresh, filled, backups, tmp_path):
    filled(fresh)
    command = [sys.executable, "-c", BACK_UP, str(fresh.path), str(backups)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "1\n"
        process.send_signal(signal.SIGKILL)
    assert list((backups / "objects").rglob("*"))
    with pytest.raises(Unusable, match="no whole backup"):
        restore(backups, None, Home(tmp_path / "other"), silent)
    assert not (tmp_path / "other").exists()
    (backups / "objects" / ".new.part").write_bytes(b"half")
    back_up(fresh, backups, "1", silent)
    assert not (backups / "objects" / ".new.part").exists()
    restore(backups, None, Home(tmp_path / "other"), silent)
    assert rows(Home(tmp_path / "other")) == rows(fresh)


def test_a_restore_that_was_broken_off_is_no_home_until_it_is_gone_on_with(
    fresh, filled, backups, tmp_path, monkeypatch
):
    filled(fresh)
    back_up(fresh, backups, "1", silent)
    other = Home(tmp_path / "other")

    def ends(done: int, of: int) -> None:
        if done == of:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        restore(backups, None, other, ends)
    for use in (runs.all_runs, take_number):
        with pytest.raises(Unusable, match="mimucal restore"):
            use(other)
    restore(backups, None, other, silent)
    assert not (other.path / RESTORING).exists()
    assert rows(other) == rows(fresh)


def test_a_home_database_or_store_that_holds_something_is_not_restored_onto(
    fresh, filled, backups, tmp_path, server,
    monkeypatch
):  # fmt: skip
    filled(fresh)
    back_up(fresh, backups, "1", silent)
    before = rows(fresh), files(fresh)
    with pytest.raises(Unusable, match="not empty"):
        restore(backups, None, fresh, silent)
    assert (rows(fresh), files(fresh)) == before
    monkeypatch.setenv("MIMUCAL_DATABASE", postgres.empty_database(server))
    take_number(Home(tmp_path / "uses it"))
    with pytest.raises(Unusable, match=r"database postgresql.*not empty"):
        restore(backups, None, Home(tmp_path / "other"), silent)
    assert not (tmp_path / "other").exists()


def test_a_damaged_content_is_found_before_anything_is_written(fresh, filled, backups, tmp_path):
    filled(fresh)
    _, manifest = back_up(fresh, backups, "1", silent)
    path = Objects(backups).path(manifest.files[0].object)
    path.chmod(0o600)
    path.write_bytes(path.read_bytes()[:-1] + b"?")
    with pytest.raises(Unusable, match=f"{path.name} is not as it was kept"):
        restore(backups, None, Home(tmp_path / "other"), silent)
    assert not (tmp_path / "other").exists()


def test_a_backup_of_a_newer_program_is_refused(fresh, filled, backups, tmp_path):
    filled(fresh)
    name, manifest = back_up(fresh, backups, "1", silent)
    path = backups / "backups" / f"{name}.json"
    newer = manifest.model_copy(update={"revision": "9999"})
    path.chmod(0o600)
    path.write_text(newer.model_dump_json())
    with pytest.raises(Unusable, match="update mimucal"):
        restore(backups, None, Home(tmp_path / "other"), silent)


def test_a_name_that_leads_out_of_the_home_is_refused(fresh, filled, backups, tmp_path):
    filled(fresh)
    name, _ = back_up(fresh, backups, "1", silent)
    path = backups / "backups" / f"{name}.json"
    document = json.loads(path.read_text())
    document["files"][0]["name"] = "../outside"
    path.chmod(0o600)
    path.write_text(json.dumps(document))
    with pytest.raises(Unusable, match="within the home"):
        restore(backups, None, Home(tmp_path / "other"), silent)


def test_a_backup_is_for_its_owner_alone(fresh, filled, backups):
    filled(fresh)
    back_up(fresh, backups, "1", silent)
    assert backups.stat().st_mode & 0o077 == 0
    assert all(path.stat().st_mode & 0o377 == 0
               for path in (backups / "objects").rglob("*") if path.is_file())  # fmt: skip


def test_a_home_within_the_folder_or_without_a_catalogue_is_refused(fresh):
    with pytest.raises(Unusable, match="another disk"):
        back_up(fresh, fresh.path / "backups", "1", silent)
    with pytest.raises(Unusable, match="nothing to back up"):
        back_up(fresh, fresh.path.with_name("backups"), "1", silent)


def test_one_backup_at_a_time(fresh, filled, backups):
    filled(fresh)
    with Objects(backups).writing(), pytest.raises(Unusable, match="going on"):
        back_up(fresh, backups, "1", silent)
