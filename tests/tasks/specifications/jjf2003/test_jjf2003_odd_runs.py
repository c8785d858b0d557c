"""Runs that are not as the clause has them: what is computed, and what is said."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from schemas.calibration import Calibration
from schemas.recording import ACCEL, GYRO, Recording, Segment, Stream
from tasks.specifications.jjf2003 import CONDITIONS, JJF2003
from tasks.specifications.readings import READINGS
from tasks.station import procedures
from tests.manifests import described, relabelled
from tests.tasks.items_only import items_only

GRAVITY = 9.78
RATE_HZ = 10.0
DWELL = 30.0


def result(recording: Recording) -> Calibration:
    return items_only(JJF2003, recording)


def codes(calibration: Calibration) -> set[str]:
    return {remark.code for remark in calibration.remarks}


def appended(recording: Recording, held: list[tuple[dict[str, Any], list[float]]]) -> Recording:
    """The recording with further points: a label and the six readings of each."""
    count = round(DWELL * RATE_HZ)
    flip = 1e-9 * ((7 * np.arange(count) % 11) - 5.0) / 5.0
    values = [np.array(recording.imu.columns[name]) for name in GYRO + ACCEL]
    segments = list(recording.manifest.segments)
    end = segments[-1].t_end
    for label, readings in held:
        values = [
            np.concatenate([old, new + flip]) for old, new in zip(values, readings, strict=True)
        ]
        segments.append(Segment(t_start=end, t_end=end + DWELL, **label))
        end += DWELL
    t = np.round(np.arange(len(values[0])) / RATE_HZ, 9)
    imu = Stream(t, dict(zip(GYRO + ACCEL, values, strict=True)))
    return described(replace(recording, imu=imu), segments=tuple(segments))


def test_turning_with_the_axis_down_takes_the_rests_with_the_axis_down(ideal_run):
    p, turn = 0.0005, np.radians(300.0)
    scale = np.eye(3)
    scale[1, 0] = 0.01  # y feels 1 % of what acts along x: differs by 2 % of g up and down
    recording = ideal_run(Ka=scale, P=np.array([[0, 0, 0], [p, 0, 0], [0, 0, 0]]))
    down = [0.0, 0.0, 0.0, -GRAVITY, -0.01 * GRAVITY, 0.0]
    rest = {"kind": "static", "item": "rate_sensitivity", "up": "-x"}
    points = [({"name": "rest_down", **rest}, down)]
    for sign in (1, -1):
        label = {"name": f"down_{sign}", "kind": "rate", "axis": "x", "up": "-x",
                 "item": "scale_factor", "rate_deg_s": 300.0 * sign}  # fmt: skip
        turning = [turn * sign, 0, 0, -GRAVITY, -0.01 * GRAVITY + p * turn**2, 0]
        points.append((label, turning))
    points.append(({"name": "rest2_down", **rest}, down))
    value = result(appended(recording, points)).items["accel_rate_sensitivity"].value_model
    assert value["yx"] == pytest.approx(p, abs=1e-8)


def test_a_lever_arm_does_not_hide_which_axis_is_up(ideal_run):
    arm = 0.3  # m: at 300 °/s it pulls across with 8.2 m/s²
    value = result(ideal_run(P=np.array([[0, 0, 0], [arm, 0, 0], [0, 0, 0]])))
    item = value.items["accel_rate_sensitivity"]
    assert item.value_model["yx"] == pytest.approx(arm, abs=1e-6)


def test_one_direction_of_turning_is_said_of_p(ideal_run):
    recording = ideal_run()
    kept = tuple(s for s in recording.manifest.segments if (s.rate_deg_s or 1) > 0)
    assert {"p_one_direction", "one_direction"} <= codes(
        result(described(recording, segments=kept))
    )


def test_a_rest_on_one_side_only_is_said_of_p(ideal_run):
    recording = ideal_run()
    kept = tuple(s for s in recording.manifest.segments if not s.name.startswith("rest2"))
    text = [
        r for r in result(described(recording, segments=kept)).remarks if r.code.startswith("p_")
    ]
    assert len(text) == 3
    assert "no rest after the rotation" in text[0].en


@pytest.mark.parametrize("turn", [-180, 180, 540])
def test_headings_are_compared_modulo_a_turn(ideal_run, turn):
    recording = relabelled(ideal_run(), lambda s: {"turn_deg": turn} if s.turn_deg == 180 else {})
    calibration = result(recording)
    assert "one_heading" not in codes(calibration)
    assert calibration.items["gyro_g_sensitivity"].value == pytest.approx(
        result(ideal_run()).items["gyro_g_sensitivity"].value, abs=1e-12
    )


def test_a_third_heading_does_not_bring_back_what_the_pair_cancels(ideal_run):
    sideways = 0.001  # rad/s that only the third heading shows on gyro y
    extra = ({"name": "third", "kind": "static", "item": "twelve_position", "up": "+x",
              "turn_deg": 90}, [0.0, sideways, 0.0, GRAVITY, 0.0, 0.0])  # fmt: skip
    item = result(appended(ideal_run(), [extra])).items["gyro_g_sensitivity"]
    assert item.value["yx"] == pytest.approx(0.0, abs=1e-6)


def test_a_scale_factor_far_from_one_is_a_result_and_no_wrong_label(ideal_run):
    calibration = result(ideal_run(Kg=0.9 * np.eye(3)))
    assert calibration.items["gyro_scale_factor"].value == pytest.approx(
        {"x": 0.9, "y": 0.9, "z": 0.9}, abs=1e-6
    )
    assert "rate_contradicted" not in codes(calibration)


def test_an_accelerometer_scale_far_from_one_still_shows_what_is_up(ideal_run):
    calibration = result(ideal_run(Ka=0.75 * np.eye(3)))
    assert calibration.items["accel_scale_factor"].value["z"] == pytest.approx(0.75, abs=1e-6)
    assert "position_contradicted" not in codes(calibration)


def test_a_rate_that_changes_within_its_segment_is_unsteady(ideal_run):
    recording = ideal_run()
    segment = next(s for s in recording.manifest.segments if s.name == "rate_y_+100")
    rows = recording.imu.rows(segment.t_start, segment.t_end)
    columns = {name: np.array(values) for name, values in recording.imu.columns.items()}
    columns["gyro_y"][rows] *= np.linspace(0.98, 1.02, rows.stop - rows.start)
    spoiled = replace(recording, imu=Stream(recording.imu.t, columns))
    unsteady = [r for r in result(spoiled).remarks if r.code == "unsteady_rate"]
    assert [r.segments for r in unsteady] == [("rate_y_+100",)]
    assert unsteady[0].blocks_pass


def test_rates_slower_than_a_rest_are_no_points(ideal_run):
    recording = relabelled(
        ideal_run(), lambda s: {"rate_deg_s": 0.04} if s.name == "rate_x_+10" else {}
    )
    assert result(recording).items["gyro_scale_factor"].value["x"] == pytest.approx(1, abs=1e-6)


def test_segments_without_rows_are_named_and_left_out(ideal_run):
    recording = ideal_run()
    end = recording.imu.t[-1]
    nothing = Segment(name="beyond", kind="static", t_start=end + 1, t_end=end + 31, up="+x")
    one_row = Segment(name="a_row", kind="static", t_start=end, t_end=end + 0.05, up="+x")
    segments = (*recording.manifest.segments, nothing, one_row)
    calibration = result(described(recording, segments=segments))
    (remark,) = [r for r in calibration.remarks if r.code == "without_rows"]
    assert remark.segments == ("beyond", "a_row")


def test_one_row_alone_is_a_result_without_values(ideal_run):
    recording = ideal_run()
    manifest = recording.manifest.model_copy(update={"segments": None})
    columns = {name: values[:1] for name, values in recording.imu.columns.items()}
    tiny = Recording(manifest, Stream(recording.imu.t[:1], columns), digest="0" * 64)
    values = [v for item in result(tiny).items.values() for v in item.value.values()]
    assert set(values) == {None}


def test_earth_is_removed_with_scale_factor_one_only_if_that_is_said(ideal_run):
    recording = ideal_run()
    kept = tuple(s for s in recording.manifest.segments if s.kind != "rate")
    assert "scale_factor_assumed" in codes(result(described(recording, segments=kept)))
    assert "scale_factor_assumed" not in codes(result(recording))


def test_the_conditions_are_those_of_the_procedure():
    procedure = procedures.load("jjf2003")
    assert procedure.environment.temperature_degc == CONDITIONS.temperature_degc
    assert procedure.environment.humidity_percent == CONDITIONS.humidity_percent
    assert min(step.dwell_s for step in procedure.steps) >= CONDITIONS.dwell_s


def test_every_reading_that_an_item_names_is_in_the_register(ideal_run):
    named = {name for item in result(ideal_run()).items.values() for name in item.readings}
    assert named
    assert named <= set(READINGS)


def test_a_step_that_hides_the_noise_is_said_and_counted(ideal_run):
    truth = np.array([0.021, -0.013, 0.007])
    recording = ideal_run(Ba=truth, noise=0.02)
    step = 0.05
    columns = {name: np.array(values) for name, values in recording.imu.columns.items()}
    for name in ACCEL:
        columns[name] = np.round(columns[name] / step) * step
    calibration = result(replace(recording, imu=Stream(recording.imu.t, columns)))
    (remark,) = [r for r in calibration.remarks if r.code == "coarse_step"]
    assert "accel_x 0.05" in remark.en
    assert remark.blocks_pass
    for name in ("accel_scale_factor", "accel_cross_coupling"):
        item = calibration.items[name]
        ideal = 1.0 if name == "accel_scale_factor" else 0.0
        assert all(abs(item.value[e] - ideal) < 3 * item.u[e] for e in item.value)


def test_elements_that_hold_at_one_temperature_share_one_sentence(ideal_run):
    recording = ideal_run()
    held_at = {"specifications-temperature": 0.0, "specifications-temperatures": 5.0}
    for said, warmed in held_at.items():
        warm = 28.0 + np.linspace(0.0, warmed, len(recording.imu))
        imu = replace(recording.imu, columns={**recording.imu.columns, "temperature": warm})
        remarks = result(replace(recording, imu=imu)).remarks
        assert [r.message.id for r in remarks if r.code == "temperatures"] == [said]
