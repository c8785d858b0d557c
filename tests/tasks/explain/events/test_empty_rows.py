"""Rows without readings are left out, those of a unit at rest or on a fast table are not."""

from dataclasses import replace

import numpy as np
import pytest

from schemas.recording import Recording, Stream
from tasks.explain.events.empty_rows import empty_rows, without_empty_rows
from tasks.explain.explain import explain
from tasks.words import texts
from tests.on_shaft import swinging

ROWS = 4000


def at_rest() -> np.ndarray:
    noise = np.random.default_rng(2).standard_normal((ROWS, 6)) * np.repeat([1e-3, 1e-2], 3)
    return np.asarray(noise + np.array([0.0, 0.0, 0.0, 0.1, 0.0, 9.8]))


def with_dropout(recording: Recording) -> Recording:
    """Ten rows of zeros."""
    kept = ~((recording.imu.t >= 30.0) & (recording.imu.t < 30.095))
    columns = {name: kept * signal for name, signal in recording.imu.columns.items()}
    return replace(recording, imu=Stream(recording.imu.t, columns))


@pytest.mark.parametrize("value", [0.0, 1e5, -1e5])
def test_rows_of_zeros_and_of_what_no_unit_reads_are_none(value: float) -> None:
    readings = at_rest()
    readings[1000:1020] = value
    assert np.flatnonzero(empty_rows(readings)).tolist() == list(range(1000, 1020))


def test_gyros_alone_may_read_zero() -> None:
    readings = at_rest()
    readings[:, 3:] = np.nan
    readings[::20, :3] = 0.0
    assert not empty_rows(readings).any()


def test_a_rate_of_a_centrifuge_is_read() -> None:
    readings = at_rest()
    readings[2000:, 2] += 300.0
    assert not empty_rows(readings).any()


def test_a_recording_keeps_its_rows_and_says_which_are_not_used() -> None:
    recording = swinging(0.0)
    torn = with_dropout(recording)
    whole, remarks = without_empty_rows(torn)
    assert len(whole.imu.t) == len(torn.imu.t)
    assert np.isnan(whole.imu.columns["gyro_x"]).sum() == 10
    assert "10" in texts(remarks[0])["en"]
    assert without_empty_rows(recording) == (recording, ())


def test_a_low_pass_is_named_beside_a_dropout_and_an_empty_first_row() -> None:
    torn = with_dropout(swinging(1e-5, low_pass=5.0))
    columns = {name: np.append(0.0, signal[1:]) for name, signal in torn.imu.columns.items()}
    findings = explain(replace(torn, imu=Stream(torn.imu.t, columns))).findings
    assert findings[0].effect == "bandwidth"
