"""JJF 1536 on the virtual single-axis station, short dwells."""

import numpy as np
import pytest

from schemas.procedure import RateRun, Sweep, Turns
from schemas.recording import ANGLE
from tasks.calibrate.calibrate import calibrate
from tasks.specifications.jjf1536 import JJF1536
from tasks.station import procedures
from tests.tasks.station.short_ahrs import Run, errors, run_of, shortened

AXES = "xyz"


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Run:
    return run_of(tmp_path_factory.mktemp("sound"), shortened("jjf1536", 8.0))


def test_no_sample_is_lost_and_nothing_is_found_fault_with(run):
    assert run.acquired.warnings == ()
    assert (run.acquired.lost_samples, run.acquired.bad_frames) == (0, 0)


# What the noise of eight seconds may do to a value, some four times over; deg/s and deg.
NEAR = {"ahrs_scale_factor": 1e-5, "ahrs_zero_offset": 6e-4, "ahrs_misalignment": 1e-3}


def test_every_item_of_the_specification_finds_the_truth(run):
    found = errors(run)
    assert [len(found[name]) for name in NEAR] == [3, 3, 6]
    for name, elements in found.items():
        assert all(abs(off) < NEAR[name] for off, _ in elements.values())
        assert all(abs(off) < 3.0 * u for off, u in elements.values())


def test_the_raw_file_keeps_angles_and_accelerations_and_knows_no_rates(run):
    columns = run.recording.imu.columns
    assert set(ANGLE) <= set(columns)
    assert not any(name in columns for name in ("gyro_x", "gyro_y", "gyro_z"))


def test_every_measured_segment_says_how_the_unit_was_mounted(run):
    measured = ("static", "rate", "rotation")
    segments = [s for s in run.recording.manifest.segments if s.kind in measured]
    assert all(segment.mount is not None for segment in segments)
    observed = {segment.name: segment.mount.quaternion_wxyz for segment in segments}
    assert observed["rest_y"] == pytest.approx((0.5, 0.5, 0.5, 0.5))
    assert observed["zero_x_z_down_000"] == pytest.approx((0.0, 1.0, 0.0, 0.0))
    assert observed["turns_z_+"] == pytest.approx((1.0, 0.0, 0.0, 0.0))


def test_ten_turns_are_ten_turns_and_lead_back(run):
    table = run.recording.table
    for segment in run.recording.manifest.segments:
        if segment.kind == "rotation":
            rows = table.rows(segment.t_start, segment.t_end)
            turned = np.degrees(np.ptp(table.columns["table_angle"][rows]))
            assert turned == pytest.approx(3600.0, abs=0.01)
            assert abs(segment.angle_deg) == 3600.0


def test_the_angles_begin_anew_after_the_supply_was_off_and_the_clock_stays_the_stations(run):
    manifest, imu = run.recording.manifest, run.recording.imu
    on_s = manifest.model_extra["unit_power_on_s"]
    assert len(on_s) == 2  # before Y and before Z
    began = 0
    for at in on_s:
        row = int(np.searchsorted(imu.t, at - 1e-6))
        assert imu.t[row] == pytest.approx(at, abs=1e-6)
        assert imu.t[row] - imu.t[row - 1] > 1.0  # off while it was turned over
        assert max(abs(imu.columns[name][row]) for name in ANGLE) < 1e-4
        # How far it had come just before depends on how long each ramp took; it had come far.
        assert max(np.abs(imu.columns[name][began:row]).max() for name in ANGLE) > 1.0
        began = row
    assert (np.diff(imu.t) > 0).all()


def test_unit_and_table_are_on_one_clock_after_a_restart(run):
    """While a ramp goes on, the increments are those of the encoders, at the same time."""
    imu, table = run.recording.imu, run.recording.table
    spin = next(s for s in run.recording.manifest.segments if s.name == "scale_z_+300")
    rows = imu.rows(spin.t_start - 4.0, spin.t_start)
    turned = np.interp(imu.t[rows], table.t, table.columns["table_angle"])
    gained = imu.columns["angle_z"][rows]
    apart = np.diff(gained) - np.diff(turned)
    assert np.abs(apart).max() < np.radians(300.0) * 0.02  # a shift of 20 ms


def test_twelve_positions_give_the_zero_offset(tmp_path):
    made = run_of(tmp_path, shortened("jjf1536_twelve", 4.0))
    result = calibrate(JJF1536, made.recording, run="r", code_version="test")
    assert None not in result.items["ahrs_zero_offset"].value.values()
    offset = errors(made)["ahrs_zero_offset"]
    assert all(abs(off) < 3.0 * u for off, u in offset.values())
    assert all(abs(off) < NEAR["ahrs_zero_offset"] for off, _ in offset.values())
    held = [s for s in made.recording.manifest.segments if s.item == "twelve_position"]
    assert [sum(s.axis == axis for s in held) for axis in AXES] == [12, 12, 12]


def test_the_whole_procedures_are_those_of_the_specification():
    steps = procedures.load("jjf1536").steps
    assert [s.dwell_s for s in steps if isinstance(s, Sweep)] == [1800.0] * 6
    for run in (s for s in steps if isinstance(s, RateRun)):
        assert 7 <= len(run.rates_deg_s) <= 11
        assert run.dwell_s >= 20.0
    turns = [(s.axis, s.turns, s.rate_deg_s) for s in steps if isinstance(s, Turns)]
    assert turns == [(axis, 10, 100.0) for axis in AXES]
    twelve = [s for s in procedures.load("jjf1536_twelve").steps if isinstance(s, Sweep)]
    assert [(s.axis, s.dwell_s) for s in twelve] == [(axis, 1200.0) for axis in AXES]
    assert all(s.stops_deg == tuple(range(0, 360, 30)) for s in twelve)
