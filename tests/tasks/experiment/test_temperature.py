"""A unit follows the chamber by its own time constant, the chamber goes no faster than it can."""

from dataclasses import replace

import numpy as np
import pytest

from schemas.laboratory import ChamberLimits
from schemas.recording import Recording, Stream
from tasks.experiment.track import USUAL_LAG, ThermalResponse
from tests.tasks.experiment.test_track import MANIFEST

FAST = ChamberLimits(temperature_degc=(0.0, 50.0), rate_k_min=6000.0)
SLOW = ChamberLimits(temperature_degc=(0.0, 50.0), rate_k_min=6.0)
T = np.arange(0.0, 600.0, 0.1)


def recorded(degc: np.ndarray) -> Recording:
    noise = np.random.default_rng(1).normal(scale=0.02, size=len(T))
    return Recording(MANIFEST, Stream(T, {"temperature": degc + noise}))


def test_the_time_constant_is_that_of_the_warm_up():
    found = ThermalResponse.of(recorded(30.0 - 8.0 * np.exp(-T / 200.0)), SLOW)
    assert found is not None
    assert found.lag_s == pytest.approx(200.0, rel=0.1)
    assert found.temperatures(T, []) == pytest.approx(30.0 - 8.0 * np.exp(-T / 200.0), abs=0.2)


def test_a_unit_that_is_warm_tells_none():
    found = ThermalResponse.of(recorded(np.full(len(T), 30.0)), SLOW)
    assert found is not None
    assert found.lag_s == USUAL_LAG


def test_a_unit_without_a_thermometer_is_not_heated():
    bare = replace(recorded(T), imu=Stream(T, {"gyro_x": T}))
    assert ThermalResponse.of(bare, SLOW) is None


def test_the_unit_goes_by_as_much_as_the_air_in_its_time_constant():
    response = ThermalResponse(28.0, 0.0, 100.0, 20.0, FAST)
    series = response.temperatures(T, [(100.0, 30.0)])
    assert series[T < 100.0] == pytest.approx(28.0)
    assert float(series[T >= 200.0][0]) == pytest.approx(28.0 + 10.0 * (1 - np.exp(-1)), abs=0.05)


def test_slow_air_is_followed_late_and_turns_back_from_where_it_got():
    response = ThermalResponse(20.0, 0.0, 1.0, 20.0, SLOW)
    series = response.temperatures(T, [(100.0, 40.0), (160.0, 20.0)])
    assert series.max() == pytest.approx(26.0, abs=0.2)
    assert float(series[-1]) == pytest.approx(20.0, abs=0.01)
