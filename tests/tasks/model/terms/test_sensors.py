"""What gyros and accelerometers read beyond models (1) and (2), row by row."""

import numpy as np
import pytest

from tasks.model.term import Term
from tasks.model.terms.accelerometer import (
    VIBRATION_RECTIFICATION,
    accel_nonlinearity,
    converter_nonlinearity,
    rectification_of_speed,
)
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
from tests.tasks.model.table_run import GRAVITY, T, motion, read, recording

# What a gyro reads beyond model (1), row by row.

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


# What an accelerometer reads beyond model (2), row by row.


@pytest.mark.parametrize("order", [2, 3])
def test_nonlinearity_is_a_share_of_g_at_one_g(order):
    change = read((accel_nonlinearity(order),), THREE) - read((), [])
    assert change[:, 3:] == pytest.approx(THREE * GRAVITY * RUN.up**order)
    assert not change[:, :3].any()


@pytest.mark.parametrize("order", [4, 5, 6, 7])
def test_a_converter_errs_up_and_down_along_the_range_of_each_axis(order):
    change = read((converter_nonlinearity(order),), THREE) - read((), [])
    along = np.arccos(RUN.up / np.abs(RUN.up).max(axis=0))
    assert change[:, 3:] == pytest.approx(THREE * GRAVITY * np.cos(order * along), abs=1e-12)
    assert not change[:, :3].any()


def test_rectification_follows_the_power_of_the_vibration():
    change = read((VIBRATION_RECTIFICATION,), THREE) - read((), [])
    assert change[:, 3:] == pytest.approx(np.outer(RUN.recorded["vibration"], THREE))
    assert not change[:, :3].any()


@pytest.mark.parametrize("exponent", [1.0, 2.5])
def test_rectification_of_what_is_not_seen_follows_a_power_of_the_speed(exponent):
    top = np.abs(RUN.rate).max()
    for of_all in (True, False):
        speeds = np.repeat(np.linalg.norm(RUN.rate, axis=1)[:, None], 3, axis=1)
        speeds = speeds if of_all else np.abs(RUN.rate)
        change = read((rectification_of_speed(of_all, exponent),), THREE) - read((), [])
        assert change[:, 3:] == pytest.approx((speeds / top) ** exponent * THREE)
        assert not change[:, :3].any()
