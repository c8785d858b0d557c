"""The store of a line: its runs measure what the units are, and its judge of the pages."""

import json
import shutil
import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flows.pages.answers import PAGES
from storage import dataframes
from storage.home import Home
from tests.proof import line_pages
from tests.proof.line import Line, recorded_runs, runs_of, templates, tolerance_of, true_values
from tests.proof.line_pages import same


def test_values_scatter_about_the_true_coefficients_by_their_u(
    line_store: tuple[Home, Line],
) -> None:
    home, line = line_store
    measured = templates(line)
    drawn = {
        f"{unit.serial}-{run.number:03d}": run
        for unit in line.units
        for run in runs_of(line, unit, measured, tolerance_of("MX-110"))
    }
    ids = dataframes.runs(home).set_index("id")["recording_id"]
    recorded = {ids[run] for run in recorded_runs(home)}
    assert len(recorded) == 4
    table, ratios = dataframes.results(home), {True: [], False: []}
    for row in table[table["value"].notna()].itertuples():
        run = drawn[row.recording_id]
        truth = true_values(line.units[run.unit].after(run.years, run.kept))
        if row.item in truth:
            error = row.value - truth[row.item][row.element]
            ratios[row.recording_id in recorded].append(error / row.standard_uncertainty)
    assert np.std(ratios[False]) == pytest.approx(1.0, abs=0.05)
    assert abs(np.mean(ratios[False])) < 0.1
    assert np.median(np.abs(ratios[True])) < 1.0  # recordings are of the same units as the rows


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
