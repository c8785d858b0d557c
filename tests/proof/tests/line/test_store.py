"""The store of a line: its runs measure what the units are, and the tilt shifts what it shifts."""

from collections.abc import Mapping

import numpy as np
import pytest

from flows.pages.run import data
from flows.pages.run.models import RunQuestion
from storage import dataframes
from storage.catalogue import database, tables
from storage.home import Home
from tests.proof.line import (
    Line,
    LineRun,
    Measured,
    is_tilted,
    measured_by_grade,
    recorded_runs,
    runs_of,
    station_name,
    tolerance_of,
    true_values,
)
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


def test_every_run_of_the_store_opens(line_store) -> None:
    home, line = line_store
    table = dataframes.runs(home)
    assert len(table) == line.runs
    shown = data(RunQuestion(id=table["id"].iloc[7]), home)
    assert shown.elements
    assert set(table["station"]) <= {station_name(k) for k in range(6)}
    assert not database.rows(home, tables.outcomes.select().where(tables.outcomes.c.run.is_(None)))


def _recording_ids(home: Home) -> list[str]:
    table = dataframes.runs(home).set_index("id")
    return [table.loc[run, "recording_id"] for run in recorded_runs(home)]
