"""Joint fits of runs with holes: triads not recorded, dead channels, readings beyond all noise."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from schemas.calibration import Calibration
from schemas.recording import ACCEL, GYRO, Recording, Segment, Stream
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.joint import JOINT
from tasks.validation.coverage import simulate
from tests.tasks.items_only import items_only

METHODS = pytest.mark.parametrize("method", [JOINT, JJF2003])


def by(method, recording: Recording) -> Calibration:
    return items_only(method, recording)


def joined(calibration: Calibration, code: str) -> str:
    return " ".join(r.en for r in calibration.remarks if r.code == code and r.blocks_pass)


def without(
    recording: Recording, triad: tuple[str, ...], which: Callable[[Segment], bool]
) -> Recording:
    """The recording with a triad null in the segments that are chosen."""
    columns = {name: np.array(values) for name, values in recording.imu.columns.items()}
    for segment in filter(which, recording.manifest.segments):
        for name in triad:
            columns[name][recording.imu.rows(segment.t_start, segment.t_end)] = np.nan
    return replace(recording, imu=Stream(recording.imu.t, columns))


def changed(recording: Recording, **columns: np.ndarray) -> Recording:
    imu = Stream(recording.imu.t, {**recording.imu.columns, **columns})
    return replace(recording, imu=imu)


def test_rates_at_which_the_gyro_was_not_recorded_are_not_counted(ideal_run):
    run = without(ideal_run(), GYRO, lambda s: s.kind == "rate" and abs(s.rate_deg_s) > 50.0)
    assert "+x 2, -x 2, +y 2, -y 2, +z 2, -z 2" in joined(by(JOINT, run), "number_of_rates")


def test_one_rate_that_is_left_gives_no_scale_factor_and_spoils_no_other(ideal_run):
    scale = np.array([[1.002, 0.001, 0.0], [0.0, 0.997, 0.002], [0.001, 0.0, 1.004]])
    whole = ideal_run(Kg=scale)
    run = without(whole, GYRO, lambda s: s.axis == "z" and s.rate_deg_s != 300.0)
    found = by(JOINT, run)
    factors = found.items["gyro_scale_factor"].value
    assert factors["z"] is None
    assert factors["x"] == pytest.approx(1.002, abs=1e-8)
    assert factors["y"] == pytest.approx(0.997, abs=1e-8)
    assert found.items["gyro_cross_coupling"].value["yz"] is None
    assert "two known rates about z" in found.unavailable["gyro_scale_factor"]
    assert not joined(found, "excess_scatter")


@METHODS
def test_a_position_that_one_triad_lacks_is_said_of_that_triad(ideal_run, method):
    run = without(ideal_run(), ACCEL, lambda s: s.kind == "static" and s.up == "+x")
    text = joined(by(method, run), "positions_missing")
    assert "+x up of the accelerometer triad" in text
    assert "gyro" not in text


@METHODS
def test_a_heading_that_one_triad_lacks_is_said_of_that_triad(ideal_run, method):
    run = without(ideal_run(), GYRO, lambda s: s.name == "position_-y_180")
    text = joined(by(method, run), "one_heading")
    assert text.startswith("-y up: gyro not recorded")


@METHODS
def test_a_unit_without_gyros_is_not_told_that_their_positions_are_missing(ideal_run, method):
    run = without(ideal_run(), GYRO, lambda s: True)
    assert not joined(by(method, run), "positions_missing")


def test_a_gyro_that_reads_one_number_throughout_has_no_parameters(ideal_run):
    run = ideal_run()
    found = by(JOINT, changed(run, gyro_z=np.zeros(len(run.imu))))
    assert found.items["gyro_scale_factor"].value["z"] is None
    assert found.items["gyro_bias"].value["z"] is None
    assert found.items["gyro_scale_factor"].value["x"] == pytest.approx(1.0, abs=1e-9)
    assert "gyro" in joined(found, "column_exchanged")  # what follows from it is not listed


@METHODS
def test_points_far_beyond_the_noise_pass_no_unit(ideal_run, method):
    run = ideal_run()
    gyro = np.array(run.imu.columns["gyro_x"])
    fast = next(s for s in run.manifest.segments if s.name == "rate_x_+300")
    gyro[run.imu.rows(fast.t_start, fast.t_end)] *= 1.01
    assert "gyro_x" in joined(by(method, changed(run, gyro_x=gyro)), "excess_scatter")


@METHODS
def test_a_gap_of_the_table_stream_passes_no_unit(method):
    recording, _ = simulate("joint", 3, ideal=True)
    assert recording.table is not None
    t = recording.table.t
    kept = (t < 45.0) | (t > 60.0)
    table = Stream(t[kept], {name: c[kept] for name, c in recording.table.columns.items()})
    text = joined(by(method, replace(recording, table=table)), "table_gap")
    assert "does not cover 1 segment," in text
    assert "position_+x_180" in text


@METHODS
def test_segments_left_out_for_null_rows_are_named_with_their_number(ideal_run, method):
    run = without(ideal_run(), GYRO, lambda s: s.name == "rest_y")
    text = [r.en for r in by(method, run).remarks if r.code == "null_rows"]
    assert text == [
        "The gyro triad was excluded from 1 segment because of missing values: rest_y 300."
    ]
