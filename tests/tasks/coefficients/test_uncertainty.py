"""The uncertainty of corrected readings, against true readings of simulated units and by draws."""

from dataclasses import fields

import numpy as np
import pytest

from schemas.calibration import Calibration
from tasks.calibrate.calibrate import evaluation_for, without_information
from tasks.coefficients.correct import (
    Coefficients,
    ReadingUncertainty,
    coefficients,
    correct,
    reading_uncertainty,
)
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.joint import JOINT
from tasks.validation.coverage import simulate
from tasks.validation.run2003 import RATE_HZ
from tasks.validation.simulated_units import draw_simulated_unit
from tests.tasks.items_only import items_only

UNITS, READINGS = 20, 8
NORMAL_95 = 1.959964
DRAWS = 4000
RNG = np.random.default_rng(20)
RATE = np.radians(RNG.uniform(-200.0, 200.0, (READINGS, 3)))
FORCE = RNG.uniform(-12.0, 12.0, (READINGS, 3))


def uncertainty_of(calibration: Calibration) -> tuple[Coefficients, ReadingUncertainty]:
    known, _, _ = coefficients(calibration)
    found = reading_uncertainty(calibration, known)
    assert found is not None
    return known, found


@pytest.mark.parametrize(
    "specification", [JJF2003, pytest.param(JOINT, marks=pytest.mark.rehearsal)]
)
def test_corrected_readings_of_simulated_units_lie_about_the_truth_as_their_u_says(specification):
    """What each unit reads of another motion is plain algebra of its true parameters."""
    z = []
    for seed in range(700, 700 + UNITS):
        recording, _ = simulate(specification.method, seed)
        evidence = specification.gather(recording)
        made = without_information(specification, evidence, evaluation_for(recording))
        known, uncertainty = uncertainty_of(made)
        unit = draw_simulated_unit(seed, RATE_HZ).unit
        gyro = RATE @ np.array(unit.gyro.scale).T + unit.gyro.bias
        gyro += FORCE @ np.array(unit.g_sensitivity).T
        accel = FORCE @ np.array(unit.accel.scale).T + unit.accel.bias
        accel += RATE**2 @ np.array(unit.rate_sensitivity_m).T
        rate, force = correct(known, gyro, accel)
        u = uncertainty.of_rows(rate, force)
        z.append(np.hstack([rate - RATE, force - FORCE]) / u)
    assert 0.9 < np.sqrt(np.mean(np.square(z))) < 1.1
    assert 0.93 < np.mean(np.abs(z) < NORMAL_95) < 0.97


@pytest.fixture(scope="module")
def joint(plant) -> Calibration:
    return items_only(JOINT, plant("plant_lever_arm", 4))


def test_the_rms_is_that_of_the_rows_whatever_their_number(joint):
    known, uncertainty = uncertainty_of(joint)
    rate, force = RNG.standard_normal((2, 10_001, 3))
    rate[7] = np.nan
    u = uncertainty.of_rows(rate, force)
    assert np.isnan(u[7]).all()
    rms = np.sqrt(np.nanmean(u**2, axis=0))
    assert list(uncertainty.rms(rate, force).values()) == pytest.approx(rms)
    assert all(np.isfinite(getattr(known, each.name)).all() for each in fields(known))


def test_a_channel_of_which_an_element_is_taken_as_ideal_has_no_uncertainty(real):
    found = items_only(JJF2003, real("vn200_57630_six_position"))
    _, uncertainty = uncertainty_of(found)
    assert set(uncertainty.unknown) >= {"gyro_x", "gyro_y", "gyro_z"}
    u = uncertainty.of_rows(RATE, FORCE)
    assert np.isnan(u[:, :3]).all()
    assert uncertainty.rms(RATE, FORCE).keys().isdisjoint(uncertainty.unknown)


def test_a_result_without_a_covariance_gives_no_uncertainty(joint):
    known, _ = uncertainty_of(joint)
    without = joint.model_copy(update={"covariance": None})
    assert reading_uncertainty(without, known) is None
