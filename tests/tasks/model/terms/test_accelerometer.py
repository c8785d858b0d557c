"""What an accelerometer reads beyond model (2), row by row."""

import numpy as np
import pytest

from tasks.model.terms.accelerometer import (
    VIBRATION_RECTIFICATION,
    accel_nonlinearity,
    converter_nonlinearity,
    rectification_of_speed,
)
from tests.tasks.model.table_run import GRAVITY, motion, read

RUN = motion()
THREE = np.array([1e-3, -2e-3, 3e-3])


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
