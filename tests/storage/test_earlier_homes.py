"""Homes that earlier versions left, upgraded: each holds rows in every table, and loses none.

`homes/REVISION.tar.xz` was written by the program whose catalogue had that revision: see
`full_home`.
"""

import json
import tarfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sqlalchemy as sql
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory

from schemas.base import Unusable
from storage.backup import back_up, is_needed, rehearse, restore, upgrade
from storage.catalogue import certificates, database, dump, results, runs, tables
from storage.formats.mcap.reader import read_mcap
from storage.home import Home
from storage.verify import verify
from tests import postgres
from tests.ideal import ideal_run
from tests.storage.full_home import GRAVITY, HOMES

# What a step forward gives another name, by its revision and table: the old name and the new one.
RENAMED = {"0014": {"runs": {"taken_in_at": "imported_at"}}}
KEPT = sorted(path.name.split(".")[0] for path in HOMES.glob("*.tar.xz"))


@pytest.fixture(params=KEPT)
def revision(request) -> str:
    return str(request.param)


@pytest.fixture
def earlier(revision, fresh) -> Home:
    """The home of a revision as it was left."""
    with tarfile.open(HOMES / f"{revision}.tar.xz") as archive:
        archive.extractall(fresh.path, filter="data")
    return fresh


@pytest.fixture(params=["sqlite", "postgresql"])
def upgraded(
    request, revision, earlier, server, tmp_path, monkeypatch
) -> tuple[Home, dict[str, list[dict[str, Any]]]]:
    """The home brought to this version, in either database, and the rows that were in it."""
    before = rows(earlier)
    if request.param == "postgresql":
        back_up(earlier, tmp_path / "backups", "1", silent)
        earlier = Home(tmp_path / "other")
        monkeypatch.setenv("MIMUCAL_DATABASE", postgres.empty_database(server))
        with monkeypatch.context() as patched:
            patched.setattr(database, "HEAD", revision)
            restore(tmp_path / "backups", None, earlier, silent)
    if is_needed(earlier):
        assert rehearse(earlier, "1", silent) == []
        assert upgrade(earlier, "1") == revision
    return earlier, before


def silent(_: int, __: int) -> None:
    pass


def rows(home: Home) -> dict[str, list[dict[str, Any]]]:
    """Every row of a catalogue, of whatever revision."""
    with dump.snapshot(home) as connection:
        assert connection is not None
        return {
            table.name: [
                dict(zip(dump.columns_of(table), json.loads(line), strict=True))
                for line in dump.lines(connection, table)
            ]
            for table in dump.tables_of(connection)
        }


def test_a_home_of_every_revision_is_kept():
    """Before a release with new tables: `python -m tests.storage.full_home`."""
    settings = Config()
    settings.set_main_option("script_location", str(Path(database.__file__).parent / "migrations"))
    scripts = ScriptDirectory.from_config(settings).walk_revisions()
    assert sorted(script.revision for script in scripts) == KEPT
    assert KEPT[0] == database.FIRST


def test_every_table_of_a_kept_home_has_content(earlier):
    assert [name for name, found in rows(earlier).items() if not found] == []


def test_the_tables_become_those_of_this_version(upgraded):
    home, _ = upgraded
    with database.changing(home) as connection:
        context = MigrationContext.configure(connection, opts={"compare_server_default": True})
        assert compare_metadata(context, tables.metadata) == []


def test_no_row_and_no_value_is_lost(revision, upgraded):
    home, before = upgraded
    for step, renamed in RENAMED.items():
        for name, names in renamed.items() if step > revision else ():
            before[name] = [{names.get(n, n): v for n, v in row.items()} for row in before[name]]
    after = rows(home)
    assert after.keys() == before.keys()
    for name, found in before.items():
        assert len(after[name]) == len(found)
        assert {frozenset(row.items()) for row in after[name]} == {
            frozenset(row.items()) for row in found
        }


def test_recordings_results_and_certificates_are_read_and_nothing_is_at_fault(upgraded):
    home, _ = upgraded
    assert verify(home)[1] == []
    run = next(each for each in runs.all_runs(home) if each.recording_id == "ideal")
    expected = ideal_run(dwell=1.0, gravity=GRAVITY)
    is_restored = not (home.path / "columns").exists()  # they are not in a backup
    loaded = runs.load(run, home) if is_restored else runs.from_columns(run, home)
    assert loaded is not None
    for recording in (loaded, read_mcap(home.raw / f"{run.digest}.mcap")):
        assert recording.digest == run.digest
        for name, values in recording.imu.columns.items():
            np.testing.assert_array_equal(values, expected.imu.columns[name])
    first, second = results.of_run(run, home)
    assert second.supersedes == first.id
    assert first.calibration.items["gyro_scale_factor"].value["x"] == pytest.approx(1.0, abs=1e-6)
    register = certificates.register(home)
    assert [entry.state for entry in register].count("issued") == 1
    for entry in register:
        assert certificates.find(entry.number, home).number == entry.number


def test_a_home_of_a_development_version_is_refused_with_the_way_out(earlier):
    if is_needed(earlier):
        upgrade(earlier, "1")
    with dump.alone(earlier) as connection:
        connection.execute(sql.text("UPDATE alembic_version SET version_num = '0012'"))
    for use in (is_needed, runs.all_runs):
        with pytest.raises(Unusable, match=r"revision 0012.*development version.*to 0013 by"):
            use(earlier)
