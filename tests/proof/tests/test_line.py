"""The store of a line: its runs measure what the units are, and the tilt shifts what it shifts."""

import json
import shutil
import sqlite3
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flows.pages.answers import PAGES
from storage import dataframes
from storage.home import Home
from tests.proof import line_pages
from tests.proof.line import (
    Line,
    LineRun,
    Measured,
    is_tilted,
    measured_by_grade,
    recorded_runs,
    runs_of,
    tolerance_of,
    true_values,
)
from tests.proof.line_pages import same
from tests.proof.plant.case import Grade

TILTED = "accel_rate_sensitivity"


@pytest.fixture(scope="module")
def measured(line_store: tuple[Home, Line]) -> Mapping[Grade, Measured]:
    return measured_by_grade(line_store[1])


@pytest.fixture(scope="module")
def drawn(line_store: tuple[Home, Line], measured: Mapping[Grade, Measured]) -> dict[str, LineRun]:
    """The runs as they were drawn, by the name of the recording."""
    _, line = line_store
    return {
        f"{unit.serial}-{run.number:03d}": run
        for unit in line.units
        for run in runs_of(line, unit, measured, tolerance_of("MX-110"))
    }


def _errors(store: tuple[Home, Line], drawn: dict[str, LineRun], names: set[str]) -> list:
    """(tilted, item, element, error, u) of each element of some runs, by recording."""
    home, line = store
    table = dataframes.results(home)
    found = []
    for row in table[table["recording_id"].isin(names) & table["value"].notna()].itertuples():
        run = drawn[row.recording_id]
        truth = true_values(line.units[run.unit].after(run.years, run.kept))
        if row.item in truth:
            error = row.value - truth[row.item][row.element]
            tilted = is_tilted(line, run.station, run.at)
            found.append((tilted, row.item, row.element, error, row.standard_uncertainty))
    return found


def test_values_scatter_about_the_true_coefficients_by_their_u(line_store, drawn) -> None:
    recorded = set(_recording_ids(line_store[0]))
    errors = _errors(line_store, drawn, drawn.keys() - recorded)
    level = [error / u for tilted, _, _, error, u in errors if not tilted]
    assert np.std(level) == pytest.approx(1.0, abs=0.05)
    assert abs(np.mean(level)) < 0.1


def test_recordings_are_of_the_same_units_as_the_rows(line_store, drawn) -> None:
    recorded = set(_recording_ids(line_store[0]))
    assert len(recorded) == 4
    errors = _errors(line_store, drawn, recorded)
    assert np.median([abs(error) / u for tilted, _, _, error, u in errors if not tilted]) < 1.0


def test_a_tilt_shifts_what_a_tilt_shifts(line_store, drawn, measured) -> None:
    shift = measured["industrial"].shift
    assert max(map(abs, shift["gyro_scale_factor"].values())) < 1e-6
    tilted = [each for each in _errors(line_store, drawn, set(drawn)) if each[0]]
    own = [(error / u, shift[i][e] / u) for _, i, e, error, u in tilted if i == TILTED]
    observation, expected = np.array(own).T
    assert (observation @ expected) / (expected @ expected) == pytest.approx(1.0, abs=0.3)


def _recording_ids(home: Home) -> list[str]:
    table = dataframes.runs(home).set_index("id")
    return [table.loc[run, "recording_id"] for run in recorded_runs(home)]


# The judge of the pages: it agrees with them, and sees a number that is not the catalogue's.


def wrong(shown_of: Home, database: Path) -> list[str]:
    """What the pages of a home say otherwise than a catalogue."""
    pages = {page.name: page for page in PAGES}

    def ask(name: str, asked: dict[str, str]) -> Any:
        page = pages[name]
        return json.loads(page.data(page.question(**asked), shown_of).model_dump_json())

    compared = line_pages.pairs(sqlite3.connect(database), ask)
    return [what for what, declared, own in compared if not same(declared, own)]


@pytest.fixture
def catalogue(line_store: tuple[Home, Line], tmp_path: Path) -> Path:
    """A copy that may be altered."""
    shutil.copy(line_store[0].path / "catalog.sqlite", tmp_path)
    return tmp_path / "catalog.sqlite"


def test_every_number_is_the_catalogues(line_store, catalogue: Path) -> None:
    assert wrong(line_store[0], catalogue) == []


@pytest.mark.parametrize(("change", "page"), [
    ("update elements set value = value + 1e-6 where item = 'gyro_bias'", "unit"),
    ("update outcomes set verdict = 'invalid'", "runs"),
    ("update certificates set due = '2027-01-01' where due is not null", "due"),
    ("insert or replace into explained select id, imported_at, '1', 'explained' from runs",
     "explained"),
])  # fmt: skip
def test_a_number_that_is_not_is_seen(line_store, catalogue: Path, change: str, page: str) -> None:
    database = sqlite3.connect(catalogue)
    database.execute(change)
    database.commit()
    assert any(what.startswith(page) for what in wrong(line_store[0], catalogue))
