"""First-pass yield: its interval, and which runs count."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tasks.quality import (
    FEWEST_IN_POINT,
    RETEST_DAYS,
    against_each_other,
    consumed,
    first_runs,
    pooled,
    wilson,
    yields,
)

# R. G. Newcombe, Statistics in Medicine 17 (1998) 857, table I, method 3
NEWCOMBE = {
    (81, 263): (0.2553, 0.3662), (15, 148): (0.0624, 0.1605), (0, 20): (0.0, 0.1611),
    (1, 29): (0.0061, 0.1718),
}  # fmt: skip


def test_intervals_are_those_that_newcombe_prints():
    passed, of = np.array(list(NEWCOMBE)).T
    low, high = wilson(passed, of)
    printed = np.array(list(NEWCOMBE.values()))
    assert low == pytest.approx(printed[:, 0], abs=5e-5)
    assert high == pytest.approx(printed[:, 1], abs=5e-5)


def test_nothing_has_no_interval():
    low, high = wilson(np.array([0]), np.array([0]))
    assert np.isnan([low[0], high[0]]).all()


def test_yield_of_each_group():
    runs = pd.DataFrame({"station": ["b", "a", "b", "b"], "passed": [True, False, False, True]})
    table = yields(runs, "station")
    assert table.index.tolist() == ["a", "b"]
    assert table["passed"].tolist() == [0, 2]
    assert table["of"].tolist() == [1, 3]
    assert table.loc["b", "share"] == pytest.approx(2 / 3)
    assert (table["low"] <= table["share"]).all()
    assert (table["share"] <= table["high"]).all()


def test_a_run_soon_after_one_of_the_same_unit_is_a_retest():
    days = [0, 1, 1 + RETEST_DAYS, 30, 30, 0]
    runs = pd.DataFrame({
        "unit": [1, 1, 1, 1, 1, 2],
        "day": pd.Timestamp("2026-01-01") + pd.to_timedelta(days, unit="D"),
        "order": [0, 1, 2, 4, 3, 5],
    })  # fmt: skip
    assert first_runs(runs).tolist() == [True, False, False, False, True, True]
    shuffled = runs.sample(frac=1.0, random_state=1)
    assert first_runs(shuffled).sort_index().tolist() == first_runs(runs).tolist()


def test_weeks_of_few_units_are_pooled_until_a_point_says_something():
    weeks = [3] * 10  # 30 first runs: 21 make a point, and 9 are left
    assert pooled(weeks) == [slice(0, 10)]
    assert pooled([1] * 65) == [slice(0, 20), slice(20, 40), slice(40, 65)]
    assert pooled([25, 1, 40, 3]) == [slice(0, 1), slice(1, 4)]
    assert pooled([2, 1]) == [slice(0, 2)]
    assert pooled([]) == []


@given(st.lists(st.integers(1, 60), max_size=80))
def test_pooling_loses_no_week_and_leaves_no_small_point(of):
    parts = pooled(of)
    assert [week for part in parts for week in range(len(of))[part]] == list(range(len(of)))
    assert len(parts) < 2 or all(sum(of[part]) >= FEWEST_IN_POINT for part in parts)


# Station against station: planted differences are found with a U that holds them.

STATIONS = 4


def line(rng: np.random.Generator, runs: int = 400, units: int = 25) -> tuple[np.ndarray, ...]:
    """(unit, station, values) of units that differ and drift, with station 2 off by 3 sigma."""
    unit, station = rng.integers(units, size=runs), rng.integers(STATIONS, size=runs)
    values = 100.0 * rng.standard_normal(units)[unit] + 3.0 * (station == 2)
    drift = rng.standard_normal(units)[unit] * np.linspace(0.0, 10.0, runs)
    return unit, station, values + drift + rng.standard_normal(runs)


def test_a_station_that_is_off_is_found_though_units_differ_and_drift():
    rng = np.random.default_rng(7)
    found = against_each_other(*line(rng), np.zeros(400, bool), STATIONS)
    assert np.abs(found.difference - [0.0, 0.0, 3.0, 0.0]).max() < 0.4
    assert (np.abs(found.difference) > found.U).tolist() == [False, False, True, False]
    assert found.U.max() < 0.5


def test_u_holds_the_true_difference():
    held = []
    for seed in range(150):
        found = against_each_other(
            *line(np.random.default_rng(seed)), np.zeros(400, bool), STATIONS
        )
        held += (np.abs(found.difference - [0.0, 0.0, 3.0, 0.0]) < found.U).tolist()
    assert 0.91 < np.mean(held) < 0.98


def test_the_step_over_an_adjustment_says_nothing():
    unit, station = np.zeros(4, int), np.array([0, 1, 0, 1])
    values, adjusted = np.array([0.0, 1.0, 50.0, 51.0]), np.array([False, False, True, False])
    found = against_each_other(unit, station, values, adjusted, 2)
    assert found.difference == pytest.approx([-0.5, 0.5])
    assert np.isnan(found.U).all()  # one unit has no scatter between units


def test_a_station_that_nothing_ties_to_the_others_has_no_difference():
    found = against_each_other(
        np.array([0, 0, 1]), np.array([0, 1, 2]), np.zeros(3), np.zeros(3, bool), 3
    )
    assert np.isnan(found.difference[2])
    assert found.pairs.tolist() == [1, 1, 0]


def test_u_takes_of_the_margin_what_it_is_of_the_distance_to_the_nearer_limit():
    nan = np.nan
    share = consumed(
        np.array([0.0, 0.75, 1.0, 2.0, 0.5, nan, 0.5]),
        np.array([0.1, 0.1, 0.1, 0.1, 0.1, 0.1, nan]),
        np.array([-1.0, -1.0, -1.0, -1.0, nan, -1.0, nan]),
        np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]),
    )
    assert share[:5] == pytest.approx([0.1, 0.4, np.inf, np.inf, 0.2])
    assert np.isnan(share[5:]).all()
