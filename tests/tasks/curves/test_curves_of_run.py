"""What the figures of a certificate show of a run: planted deviations, and their U."""

from dataclasses import replace

import numpy as np
import pytest

from schemas.calibration import AdoptedTerm, Calibration
from schemas.recording import MAX_POINTS, Curve, Recording
from tasks.calibrate.calibrate import calibrate
from tasks.certificate.figures import curves_of_run, thinned
from tasks.specifications.jjf2003 import JJF2003

RATE_BUMP, FORCE_BUMP, SIGMA = 1e-3, 2e-3, 1e-4  # rad/s, m/s², rad/s of each reading


def bumped(recording: Recording, channel: str, segment: str, bump: float) -> Recording:
    """The recording with a channel raised throughout one segment."""
    (where,) = (s for s in recording.manifest.segments or () if s.name == segment)
    raised = recording.imu.columns[channel].copy()
    raised[recording.imu.rows(where.t_start, where.t_end)] += bump
    imu = replace(recording.imu, columns={**recording.imu.columns, channel: raised})
    return replace(recording, imu=imu)


@pytest.fixture(scope="module")
def run(ideal_run) -> Recording:
    made = bumped(ideal_run(), "gyro_x", "rate_x_+300", RATE_BUMP)
    made = bumped(made, "accel_y", "position_+x_180", FORCE_BUMP)
    noise = np.random.default_rng(1).normal(0.0, SIGMA, len(made.imu.t))
    columns = {**made.imu.columns, "gyro_z": made.imu.columns["gyro_z"] + noise}
    return replace(made, imu=replace(made.imu, columns=columns))


@pytest.fixture(scope="module")
def result(run) -> Calibration:
    return calibrate(JJF2003, run, run="r", code_version="-")


@pytest.fixture(scope="module")
def curves(run, result) -> dict[tuple[str, str, str], Curve]:
    made = curves_of_run(run, result)
    return {(curve.figure, curve.quantity, curve.axis): curve for curve in made}


def test_a_reading_off_the_line_stands_out_of_the_residuals_as_a_straight_line_leaves_it(curves):
    curve = curves["rate-residuals", "gyro_scale_factor", "x"]
    rate = np.array(curve.x)
    planted = np.where(rate == 300.0, np.degrees(RATE_BUMP), 0.0)
    left = planted - np.polyval(np.polyfit(rate, planted, 1), rate)
    assert curve.y == pytest.approx(left, abs=1e-6)
    assert max(map(abs, curves["rate-residuals", "gyro_scale_factor", "y"].y)) < 1e-6


def test_u_of_the_line_is_that_of_scale_factor_and_offset_as_the_certificate_states_them(
    curves, result
):
    curve = curves["rate-residuals", "gyro_scale_factor", "x"]
    scale, offset = (result.items[name].U["x"] for name in ("gyro_scale_factor", "gyro_fit_offset"))
    assert scale is not None
    assert offset is not None
    expected = [np.hypot(scale * rate, offset) for rate in curve.x]
    assert list(curve.U) == pytest.approx(expected, rel=1e-6)


def test_a_position_that_reads_otherwise_is_seen_in_the_tumble(curves):
    curve = curves["tumble", "accel_bias", "y"]
    assert curve.labels == tuple(up for up in ("+x", "-x", "+y", "-y", "+z", "-z") for _ in "12")
    assert curve.y[1] - curve.y[0] == pytest.approx(FORCE_BUMP, rel=1e-5)
    assert np.ptp(curves["tumble", "accel_bias", "z"].y) < 1e-8


def test_white_noise_falls_with_the_root_of_the_averaging_time(curves):
    curve = curves["allan", "gyro", "z"]
    expected = np.degrees(SIGMA) * 3600.0 * np.sqrt(0.1 / np.array(curve.x))
    off = np.abs(np.array(curve.y) - expected) / np.array(curve.U)
    assert len(curve.x) >= 5
    assert off.max() < 2.0


def test_what_a_run_does_not_have_is_left_out(run, result):
    turning = [s for s in run.manifest.segments or () if s.kind == "rate"]
    only = replace(run, manifest=run.manifest.model_copy(update={"segments": tuple(turning)}))
    made = curves_of_run(only, calibrate(JJF2003, only, run="r", code_version="-"))
    assert {curve.figure for curve in made} == {"rate-residuals"}
    assert curves_of_run(only, result) == ()  # the segments of another result


def test_readings_from_which_terms_were_taken_off_have_no_allan_deviation(run, result):
    term = AdoptedTerm(name="delay", title="Delay", title_zh="延迟")
    made = curves_of_run(run, result.model_copy(update={"terms": (term,)}))
    assert {curve.figure for curve in made} == {"rate-residuals", "tumble"}


def test_a_curve_of_many_points_keeps_its_ends_and_stays_small():
    (x,) = thinned(np.arange(1000.0))
    assert len(x) == MAX_POINTS
    assert (x[0], x[-1]) == (0.0, 999.0)
