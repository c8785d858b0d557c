"""What the place adds, against its definition."""

import numpy as np
import pytest

from tasks.model.terms.site import GRAVITY_VALUE, earth_rotation
from tests.tasks.model.table_run import LATITUDE, attitude, motion, read

EARTH = 7.292115e-5  # rad/s, WGS 84


def test_earths_rate_is_felt_along_the_pole():
    pole = np.array([0.0, np.cos(LATITUDE), np.sin(LATITUDE)])
    added = read((earth_rotation(LATITUDE),), []) - read((), [])
    assert added[:, :3] == pytest.approx(EARTH * (attitude() * pole[:, None]).sum(axis=1))
    assert not added[:, 3:].any()


def test_more_gravity_is_felt_upwards():
    added = read((GRAVITY_VALUE,), [0.01]) - read((), [])
    assert added[:, 3:] == pytest.approx(0.01 * motion().up)
    assert not added[:, :3].any()
