"""Moves by hand: increments of a cone, and which gyro reads Earth's rotation."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from test_joint_by_gravity import GRAVITY, K_GYRO, by_joint, held_by_hand

from schemas.recording import AXES
from tasks.motion.table import EARTH_RATE
from tasks.specifications.joint.moves import _increments

DEG = np.degrees(1.0)


def test_increments_of_a_rate_that_turns_are_those_of_the_attitude():
    """A rate of steady slope across itself, integrated finely by scipy, against one step."""
    start, end, step = np.array([0.8, 0.0, 0.1]), np.array([0.0, 0.9, 0.1]), 0.1
    fine = 4000
    share = (np.arange(fine) + 0.5) / fine
    attitude = Rotation.identity()
    for each in start + (end - start) * share[:, None]:
        attitude = attitude * Rotation.from_rotvec(each * step / fine)
    (one,) = _increments(np.array([0.0, step]), np.array([start, end]))
    coning = np.linalg.norm(np.cross(start, end)) * step**2 / 12.0
    assert one == pytest.approx(attitude.as_rotvec(), abs=0.02 * coning)


def test_the_gyro_that_reads_the_vertical_part_is_given_less_of_it():
    """The run has no Earth in it: what is taken off is K·ωe·sin φ, by row the gyro that reads."""
    without = by_joint(held_by_hand(latitude_deg=None)).items["gyro_g_sensitivity"].value
    at = by_joint(held_by_hand(latitude_deg=60.0)).items["gyro_g_sensitivity"].value
    earth = EARTH_RATE * np.sin(np.radians(60.0)) * DEG
    for i, a in enumerate(AXES):
        for j, b in enumerate(AXES):
            taken = (without[a + b] - at[a + b]) / earth
            assert taken == pytest.approx(K_GYRO[i, j], abs=5e-4)


def test_a_gravity_told_wrong_scales_the_accelerometer_as_its_budget_says():
    right = by_joint(held_by_hand()).items
    wrong = by_joint(held_by_hand(gravity_m_s2=GRAVITY + 0.01)).items
    for name in ("accel_scale_factor", "accel_cross_coupling"):
        for element, budget in right[name].budgets.items():
            (line,) = [each for each in budget.inputs if each.symbol == "g"]
            change = wrong[name].value[element] - budget.value
            assert change == pytest.approx(0.01 * line.sensitivity, rel=5e-3, abs=2e-8)
