"""What smoothing takes off the acceleration of a table shows when it is smoothed again."""

import numpy as np
import pytest

from schemas.recording import Recording, Stream
from tasks.motion.smooth import smooth_course
from tasks.motion.smoothing_error import lost_acceleration
from tests.on_shaft import shaft_manifest

T = np.arange(0.0, 40.0, 0.02)
RAMP, HELD = 0.5, 2.0  # s
TRUE = np.where(T % (2 * (RAMP + HELD)) < RAMP, 2.0, 0.0)
TRUE -= np.where((T - RAMP - HELD) % (2 * (RAMP + HELD)) < RAMP, 2.0, 0.0)
ANGLE = np.cumsum(np.cumsum(TRUE)) * T[1] ** 2


def turned(step: float) -> Recording:
    """A shaft that is ramped up and down, read in steps, rad."""
    read = step * np.round(ANGLE / step) if step else ANGLE
    imu = Stream(T, {"gyro_z": np.zeros(len(T))})
    return Recording(shaft_manifest(0, 0, 1), imu, table=Stream(T, {"a_angle": read}))


def test_smoothing_again_takes_about_what_smoothing_took() -> None:
    recording = turned(2e-3)
    course = smooth_course(recording.table, ("a_angle",))
    assert course is not None
    found = course.acceleration[:, 0]
    # By how much too large what follows the acceleration is found, by both.
    owed = float(found @ (TRUE - found) / (found @ found))
    again = float(found @ lost_acceleration(recording, T)[:, 0] / (found @ found))
    assert owed > 0.05
    assert again == pytest.approx(owed, rel=0.4)


def test_a_fine_encoder_loses_next_to_nothing() -> None:
    lost = lost_acceleration(turned(0.0), T)[:, 0]
    assert abs(float(lost @ TRUE / (TRUE @ TRUE))) < 0.02


def test_nothing_is_lost_where_no_encoder_is_read() -> None:
    recording = turned(0.0)
    assert not lost_acceleration(Recording(recording.manifest, recording.imu), T).any()
