"""Station against station: planted differences are found with a U that holds them."""

import numpy as np
import pytest

from tasks.quality.capability import consumed
from tasks.quality.stations import against_each_other

STATIONS = 4


def line(rng: np.random.Generator, runs: int = 400, units: int = 25) -> tuple[np.ndarray, ...]:
    """(unit, station, values) of units that differ and drift, with station 2 off by 3 sigma."""
    unit, station = rng.integers(units, size=runs), rng.integers(STATIONS, size=runs)
    values = 100.0 * rng.standard_normal(units)[unit] + 3.0 * (station == 2)
    drift = rng.standard_normal(units)[unit] * np.linspace(0.0, 10.0, runs)
    return unit, station, values + drift + rng.standard_normal(runs)


def test_a_station_that_is_off_is_found_though_units_differ_and_drift() -> None:
    rng = np.random.default_rng(7)
    found = against_each_other(*line(rng), np.zeros(400, bool), STATIONS)
    assert np.abs(found.difference - [0.0, 0.0, 3.0, 0.0]).max() < 0.4
    assert (np.abs(found.difference) > found.U).tolist() == [False, False, True, False]
    assert found.U.max() < 0.5


def test_u_holds_the_true_difference() -> None:
    held = []
    for seed in range(150):
        found = against_each_other(
            *line(np.random.default_rng(seed)), np.zeros(400, bool), STATIONS
        )
        held += (np.abs(found.difference - [0.0, 0.0, 3.0, 0.0]) < found.U).tolist()
    assert 0.91 < np.mean(held) < 0.98


def test_the_step_over_an_adjustment_says_nothing() -> None:
    unit, station = np.zeros(4, int), np.array([0, 1, 0, 1])
    values, adjusted = np.array([0.0, 1.0, 50.0, 51.0]), np.array([False, False, True, False])
    found = against_each_other(unit, station, values, adjusted, 2)
    assert found.difference == pytest.approx([-0.5, 0.5])
    assert np.isnan(found.U).all()  # one unit has no scatter between units


def test_a_station_that_nothing_ties_to_the_others_has_no_difference() -> None:
    found = against_each_other(
        np.array([0, 0, 1]), np.array([0, 1, 2]), np.zeros(3), np.zeros(3, bool), 3
    )
    assert np.isnan(found.difference[2])
    assert found.pairs.tolist() == [1, 1, 0]


def test_u_takes_of_the_margin_what_it_is_of_the_distance_to_the_nearer_limit() -> None:
    nan = np.nan
    share = consumed(
        np.array([0.0, 0.75, 1.0, 2.0, 0.5, nan, 0.5]),
        np.array([0.1, 0.1, 0.1, 0.1, 0.1, 0.1, nan]),
        np.array([-1.0, -1.0, -1.0, -1.0, nan, -1.0, nan]),
        np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]),
    )
    assert share[:5] == pytest.approx([0.1, 0.4, np.inf, np.inf, 0.2])
    assert np.isnan(share[5:]).all()
