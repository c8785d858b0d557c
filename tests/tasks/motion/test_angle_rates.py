"""Angles of an AHRS as mean rates: each interval's gain, and nothing where it cannot be told."""

import numpy as np
import pytest

from schemas.recording import ANGLE, GYRO, Recording, Stream
from tasks.explain.channels import CHANNELS
from tasks.motion.angle_rates import as_mean_rates
from tests.manifests import manifest_of

T = np.arange(0.0, 20.0, 0.1)
MANIFEST = manifest_of("ahrs")


def ahrs(angle: np.ndarray, t: np.ndarray = T) -> Recording:
    columns = dict(zip(ANGLE, np.outer(np.array([1.0, -0.5, 0.0]), angle), strict=True))
    return Recording(MANIFEST, Stream(t, columns | {"accel_z": 9.8 + t}))


def test_rates_are_what_each_interval_gained_and_stand_in_its_middle() -> None:
    rates = as_mean_rates(ahrs(0.1 * T**2)).imu
    assert rates.span == pytest.approx(0.1)
    assert rates.t == pytest.approx(T[:-1] + 0.05)
    assert rates.columns["gyro_x"] == pytest.approx(0.2 * rates.t)
    assert rates.columns["gyro_y"] == pytest.approx(-0.1 * rates.t)
    assert rates.columns["accel_z"] == pytest.approx(9.8 + rates.t)
    assert not set(ANGLE) & set(rates.columns)


def test_nothing_is_told_where_angles_began_anew_or_samples_were_lost() -> None:
    restarted = as_mean_rates(ahrs(np.where(T < 9.95, 50.0 + T, T - 10.0))).imu
    assert np.flatnonzero(np.isnan(restarted.columns["gyro_x"])).tolist() == [99]
    kept = np.delete(np.arange(len(T)), [50, 51])
    lost = as_mean_rates(ahrs(T[kept], T[kept])).imu
    assert np.flatnonzero(np.isnan(lost.stack(GYRO)).any(axis=1)).tolist() == [49]


def test_a_unit_that_gives_rates_is_read_by_them() -> None:
    recording = ahrs(T)
    columns = dict.fromkeys(CHANNELS, np.zeros(len(T)))
    both = Recording(MANIFEST, Stream(T, {**recording.imu.columns, **columns}))
    assert as_mean_rates(both) is both
