"""Rates of an AHRS that outputs angles only: the angle gained in each interval, over its time.

The angle about each axis of the unit is the integral of what its gyro feels, so that its increment
is the mean rate between two readings, whatever the rate did in between. White noise of the rate
stays white; the rounding of an angle is shared by two neighbours with opposite signs, so that the
differences noise is read off show it as larger than it is in any mean.
"""

from dataclasses import replace

import numpy as np

from schemas.recording import ANGLE, GYRO, Recording, Stream
from tasks.motion.samples import sample_interval

UNEVEN = 0.5  # of an interval: a step that differs by more is not one of them
HALF_TURN = np.pi  # rad: a larger increment is a restart, a wrap or more than can be told


def gives_angles(recording: Recording) -> bool:
    """Whether angles are all that the unit says of its turning."""
    columns = set(recording.imu.columns)
    return set(ANGLE) <= columns and not set(GYRO) & columns


def as_mean_rates(recording: Recording) -> Recording:
    """The recording with gyro_* (rad/s) in place of angles, one row in the middle of each interval.

    Other columns are the mean of both ends. NaN where samples were lost between two readings and
    where an angle was reset. A recording with rates is returned unchanged.
    """
    imu = recording.imu
    if not gives_angles(recording) or len(imu) < 2:
        return recording
    span, steps = sample_interval(imu.t), np.diff(imu.t)
    gained = np.diff(imu.stack(ANGLE), axis=0)
    whole = (np.abs(steps - span) < UNEVEN * span) & (np.abs(gained) < HALF_TURN).all(axis=1)
    rates = np.where(whole[:, None], gained / steps[:, None], np.nan)
    columns = {
        name: np.where(whole, 0.5 * (values[1:] + values[:-1]), np.nan)
        for name, values in imu.columns.items()
        if name not in ANGLE
    }
    columns |= dict(zip(GYRO, rates.T, strict=True))
    return replace(recording, imu=Stream(0.5 * (imu.t[1:] + imu.t[:-1]), columns, span))
