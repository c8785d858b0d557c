"""A recording with its unit's errors taken off, where not every row can be corrected."""

from dataclasses import replace

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.calibrate.calibrate import calibrate
from tasks.coefficients.correct import coefficients
from tasks.specifications.jjf2003 import JJF2003
from tasks.stages.correct import corrected_recording

BIASED = {"G": np.full((3, 3), 1e-5), "P": 1e-3 * (1.0 - np.eye(3))}


def without_accel(recording: Recording, rows: slice) -> Recording:
    columns = {name: values.copy() for name, values in recording.imu.columns.items()}
    for name in ACCEL:
        columns[name][rows] = np.nan
    return replace(recording, imu=Stream(recording.imu.t, columns))


def test_rows_that_lack_what_they_are_corrected_by_are_left_out(ideal_run):
    recording = ideal_run(dwell=2.0, **BIASED)
    calibration = calibrate(JJF2003, recording, run="r", code_version="v")
    known, _, _ = coefficients(calibration)
    made = corrected_recording(without_accel(recording, slice(5, 8)), known, calibration)
    np.testing.assert_array_equal(made.imu.t, np.delete(recording.imu.t, [5, 6, 7]))
    assert np.isfinite(made.imu.stack(GYRO + ACCEL)).all()
    np.testing.assert_array_equal(made.imu.columns["temperature"], 28.0)


def test_a_recording_of_one_triad_alone_is_refused(ideal_run):
    recording = ideal_run(dwell=2.0, **BIASED)
    calibration = calibrate(JJF2003, recording, run="r", code_version="v")
    known, _, _ = coefficients(calibration)
    with pytest.raises(Unusable, match="give a recording that has both"):
        corrected_recording(without_accel(recording, slice(None)), known, calibration)
