"""What a gyro reads beyond model (1), row by row."""

import numpy as np
import pytest

from tasks.model.term import Term
from tasks.model.terms.gyro import (
    GYRO_ANGULAR_ACCELERATION,
    GYRO_G2_SENSITIVITY,
    GYRO_SCALE_ASYMMETRY,
    GYRO_SCALE_G_DEPENDENCE,
    candidates,
    gyro_dead_band,
    gyro_scale_nonlinearity,
    top_rate,
)
from tests.tasks.model.table_run import T, motion, read, recording

RUN = motion()
W, F = RUN.rate, 9.8 * RUN.up
THREE = np.array([1e-3, -2e-3, 3e-3])
NINE = 1e-4 * np.array([[1.0, -2.0, 3.0], [0.5, 4.0, -1.0], [2.0, 1.0, -3.0]])


def added(term: Term, values: np.ndarray) -> np.ndarray:
    change = read((term,), values.ravel()) - read((), [])
    assert not change[:, 3:].any()
    return change[:, :3]


@pytest.mark.parametrize("order", [2, 3])
def test_nonlinearity_is_a_share_of_the_reading_at_the_top_rate(order):
    at_top = added(gyro_scale_nonlinearity(order, 4.0), THREE)
    assert at_top == pytest.approx(4.0 * THREE * (W / 4.0) ** order)


def test_a_dead_band_takes_its_threshold_off_faster_rates():
    change = added(gyro_dead_band(0.2), THREE)
    assert change[W > 0.2] == pytest.approx((0.2 * np.ones_like(W) * THREE)[W > 0.2])
    assert change[np.abs(W) < 0.2] == pytest.approx((W * THREE)[np.abs(W) < 0.2])
    assert change[W < -0.2] == pytest.approx((-0.2 * np.ones_like(W) * THREE)[W < -0.2])


def test_asymmetry_is_half_the_difference_of_both_signs():
    change = added(GYRO_SCALE_ASYMMETRY, THREE)
    assert change == pytest.approx(np.where(W > 0, THREE, -THREE) * W)


def test_g_squared_and_g_dependence_by_their_sums():
    squares, products = np.zeros((len(T), 3)), np.zeros((len(T), 3))
    for i in range(3):
        for j in range(3):
            squares[:, i] += NINE[i, j] * F[:, j] ** 2
            products[:, i] += NINE[i, j] * W[:, i] * F[:, j]
    assert added(GYRO_G2_SENSITIVITY, NINE) == pytest.approx(squares)
    assert added(GYRO_SCALE_G_DEPENDENCE, NINE) == pytest.approx(products)


def test_angular_acceleration_is_that_of_the_body():
    slope = np.gradient(W, T, axis=0, edge_order=2)
    assert added(GYRO_ANGULAR_ACCELERATION, NINE) == pytest.approx(slope @ NINE.T, abs=1e-12)


def test_the_first_index_is_the_axis_that_reads():
    only_xz = np.zeros((3, 3))
    only_xz[0, 2] = 1e-3
    assert GYRO_G2_SENSITIVITY.parameters[2].name == "M_xz"
    change = added(GYRO_G2_SENSITIVITY, only_xz)
    assert change[:, 0] == pytest.approx(1e-3 * F[:, 2] ** 2)
    assert not change[:, 1:].any()


def test_the_top_rate_is_the_runs_own_to_two_digits():
    top = np.degrees(np.abs(W).max())
    assert np.degrees(top_rate(RUN)) == pytest.approx(top, rel=0.05)
    assert float(f"{np.degrees(top_rate(RUN)):.1e}") == pytest.approx(np.degrees(top_rate(RUN)))
    term = candidates(recording(), RUN)[0]
    assert f"{np.degrees(top_rate(RUN)):.0f} deg/s" in term.equation
