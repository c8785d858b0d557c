"""The simulated units feel what the virtual station's units feel."""

import numpy as np
import pytest

from tasks.station.virtual.config import DEGREE, EARTH_RATE_RAD_S
from tasks.validation import run1536, run2003
from tasks.validation.simulated_units import (
    GRAVITY,
    LATITUDE,
    Journey,
    SimulatedUnit,
    Site,
    TableErrors,
    draw_simulated_unit,
    sensed_rates,
)

SITE = Site(GRAVITY, LATITUDE)


def perfect(simulated: SimulatedUnit) -> SimulatedUnit:
    """A unit without errors."""
    unit = simulated.unit
    ideal = {"scale": np.eye(3).tolist(), "bias": (0.0, 0.0, 0.0)}
    changed = {
        "gyro": unit.gyro.model_copy(update=ideal),
        "accel": unit.accel.model_copy(update=ideal),
        "g_sensitivity": np.zeros((3, 3)).tolist(),
        "places_m": np.zeros((3, 3)).tolist(),
    }
    return SimulatedUnit(unit.model_copy(update=changed), simulated.random, ideal=True)


def held(rate_deg_s: float, errors: TableErrors) -> np.ndarray:
    """What a perfect unit reads, z up, turning at a steady rate; (6, n)."""
    simulated = perfect(draw_simulated_unit(1, 20.0))
    journey = Journey(20.0)
    journey.place(0.0, 0.0, 0.0, np.zeros(3))
    journey.change_rate(rate_deg_s * DEGREE)
    journey.stay(36.0, {"name": "held"})
    read = sensed_rates(journey.track(), errors, SITE, simulated.unit, None)
    segment = journey.segments[0]
    t = np.arange(read.shape[1]) / 20.0
    return read[:, (t >= segment["t_start"]) & (t < segment["t_end"])]


def test_a_rest_feels_earth_and_gravity():
    north, up = np.cos(LATITUDE), np.sin(LATITUDE)
    expected = [0.0, EARTH_RATE_RAD_S * north, EARTH_RATE_RAD_S * up, 0.0, 0.0, GRAVITY]
    assert held(0.0, TableErrors()).mean(axis=1) == pytest.approx(expected, abs=1e-12)


def test_a_rate_wrong_by_a_part_is_felt_wrong_by_it():
    wrong = held(100.0, TableErrors(rate=1e-3)).mean(axis=1)
    right = held(100.0, TableErrors()).mean(axis=1)
    assert wrong[2] - right[2] == pytest.approx(1e-3 * 100.0 * DEGREE, rel=1e-9)


def test_ripple_comes_back_every_turn_and_averages_out():
    read = held(100.0, TableErrors(ripple=5e-4, phase=0.3))
    calm = held(100.0, TableErrors())
    ripple = read[2] - calm[2]
    assert ripple.mean() == pytest.approx(0.0, abs=1e-9)
    assert ripple.max() == pytest.approx(5e-4 * 100.0 * DEGREE, rel=0.02)


def test_a_leaning_axis_is_felt_at_rest_and_averages_out_turning():
    leaning = TableErrors(level=(1e-3, 0.0))
    assert held(0.0, leaning)[4].mean() == pytest.approx(GRAVITY * 1e-3, rel=1e-3)
    assert held(100.0, leaning)[4].mean() == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("run", [run2003, run1536])
def test_the_same_seed_gives_the_same_recording(run):
    first, second = (run.record(draw_simulated_unit(5, run.RATE_HZ))[0] for _ in range(2))
    for name, values in first.imu.columns.items():
        assert (values == second.imu.columns[name]).all()
    other = run.record(draw_simulated_unit(6, run.RATE_HZ))[0]
    assert any((v != other.imu.columns[n]).any() for n, v in first.imu.columns.items())
