"""Correcting gives what the unit went through, which the tests know from plain algebra."""

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.recording import ACCEL, AXES, GYRO, Recording
from tasks.coefficients.correct import coefficients, correct
from tasks.coefficients.exports import document
from tasks.specifications.jjf2003 import JJF2003
from tests.tasks.items_only import items_only

GRAVITY = 9.78  # of the ideal run
RNG = np.random.default_rng(5)
UNIT = {
    "Kg": np.eye(3) + 3e-3 * RNG.standard_normal((3, 3)), "Bg": 1e-3 * RNG.standard_normal(3),
    "G": 1e-5 * RNG.standard_normal((3, 3)), "Ka": np.eye(3) + 3e-3 * RNG.standard_normal((3, 3)),
    "Ba": 0.02 * RNG.standard_normal(3), "P": 1e-3 * (1 - np.eye(3)) * RNG.standard_normal((3, 3)),
}  # fmt: skip
NAMES = {"Kg": "gyro_matrix", "Bg": "gyro_bias", "G": "gyro_g_sensitivity", "Ka": "accel_matrix",
         "Ba": "accel_bias", "P": "accel_rate_sensitivity"}  # fmt: skip


def truth(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Rate and specific force of every row, by the labels."""
    rate, force = np.zeros((2, len(recording.imu), 3))
    for segment in recording.manifest.segments:
        rows = recording.imu.rows(segment.t_start, segment.t_end)
        force[rows, AXES.index(segment.up[1])] = GRAVITY if segment.up[0] == "+" else -GRAVITY
        if segment.axis:
            rate[rows, AXES.index(segment.axis)] = np.radians(segment.rate_deg_s)
    return rate, force


@pytest.fixture(scope="module")
def recording(ideal_run) -> Recording:
    return ideal_run(dwell=5.0, **UNIT)


@pytest.fixture(scope="module")
def calibration(recording):
    return items_only(JJF2003, recording)


def test_each_coefficient_is_the_units_own_within_its_uncertainty(calibration):
    """The clauses turn one axis at a time, which leaves P of second order in what they fit."""
    known, expanded, assumed = coefficients(calibration)
    assert assumed == ()
    for short, name in NAMES.items():
        value, U = getattr(known, name), getattr(expanded, name)
        given = np.isfinite(U)
        assert given.sum() == (6 if short == "P" else value.size)
        assert (np.abs(value - UNIT[short])[given] <= U[given]).all(), short


def test_corrected_readings_are_what_the_unit_went_through(recording, calibration):
    known, _, _ = coefficients(calibration)
    rate, force = correct(known, recording.imu.stack(GYRO), recording.imu.stack(ACCEL))
    true_rate, true_force = truth(recording)
    np.testing.assert_allclose(rate, true_rate, atol=2e-6)
    np.testing.assert_allclose(force, true_force, atol=2e-5)


def test_a_reading_without_what_it_is_corrected_by_is_null(recording, calibration):
    known, _, _ = coefficients(calibration)
    gyro, accel = recording.imu.stack(GYRO)[:4], recording.imu.stack(ACCEL)[:4].copy()
    accel[1] = np.nan
    rate, force = correct(known, gyro, accel)
    assert np.isnan(rate[1]).all()
    assert np.isnan(force[1]).all()
    assert np.isfinite(rate[[0, 2, 3]]).all()


def test_earths_rotation_is_left_in_the_corrected_rate(plant):
    """Eq. (7) counts it as g-sensitivity; a corrected gyro at rest reads it."""
    recording = plant("plant_earth_rotation", 4)
    calibration = items_only(JJF2003, recording)
    known, _, _ = coefficients(calibration)
    item = calibration.items["gyro_g_sensitivity"]
    by_clause = np.radians(item.value["xx"]) / recording.manifest.station.gravity_m_s2
    up = [s for s in calibration.segments if s.kind == "static" and s.up == "+z"]
    rests = [recording.imu.rows(s.t_start, s.t_end) for s in up]
    gyro = np.array([recording.imu.stack(GYRO, rows).mean(axis=0) for rows in rests])
    accel = np.array([recording.imu.stack(ACCEL, rows).mean(axis=0) for rows in rests])
    earth = 7.292115e-5 * np.sin(np.radians(recording.manifest.station.latitude_deg))
    assert correct(known, gyro, accel)[0][:, 2].mean() == pytest.approx(earth, abs=6e-6)
    assert abs(by_clause - known.gyro_g_sensitivity[0, 0]) > 4e-6


def test_elements_without_a_value_are_ideal_and_named(real):
    calibration = items_only(JJF2003, real("ln100_two_position"))
    made = document(calibration, None)
    assert "gyro_g_sensitivity xy" in made.assumed_ideal
    assert made.coefficients["G"].value[0][1] == 0.0
    assert made.coefficients["G"].U[0][1] is None
    assert made.unit is None


def test_a_calibration_that_names_no_gravity_is_refused(calibration):
    without = calibration.model_copy(update={"settings": {"gravity_m_s2": None}})
    with pytest.raises(Unusable, match="gravity_m_s2 is None"):
        coefficients(without)
