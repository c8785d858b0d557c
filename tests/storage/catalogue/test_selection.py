"""Runs chosen by what the catalogue says of them; those of earlier versions, too."""

from collections.abc import Callable
from dataclasses import replace
from datetime import date
from typing import Any

import pytest
import sqlalchemy as sql

from schemas.orders import Selection
from schemas.recording import Manifest
from storage.catalogue import database, results, run_index, runs, tables
from storage.catalogue.completion import complete_runs
from storage.catalogue.selection import select
from storage.home import Home
from tests.keep import keep
from tests.storage.small import calibrated, certified, small

TABLE = {"name": "Table", "name_zh": "转台", "serial": "T-7", "accuracy": "1″", "certificate": "C1"}


@pytest.fixture
def recorded(fresh: Home) -> Callable[..., str]:
    """Keeps a run whose manifest has further fields; gives its id."""

    def keep(start: float, station: str = "T1", serial: str = "1", **fields: Any) -> str:
        recording = small(start, serial=serial)
        manifest = recording.manifest.model_dump() | {"station": {"id": station}} | fields
        again = replace(recording, manifest=Manifest.model_validate(manifest))
        return runs.add(again, fresh)[0].id

    return keep


def chosen(home: Home, **asked: Any) -> list[str]:
    return [run.id for run in select(Selection(**asked), home)]


def test_stations_serials_procedures_and_days_choose(fresh: Home, recorded) -> None:
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
    today = run_index.find(three, fresh).imported_at.date()
    assert chosen(fresh, since=date(2026, 3, 2)) == [two, three]
    assert chosen(fresh, since=today) == [three]  # by its import: its manifest gives no day


def test_the_moment_of_the_first_row_gives_the_day_where_no_station_did(
    fresh: Home, recorded
) -> None:
    moment = recorded(0.0, acquired_at="20260301T083000Z")
    both = recorded(1.0, recorded_at="2026-03-02T07:00:00+08:00", acquired_at="2026-03-01T23:00Z")
    assert chosen(fresh, until=date(2026, 3, 1)) == [moment]
    assert chosen(fresh, since=date(2026, 3, 2), until=date(2026, 3, 2)) == [both]


def test_the_version_of_the_newest_result_chooses(fresh: Home, recorded) -> None:
    old, new = (run_index.find(recorded(start), fresh) for start in (0.0, 1.0))
    for run in (old, new):
        results.save(calibrated(run, code_version="0.1.0+a"), fresh)
    results.save(calibrated(new, code_version="0.2.0+b"), fresh)
    assert chosen(fresh, code_version="0.1.0") == [old.id]
    assert chosen(fresh, code_version="0.2") == [new.id]


def test_runs_of_an_earlier_version_are_completed_from_manifests_and_certificates(
    fresh: Home, recorded
) -> None:
    run = run_index.find(recorded(0.0, recorded_at="2026-03-01", equipment=[TABLE]), fresh)
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
    assert run_index.find(run.id, fresh).station is None
    complete_runs(fresh)
    assert run_index.find(run.id, fresh) == run
    assert set(database.rows(fresh, sql.select(tables.equipment))) == set(expected)


def test_equipment_that_is_no_record_keeps_no_run_out(fresh: Home, recorded) -> None:
    run = recorded(0.0, equipment=["a table", {"name": "Table"}, 7], recorded_at=17)
    assert run_index.find(run, fresh).recorded_on is None
    (row,) = database.rows(fresh, sql.select(tables.equipment))
    assert (row.name, row.serial) == ("Table", "")
