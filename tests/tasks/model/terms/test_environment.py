"""What follows the surroundings, row by row."""

import numpy as np
import pytest

from tasks.model.term import Term
from tasks.model.terms.environment import (
    SUPPLY_SENSITIVITY,
    TEMPERATURE_BIAS,
    TEMPERATURE_SCALE,
    THERMAL_GRADIENT,
    late_temperature_bias,
    thermal_transient,
)
from tasks.model.terms.magnetic import candidates, magnetic_sensitivity
from tests.tasks.model.table_run import T, attitude, motion, read, recording

RUN = motion()
SIX = 1e-4 * np.array([1.0, -2.0, 3.0, 20.0, -10.0, 5.0])


def added(term: Term, values: np.ndarray) -> np.ndarray:
    return read((term,), values.ravel()) - read((), [])


def test_each_channels_bias_follows_its_own_course():
    warmer = RUN.recorded["temperature"] - 25.0
    assert added(TEMPERATURE_BIAS, SIX) == pytest.approx(np.outer(warmer, SIX))
    assert added(THERMAL_GRADIENT, SIX) == pytest.approx(np.outer(1e-3 * T, SIX), abs=1e-12)
    volts = 0.05 * (np.sin(T) - np.sin(T).mean())
    assert added(SUPPLY_SENSITIVITY, SIX) == pytest.approx(np.outer(volts, SIX), abs=1e-12)


def test_each_channels_scale_follows_the_temperature():
    ideal = np.hstack([RUN.rate, 9.8 * RUN.up])
    expected = ideal * np.outer(0.2 * T - 3.0, SIX)
    assert added(TEMPERATURE_SCALE, SIX) == pytest.approx(expected, abs=1e-12)


def test_a_bias_may_follow_the_temperature_late():
    warm = RUN.recorded["temperature"]
    late, step = [warm[0]], T[1] - T[0]
    for now in warm[1:]:
        late.append(late[-1] + (1.0 - np.exp(-step / 3.0)) * (now - late[-1]))
    assert added(late_temperature_bias(3.0), SIX) == pytest.approx(
        np.outer(np.array(late) - 25.0, SIX), abs=1e-12
    )


def test_a_warm_up_fades_from_the_start_of_the_run():
    term = thermal_transient(8.0)
    assert added(term, SIX) == pytest.approx(np.outer(np.exp(-T / 8.0), SIX))
    assert added(term.shaped((2.0,)), SIX) == pytest.approx(np.outer(np.exp(-T / 2.0), SIX))


def test_earths_field_is_that_of_a_dipole_down_and_north():
    latitude = np.radians(40.0)
    field = 31.2e-6 * np.array([0.0, np.cos(latitude), -2.0 * np.sin(latitude)])
    body = np.einsum("nji,j->ni", attitude(), field)
    matrix = np.arange(1.0, 10.0).reshape(3, 3)
    change = added(magnetic_sensitivity(latitude), matrix)
    assert change[:, :3] == pytest.approx(body @ matrix.T)
    assert not change[:, 3:].any()


def test_magnetic_north_may_stand_elsewhere():
    field = 31.2e-6 * np.cos(0.7) * np.array([np.sin(0.3), np.cos(0.3), 0.0])
    field -= 31.2e-6 * 2.0 * np.sin(0.7) * np.eye(3)[2]
    body = np.einsum("nji,j->ni", attitude(), field)
    change = added(magnetic_sensitivity(0.7, azimuth=0.3), np.eye(3))
    assert change[:, :3] == pytest.approx(body)


def test_a_latitude_that_is_not_told_is_said_to_be_taken():
    assert "taken" in candidates(recording(None), RUN)[0].equation
    assert "taken" not in candidates(recording(), RUN)[0].equation
