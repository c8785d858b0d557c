"""What an accelerometer reads beyond model (2), row by row."""

import numpy as np
import pytest
from table_run import GRAVITY, motion, read

from tasks.model.terms.accelerometer import VIBRATION_RECTIFICATION, accel_nonlinearity

RUN = motion()
THREE = np.array([1e-3, -2e-3, 3e-3])


@pytest.mark.parametrize("order", [2, 3])
def test_nonlinearity_is_a_share_of_g_at_one_g(order: int) -> None:
    change = read((accel_nonlinearity(order),), THREE) - read((), [])
    assert change[:, 3:] == pytest.approx(THREE * GRAVITY * RUN.up**order)
    assert not change[:, :3].any()


def test_rectification_follows_the_power_of_the_vibration() -> None:
    change = read((VIBRATION_RECTIFICATION,), THREE) - read((), [])
    assert change[:, 3:] == pytest.approx(np.outer(RUN.recorded["vibration"], THREE))
    assert not change[:, :3].any()
