"""Rows without readings are left out, those of a unit at rest or on a fast table are not."""

from dataclasses import replace

import numpy as np
import pytest
from firmware import UNITS, Unit, made

from schemas.recording import Recording, Stream
from storage.formats.folder import read_folder
from tasks.calibrate.calibrate import calibrate
from tasks.explain.explain import explain
from tasks.readings.robust import median
from tasks.readings.rows import (
    empty_remarks,
    empty_rows,
    rows_without_readings,
    without_readings_removed,
)
from tasks.specifications.register import specification_for
from tasks.words import texts
from tests.on_shaft import swinging
from tests.shared import shared_path

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
def test_rows_of_zeros_and_of_what_no_unit_reads_are_none(value):
    readings = at_rest()
    readings[1000:1020] = value
    assert np.flatnonzero(empty_rows(readings)).tolist() == list(range(1000, 1020))


def test_gyros_alone_may_read_zero():
    readings = at_rest()
    readings[:, 3:] = np.nan
    readings[::20, :3] = 0.0
    assert not empty_rows(readings).any()


def test_a_rate_of_a_centrifuge_is_read():
    readings = at_rest()
    readings[2000:, 2] += 300.0
    assert not empty_rows(readings).any()


def test_a_recording_keeps_its_rows_and_says_which_are_not_used():
    recording = swinging(0.0)
    torn = with_dropout(recording)
    empty = rows_without_readings(torn)
    whole = without_readings_removed(torn, empty)
    assert len(whole.imu.t) == len(torn.imu.t)
    assert np.isnan(whole.imu.columns["gyro_x"]).sum() == 10
    (remark,) = empty_remarks(torn.imu.t, empty)
    assert "10" in texts(remark)["en"]
    assert "30.00" in texts(remark)["en"]
    assert not rows_without_readings(recording).any()
    assert empty_remarks(recording.imu.t, np.zeros(3, bool)) == ()


def corrupted_at(recording: Recording, rows: np.ndarray, value: float, triad: str) -> Recording:
    columns = dict(recording.imu.columns)
    for axis in "xyz":
        columns[f"{triad}_{axis}"] = columns[f"{triad}_{axis}"].copy()
        columns[f"{triad}_{axis}"][rows] = value
    return replace(recording, imu=Stream(recording.imu.t, columns))


@pytest.mark.parametrize("seed", range(12))
def test_single_frames_that_were_corrupted_are_found_wherever_they_lie(seed):
    """Other rates, numbers of frames, values and triads, also while the unit turns."""
    rng = np.random.default_rng(seed)
    unit = Unit(rate=float(rng.choice([25.0, 50.0, 100.0, 200.0])), quick=60.0)
    clean = made(unit, seed, None, known=("table", "labels", "neither")[seed % 3]).recording
    rows = np.unique(rng.integers(50, len(clean.imu) - 50, (1, 3, 10, 40)[seed % 4]))
    rows = rows[np.append(True, np.diff(rows) > 8)]
    value, triad = ((-34.906, "gyro"), (34.9, "gyro"), (-78.4, "accel"), (0.0, "accel"))[seed % 4]
    found = rows_without_readings(corrupted_at(clean, rows, value, triad))
    assert set(np.flatnonzero(found)) <= set(rows.tolist())
    assert len(np.flatnonzero(found)) >= 0.95 * len(rows)


@pytest.mark.parametrize("seed", range(12))
def test_a_clean_unit_has_no_row_without_readings(seed):
    unit = UNITS[seed % len(UNITS)]
    clean = made(unit, seed, None, known=("table", "labels", "neither")[seed % 3]).recording
    assert not rows_without_readings(clean).any()


def test_a_burst_that_repeats_one_value_is_found_as_a_whole():
    clean = made(Unit(), 5, None).recording
    rows = np.arange(2000, 2040)
    found = rows_without_readings(corrupted_at(clean, rows, -34.906, "gyro"))
    assert np.array_equal(np.flatnonzero(found), rows)


def test_a_knock_that_rings_on_is_read():
    clean = made(Unit(), 6, None).recording
    ring = 8.0 * np.exp(-np.arange(40) / 4.0) * np.cos(1.7 * np.arange(40))
    columns = dict(clean.imu.columns)
    columns["accel_y"] = columns["accel_y"].copy()
    columns["accel_y"][1500:1540] += ring
    assert not rows_without_readings(replace(clean, imu=Stream(clean.imu.t, columns))).any()


@pytest.mark.parametrize(("name", "count"), [("one_bad_row", 1), ("ten_bad_rows", 10)])
def test_calibrate_and_explain_leave_out_the_same_rows(name, count):
    recording = read_folder(shared_path(f"data/field/{name}"))
    rows = np.flatnonzero(rows_without_readings(recording))
    assert len(rows) == count
    specification = specification_for(recording.manifest.standard, None)
    made_of = calibrate(specification, recording, run="", code_version="")
    t = recording.imu.t[rows]
    for segment in made_of.segments:
        inside = ((t >= segment.t_start) & (t < segment.t_end)).sum()
        assert segment.rows_left_out == inside


@pytest.mark.rehearsal
def test_a_low_pass_is_named_beside_a_dropout_and_an_empty_first_row():
    torn = with_dropout(swinging(1e-5, low_pass=5.0))
    columns = {name: np.append(0.0, signal[1:]) for name, signal in torn.imu.columns.items()}
    findings = explain(replace(torn, imu=Stream(torn.imu.t, columns))).findings
    assert findings[0].effect == "bandwidth"


# The median by sorting is numpy's.


@pytest.mark.parametrize("shape", [(1,), (2,), (5,), (2000,), (6, 416), (3, 7)])
def test_medians_are_those_of_numpy(shape):
    values = np.random.default_rng(1).normal(size=shape)
    assert np.array_equal(median(values), np.median(values, axis=-1))


def test_a_row_with_nan_has_no_median():
    assert np.isnan(median(np.array([[1.0, np.nan, 2.0], [3.0, 1.0, 2.0]]))).tolist() == [
        True,
        False,
    ]
