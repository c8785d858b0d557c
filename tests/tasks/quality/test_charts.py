"""Control charts, against the worked examples of handbooks and the rules as Nelson states them."""

import numpy as np
import pytest

from tasks.quality import FEWEST, HISTORY, RULES, drift, individuals, nelson, station_check

# NIST/SEMATECH e-Handbook, 6.3.2.2: flow rates of ten batches
FLOW = np.array([49.6, 47.6, 49.9, 51.3, 47.8, 51.2, 52.6, 52.4, 53.6, 52.1])
BROKEN = {  # each rule by itself, in sigma: the last value is the one that breaks it
    1: [0.5, -0.5, 3.1],
    2: [-0.5, *[0.5, 0.7] * 4, 0.5],
    3: [0.9, -0.9, -0.5, -0.3, 0.2, 0.4, 0.6],
    4: [0.3, *[0.5, -0.5] * 6, 0.5],
    5: [-0.5, 2.5, 0.5, 2.5],
    6: [-0.5, 1.5, 1.2, 0.5, 1.5, 1.2],
    7: [1.5, *[0.5, 0.5, -0.5] * 5],
    8: [0.5, *[1.5, -1.5, -1.2, 1.3] * 2],
}


def test_limits_are_those_of_the_handbook():
    chart = individuals(FLOW)
    assert chart is not None
    assert chart.centre == pytest.approx(50.81)
    assert chart.mean_range == pytest.approx(1.8778, abs=5e-5)
    assert chart.limits == pytest.approx((45.8159, 55.8041), abs=2e-3)  # by d2 = 1.128
    assert not chart.broken.any()


@pytest.mark.parametrize("rule", range(1, RULES + 1))
def test_each_rule_is_broken_by_its_own_pattern_at_the_last_value(rule):
    pattern = np.array(BROKEN[rule])
    broken = nelson(pattern)[rule - 1]
    assert broken[-1]
    assert not broken[:-1].any()
    assert nelson(-pattern)[rule - 1][-1]


@pytest.mark.parametrize("rule", [2, 3, 4, 7, 8])
def test_one_value_less_in_the_row_breaks_nothing(rule):
    first = {2: 1, 3: 1, 4: 0, 7: 1, 8: 1}[rule]  # where the row begins
    assert not nelson(np.array(BROKEN[rule])[first + 1 :])[rule - 1].any()


def test_noise_breaks_the_first_rule_as_often_as_nelson_says():
    z = np.random.default_rng(2).standard_normal(400_000)
    rates = nelson(z).mean(axis=1)
    assert rates[0] == pytest.approx(0.0027, rel=0.1)
    assert rates[1] == pytest.approx(2 * 0.5**9, rel=0.1)
    assert (rates < 0.008).all()


def test_a_single_value_and_equal_values_have_no_violations():
    assert individuals(np.array([1.0])) is None
    chart = individuals(np.ones(20))
    assert chart is not None
    assert not chart.broken[:6].any()


# Drift of a coefficient: the slope that was put in, with a U that covers it.

YEARS = np.array([0.0, 0.5, 1.0, 1.6, 2.0, 3.0])
ONES = np.ones(6)
NEVER = np.zeros(6, int)


def test_a_line_is_its_slope_and_an_adjustment_moves_the_level_alone():
    adjusted = np.array([0, 0, 0, 1, 1, 1])
    found = drift(YEARS, 5.0 + 0.2 * YEARS - 4.0 * adjusted, 0.1 * ONES, adjusted)
    assert found is not None
    assert found.per_year == pytest.approx(0.2)
    assert found.readings == 6


def test_a_steady_unit_has_the_u_of_its_readings():
    found = drift(YEARS, ONES, 0.1 * ONES, NEVER)
    assert found is not None
    assert found.per_year == pytest.approx(0.0, abs=1e-12)
    assert pytest.approx(2 * 0.1 / np.sqrt(np.sum((YEARS - YEARS.mean()) ** 2))) == found.U


def test_scatter_beyond_the_stated_u_is_in_U():
    scattered = np.array([0.0, 1.0, -1.0, 1.0, -1.0, 0.0])
    small, large = (drift(YEARS, scattered, u * ONES, NEVER) for u in (0.01, 1.0))
    assert small is not None
    assert large is not None
    assert small.U > 0.5
    assert small.per_year == pytest.approx(large.per_year)


def test_it_covers_the_slope_as_often_as_it_says():
    rng = np.random.default_rng(1)
    inside = 0
    for _ in range(1000):
        found = drift(YEARS, rng.normal(0.3 * YEARS, 0.1), 0.1 * ONES, NEVER)
        assert found is not None
        inside += abs(found.per_year - 0.3) <= found.U
    assert inside > 940


@pytest.mark.parametrize(("count", "adjusted"), [(0, []), (1, [0]), (2, [0, 1])])
def test_what_leaves_nothing_to_compare_has_no_drift(count, adjusted):
    numbers = np.array(adjusted, int)
    assert drift(YEARS[:count], ONES[:count], ONES[:count], numbers) is None
    days = np.zeros(count)
    assert drift(days, ONES[:count], ONES[:count], 0 * numbers) is None


def test_a_reading_without_u_is_left_out():
    u = np.array([0.1, 0.1, np.nan, 0.1, 0.0, 0.1])
    found = drift(YEARS, YEARS, u, NEVER)
    assert found is not None
    assert found.readings == 4


# Golden units: a station that changed is seen against its own history, which it does not move.

NOISE = np.random.default_rng(7).standard_normal(200)


def test_a_station_that_shifts_after_its_history_is_out_of_control():
    values = NOISE[: HISTORY + 10].copy()
    values[HISTORY:] += 4.0
    chart = station_check(values)
    assert chart is not None
    assert chart.broken[:, HISTORY:].any(axis=0).all()
    before = station_check(values[:HISTORY])
    assert before is not None
    assert chart.limits == before.limits  # later values move no limit


def test_a_short_history_has_no_limits():
    assert station_check(NOISE[: FEWEST - 1]) is None
    assert station_check(NOISE[:FEWEST]) is not None
