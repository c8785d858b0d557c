"""Recordings in the store: imported once, found again, never lost."""

import shutil
import stat
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sqlalchemy as sql

from schemas.base import Unusable
from schemas.orders import Selection
from schemas.recording import Manifest
from storage.catalogue import database, results, runs, tables
from storage.catalogue.run_states import complete_runs
from storage.catalogue.selection import select
from storage.formats import recordings
from storage.formats.content import digest, write_columns
from storage.formats.mcap.writer import write_mcap
from storage.home import Home
from storage.verify import verify
from tests.keep import keep
from tests.storage.small import calibrated, certified, small

STEPS = (
    "storage.formats.mcap.writer.write_mcap",
    "storage.formats.content.write_columns",
    "storage.catalogue.runs.unit_id",
)


def test_recording_comes_back_as_it_went_in(fresh):
    recording = small()
    run = runs.add(recording, fresh)[0]
    again = runs.load(run, fresh)
    assert again.digest == run.digest == digest(recording)
    np.testing.assert_array_equal(again.imu.t, recording.imu.t)
    for name, values in recording.imu.columns.items():
        np.testing.assert_array_equal(again.imu.columns[name], values)


def test_run_says_what_it_is(fresh):
    before = datetime.now(UTC)
    run = runs.add(small(serial="7"), fresh)[0]
    assert run.id == f"r{run.digest[:12]}"
    assert (run.manufacturer, run.model, run.serial) == ("Maker", "U", "7")
    assert (run.recording_id, run.standard, run.rows) == ("small", "other", 300)
    assert run.seconds == pytest.approx(2.99)
    assert before <= run.imported_at <= datetime.now(UTC)
    assert runs.all_runs(fresh) == [run]


def test_second_import_of_same_content_is_the_same_run(fresh):
    assert runs.add(small(), fresh)[0] == runs.add(small(), fresh)[0]
    assert len(runs.all_runs(fresh)) == 1
    assert len(list(fresh.raw.iterdir())) == 1


def test_digest_that_a_recording_claims_is_not_believed(fresh):
    assert runs.add(replace(small(), digest="f" * 64), fresh)[0].digest == digest(small())


def test_concurrent_imports_of_the_same_content_are_one_run(either, tmp_path, at_once):
    write_columns(small(), tmp_path / "source")
    script = """
path = Path(arguments[0])
print(runs.add(recordings.read(path), home, source=path)[0].id)
"""
    text = at_once(script, either, str(tmp_path / "source"), processes=3)
    (run,) = runs.all_runs(either)
    assert text == [f"{run.id}\n"] * 3
    assert [path.name for path in either.raw.iterdir()] == [f"{run.digest}.mcap"]
    assert [path.name for path in either.columns.iterdir()] == [run.digest]


def test_raw_recording_is_read_only(fresh):
    run = runs.add(small(), fresh)[0]
    assert stat.S_IMODE((fresh.raw / f"{run.digest}.mcap").stat().st_mode) == 0o400


@pytest.mark.parametrize("step", STEPS)
def test_import_broken_off_leaves_nothing_half_and_can_be_repeated(fresh, step, monkeypatch):
    def break_off(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as broken:
        broken.setattr(step, break_off)
        with pytest.raises(KeyboardInterrupt):
            runs.add(small(), fresh)
    assert runs.all_runs(fresh) == []
    assert not list(fresh.path.rglob(".*"))
    run = runs.add(small(), fresh)[0]
    assert runs.load(run, fresh).digest == run.digest


@pytest.mark.parametrize("step", STEPS[1:2])
def test_process_killed_in_an_import_leaves_a_store_that_goes_on(fresh, step, tmp_path):
    write_columns(small(), tmp_path / "source")
    script = """
import os, sys
from importlib import import_module
from pathlib import Path
from storage.catalogue import runs
from storage.formats import recordings
from storage.home import Home
step, home, source = sys.argv[1], Home(Path(sys.argv[2])), Path(sys.argv[3])
module, _, name = step.rpartition(".")
whole = getattr(import_module(module), name)
def killed(*arguments):
    whole(*arguments)
    os.kill(os.getpid(), 9)
setattr(import_module(module), name, killed)
runs.add(recordings.read(source), home)
"""
    command = [sys.executable, "-c", script, step, str(fresh.path), str(tmp_path / "source")]
    assert subprocess.run(command, check=False).returncode == -9
    assert runs.all_runs(fresh) == []
    run = runs.add(small(), fresh)[0]
    assert runs.load(run, fresh).digest == run.digest
    assert verify(fresh) == (2, [])


def test_home_that_cannot_be_written_loses_nothing_and_says_so(fresh):
    fresh.path.write_text("a file stands where the folder should be")
    with pytest.raises(Unusable, match="MIMUCAL_HOME"):
        runs.add(small(), fresh)


def damage_missing(folder: Path) -> None:
    shutil.rmtree(folder)


def damage_cut(folder: Path) -> None:
    path = folder / "imu.parquet"
    path.write_bytes(path.read_bytes()[:1000])


def damage_manifest(folder: Path) -> None:
    (folder / "manifest.json").write_text("{}")


def damage_value(folder: Path) -> None:
    path = folder / "imu.parquet"
    content = bytearray(path.read_bytes())
    content[1000] ^= 1
    path.write_bytes(bytes(content))


@pytest.mark.parametrize("damage", [damage_missing, damage_cut, damage_manifest, damage_value])
def test_damaged_columns_are_made_again_from_raw(fresh, damage):
    run = runs.add(small(), fresh)[0]
    damage(fresh.columns / run.digest)
    assert digest(runs.load(run, fresh)) == run.digest
    assert runs.from_columns(run, fresh) is not None


def test_run_whose_files_are_gone_says_how_to_bring_it_back(fresh):
    run = runs.add(small(), fresh)[0]
    shutil.rmtree(fresh.columns)
    (fresh.raw / f"{run.digest}.mcap").unlink()
    with pytest.raises(Unusable, match=r"missing; import small again"):
        runs.load(run, fresh)
    runs.add(small(), fresh)
    assert runs.load(run, fresh).digest == run.digest


def test_raw_recording_with_other_content_is_refused(fresh):
    run = runs.add(small(), fresh)[0]
    shutil.rmtree(fresh.columns)
    path = fresh.raw / f"{run.digest}.mcap"
    path.unlink()
    write_mcap(small(start=1.0), path)
    with pytest.raises(Unusable, match="not what was imported"):
        runs.load(run, fresh)


def test_run_is_found_by_every_name_that_it_has(fresh):
    run = runs.add(small(name="first"), fresh)[0]
    runs.add(small(start=1.0, name="second"), fresh)
    for reference in (run.id, run.id[:5], run.digest, run.digest[:8], "first"):
        assert runs.find(reference, fresh) == run


def test_ambiguous_and_unknown_references_say_how_to_list_runs(fresh):
    one, two = runs.add(small(), fresh)[0], runs.add(small(start=1.0), fresh)[0]
    with pytest.raises(Unusable, match=rf"2 runs \({one.id}, {two.id}\).*mimucal runs"):
        runs.find("small", fresh)
    with pytest.raises(Unusable, match=r"2 runs"):
        runs.find("r", fresh)
    for nobody in ("r%", "_", "nobody", ""):
        with pytest.raises(Unusable, match=r"There is no run .*mimucal runs"):
            runs.find(nobody, fresh)


def test_source_taken_in_before_is_known_by_its_bytes(fresh, tmp_path):
    folder, moved = tmp_path / "folder", tmp_path / "elsewhere" / "copy"
    write_columns(small(), folder)
    assert runs.imported_before(folder, fresh) is None
    run = runs.add(recordings.read(folder), fresh, source=folder)[0]
    assert runs.imported_before(folder, fresh) == run
    shutil.copytree(folder, moved)
    assert runs.imported_before(moved, fresh) == run
    manifest = moved / "manifest.json"
    manifest.write_text(manifest.read_text().replace('"small"', '"large"'))
    assert runs.imported_before(moved, fresh) is None


def test_same_content_as_parquet_and_mcap_is_one_run_known_from_both(fresh, tmp_path):
    folder, file = tmp_path / "folder", tmp_path / "small.mcap"
    write_columns(small(), folder)
    write_mcap(small(), file)
    ids = {runs.add(recordings.read(path), fresh, source=path)[0].id for path in (folder, file)}
    assert len(ids) == 1
    assert (
        runs.imported_before(folder, fresh)
        == runs.imported_before(file, fresh)
        == runs.find(*ids, fresh)
    )


def test_path_is_read_as_what_it_holds(tmp_path):
    bag = tmp_path / "bag"
    bag.mkdir()
    (bag / "metadata.yaml").write_text("rosbag2_bagfile_information:\n")
    write_mcap(small(), bag / "bag_0.mcap")
    shutil.copy(bag / "bag_0.mcap", tmp_path / "without_a_suffix")
    write_columns(small(), tmp_path / "folder")
    for name in ("bag", "bag/bag_0.mcap", "without_a_suffix", "folder"):
        assert recordings.read(tmp_path / name).digest == digest(small())


def test_manifest_given_goes_before_the_one_in_the_file(tmp_path):
    write_mcap(small(), tmp_path / "small.mcap")
    manifest = tmp_path / "manifest.json"
    manifest.write_text(small(name="other").manifest.model_dump_json())
    read = recordings.read(tmp_path / "small.mcap", manifest=manifest)
    assert read.manifest.recording_id == "other"
    write_columns(small(), tmp_path / "folder")
    with pytest.raises(Unusable, match=r"its own manifest\.json"):
        recordings.read(tmp_path / "folder", manifest=manifest)


def make_nothing(path: Path) -> None:
    """There is no such path."""


def make_text(path: Path) -> None:
    path.write_text("no recording")


def make_folder(path: Path) -> None:
    path.mkdir()


def make_two_bags(path: Path) -> None:
    path.mkdir()
    for name in ("metadata.yaml", "a.mcap", "b.mcap"):
        (path / name).write_text("")


def make_bag_without_metadata(path: Path) -> None:
    path.mkdir()
    (path / "a.mcap").write_text("")


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (make_nothing, "cannot be read"),
        (make_text, "is not a recording"),
        (make_folder, r"manifest\.json is missing"),
        (make_two_bags, "holds 2 MCAP files"),
        (make_bag_without_metadata, r"give the file .*a\.mcap itself"),
    ],
)
def test_path_that_is_no_recording_is_refused(fresh, tmp_path, make, says):
    path = tmp_path / "path"
    make(path)
    with pytest.raises(Unusable, match=says):
        recordings.read(path)
    with pytest.raises(Unusable, match=says):
        runs.imported_before(path, fresh)
    assert not fresh.path.exists()


# Runs chosen by what the catalogue says of them; those of earlier versions, too.

TABLE = {"name": "Table", "name_zh": "转台", "serial": "T-7", "accuracy": "1″", "certificate": "C1"}


@pytest.fixture
def recorded(fresh) -> Callable[..., str]:
    """Keeps a run whose manifest has further fields; gives its id."""

    def keep(start: float, station: str = "T1", serial: str = "1", **fields: Any) -> str:
        recording = small(start, serial=serial)
        manifest = recording.manifest.model_dump() | {"station": {"id": station}} | fields
        again = replace(recording, manifest=Manifest.model_validate(manifest))
        return runs.add(again, fresh)[0].id

    return keep


def chosen(home: Home, **asked: Any) -> list[str]:
    return [run.id for run in select(Selection(**asked), home)]


def test_stations_serials_procedures_and_days_choose(fresh, recorded):
    one = recorded(0.0, recorded_at="2026-03-01T23:59:00+08:00", procedure="short")
    two = recorded(1.0, station="T2", recorded_at="2026-03-02", standard="JJF 2003-2022")
    three = recorded(2.0, serial="2")
    assert chosen(fresh) == [one, two, three]
    assert chosen(fresh, station="T2") == [two]
    assert chosen(fresh, serial="2") == [three]
    assert chosen(fresh, model="U", procedure="short") == [one]
    assert chosen(fresh, procedure="JJF 2003-2022") == [two]
    assert chosen(fresh, until=date(2026, 3, 1)) == [one]
    assert chosen(fresh, since=date(2026, 3, 2), until=date(2026, 3, 2)) == [two]
    today = runs.find(three, fresh).imported_at.date()
    assert chosen(fresh, since=date(2026, 3, 2)) == [two, three]
    assert chosen(fresh, since=today) == [three]  # by its import: its manifest gives no day


def test_the_moment_of_the_first_row_gives_the_day_where_no_station_did(fresh, recorded):
    moment = recorded(0.0, acquired_at="20260301T083000Z")
    both = recorded(1.0, recorded_at="2026-03-02T07:00:00+08:00", acquired_at="2026-03-01T23:00Z")
    assert chosen(fresh, until=date(2026, 3, 1)) == [moment]
    assert chosen(fresh, since=date(2026, 3, 2), until=date(2026, 3, 2)) == [both]


def test_the_version_of_the_newest_result_chooses(fresh, recorded):
    old, new = (runs.find(recorded(start), fresh) for start in (0.0, 1.0))
    for run in (old, new):
        results.save(calibrated(run, code_version="0.1.0+a"), fresh)
    results.save(calibrated(new, code_version="0.2.0+b"), fresh)
    assert chosen(fresh, code_version="0.1.0") == [old.id]
    assert chosen(fresh, code_version="0.2") == [new.id]


def test_runs_of_an_earlier_version_are_completed_from_manifests_and_certificates(fresh, recorded):
    run = runs.find(recorded(0.0, recorded_at="2026-03-01", equipment=[TABLE]), fresh)
    recording = runs.load(run, fresh)
    party = dict.fromkeys(("name", "name_zh", "address", "address_zh"), "L")
    laboratory = {"party": party, "equipment": [TABLE | {"certificate": "C2"}]}
    keep(certified(recording, calibrated(run), "A-1", laboratory=laboratory), fresh)
    expected = database.rows(fresh, sql.select(tables.equipment))
    assert {(row.document, row.certificate) for row in expected} == {
        ("manifest", "C1"), ("A-1", "C2"),
    }  # fmt: skip
    with database.changing(fresh) as connection:  # as it was before there was any of it
        connection.execute(sql.delete(tables.equipment))
        unknown = dict.fromkeys(("station", "procedure", "recorded_on"))
        connection.execute(sql.update(tables.runs).values(**unknown))
    assert runs.find(run.id, fresh).station is None
    complete_runs(fresh)
    assert runs.find(run.id, fresh) == run
    assert set(database.rows(fresh, sql.select(tables.equipment))) == set(expected)


def test_equipment_that_is_no_record_keeps_no_run_out(fresh, recorded):
    run = recorded(0.0, equipment=["a table", {"name": "Table"}, 7], recorded_at=17)
    assert runs.find(run, fresh).recorded_on is None
    (row,) = database.rows(fresh, sql.select(tables.equipment))
    assert (row.name, row.serial) == ("Table", "")
