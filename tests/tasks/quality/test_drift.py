"""Drift of a coefficient: the slope that was put in, with a U that covers it."""

import numpy as np
import pytest

from tasks.quality.charts import drift

YEARS = np.array([0.0, 0.5, 1.0, 1.6, 2.0, 3.0])
ONES = np.ones(6)
NEVER = np.zeros(6, int)


def test_a_line_is_its_slope_and_an_adjustment_moves_the_level_alone() -> None:
    adjusted = np.array([0, 0, 0, 1, 1, 1])
    found = drift(YEARS, 5.0 + 0.2 * YEARS - 4.0 * adjusted, 0.1 * ONES, adjusted)
    assert found is not None
    assert found.per_year == pytest.approx(0.2)
    assert found.readings == 6


def test_a_steady_unit_has_the_u_of_its_readings() -> None:
    found = drift(YEARS, ONES, 0.1 * ONES, NEVER)
    assert found is not None
    assert found.per_year == pytest.approx(0.0, abs=1e-12)
    assert pytest.approx(2 * 0.1 / np.sqrt(np.sum((YEARS - YEARS.mean()) ** 2))) == found.U


def test_scatter_beyond_the_stated_u_is_in_U() -> None:
    scattered = np.array([0.0, 1.0, -1.0, 1.0, -1.0, 0.0])
    small, large = (drift(YEARS, scattered, u * ONES, NEVER) for u in (0.01, 1.0))
    assert small is not None
    assert large is not None
    assert small.U > 0.5
    assert small.per_year == pytest.approx(large.per_year)


def test_an_uncertain_reading_counts_for_little() -> None:
    u = np.array([0.01, 0.01, 0.01, 0.01, 0.01, 10.0])
    found = drift(YEARS, np.where(u > 1, 50.0, YEARS), u, NEVER)
    assert found is not None
    assert found.per_year == pytest.approx(1.0, rel=1e-3)


def test_it_covers_the_slope_as_often_as_it_says() -> None:
    rng = np.random.default_rng(1)
    inside = 0
    for _ in range(1000):
        found = drift(YEARS, rng.normal(0.3 * YEARS, 0.1), 0.1 * ONES, NEVER)
        assert found is not None
        inside += abs(found.per_year - 0.3) <= found.U
    assert inside > 940


@pytest.mark.parametrize(("count", "adjusted"), [(0, []), (1, [0]), (2, [0, 1])])
def test_what_leaves_nothing_to_compare_has_no_drift(count: int, adjusted: list[int]) -> None:
    numbers = np.array(adjusted, int)
    assert drift(YEARS[:count], ONES[:count], ONES[:count], numbers) is None
    days = np.zeros(count)
    assert drift(days, ONES[:count], ONES[:count], 0 * numbers) is None


def test_a_reading_without_u_is_left_out() -> None:
    u = np.array([0.1, 0.1, np.nan, 0.1, 0.0, 0.1])
    found = drift(YEARS, YEARS, u, NEVER)
    assert found is not None
    assert found.readings == 4
