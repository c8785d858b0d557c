"""Capability indices, by the definitions of the handbook and by simulation."""

import numpy as np
import pytest

from tasks.quality import capability, dof_within, sigma_within


@pytest.fixture
def rng() -> np.random.Generator:
    """The same draws for each test, in whatever order they come."""
    return np.random.default_rng(4)


def stretched(values: np.ndarray, mean: float, sd: float) -> np.ndarray:
    """The values at exactly this mean and standard deviation."""
    return np.asarray(mean + sd * (values - values.mean()) / values.std(ddof=1))


def test_performance_is_that_of_the_handbooks_example(rng):
    # NIST/SEMATECH e-Handbook, 6.1.6: limits 8 and 20, mean 16, sigma 2: Cp 1.0, Cpk 0.6667
    found = capability(stretched(rng.standard_normal(50), 16.0, 2.0), 8.0, 20.0)
    assert found.pp.value == pytest.approx(1.0)
    assert found.ppk.value == pytest.approx(2.0 / 3.0)
    upper = capability(stretched(rng.standard_normal(50), 16.0, 2.0), None, 20.0)
    assert upper.ppk.value == pytest.approx(0.6667, abs=1e-4)
    assert capability(stretched(rng.standard_normal(50), 16.0, 2.0), 8.0, None).ppk.value == (
        pytest.approx(1.3333, abs=1e-4)
    )


def test_one_sided_limits_have_no_two_sided_index(rng):
    found = capability(rng.standard_normal(30), None, 3.0)
    assert found.cp.value is None
    assert found.pp.value is None
    assert found.cpk.value is not None
    assert capability(rng.standard_normal(30), None, None).cpk.value is None


def test_a_shift_between_neighbours_is_in_performance_and_not_in_capability(rng):
    values = np.concatenate([rng.standard_normal(200), 6.0 + rng.standard_normal(200)])
    found = capability(values, -10.0, 16.0)
    assert found.cp.value == pytest.approx(26.0 / 6.0, rel=0.1)
    assert found.pp.value == pytest.approx(26.0 / 6.0 / np.sqrt(10.0), rel=0.1)


@pytest.mark.parametrize("n", [10, 60])
def test_moving_ranges_have_the_degrees_of_freedom_that_are_counted(n, rng):
    draws = np.array([sigma_within(row) for row in rng.standard_normal((4000, n))])
    assert draws.mean() == pytest.approx(1.0, abs=0.01)
    assert 1.0 / (2.0 * draws.var()) == pytest.approx(dof_within(n), rel=0.1)


@pytest.mark.parametrize("n", [25, 100])
def test_intervals_hold_the_index_as_often_as_stated(n):
    held = {"cp": 0, "cpk": 0, "pp": 0, "ppk": 0}
    truth = {"cp": 4.0 / 3.0, "cpk": 1.0, "pp": 4.0 / 3.0, "ppk": 1.0}
    for row in np.random.default_rng(n).standard_normal((600, n)):
        found = capability(row, -5.0, 3.0)
        for name, true in truth.items():
            index = getattr(found, name)
            held[name] += index.low <= true <= index.high
    for name, count in held.items():
        assert 0.92 <= count / 600 <= 0.98, name


def test_one_value_or_none_has_no_index():
    assert capability(np.array([]), -1.0, 1.0).mean is None
    assert capability(np.array([0.5]), -1.0, 1.0).ppk.value is None
    assert capability(np.zeros(5), -1.0, 1.0).cp.value is None
