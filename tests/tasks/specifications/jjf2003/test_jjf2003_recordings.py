"""JJF 2003 on real recordings and on simulated ones with their truth."""

import json
from dataclasses import replace

import numpy as np
import pytest
from imucal import FerrarisCalibration, FerrarisSignalRegions

from schemas.calibration import Calibration
from schemas.recording import ACCEL, AXES, GYRO, Recording
from tasks.specifications.jjf2003 import JJF2003
from tests.tasks.items_only import items_only
from tests.tasks.specifications.plant_truth import off_the_truth


def result(recording: Recording) -> Calibration:
    return items_only(JJF2003, recording)


def codes(calibration: Calibration) -> set[str]:
    return {remark.code for remark in calibration.remarks}


def test_vn200_gives_what_its_author_found(real):
    calibration = result(real("vn200_imu0_rate_table"))
    items = calibration.items
    author = {"x": 1.0006, "y": 1.0000, "z": 0.9999}
    assert items["gyro_scale_factor"].value == pytest.approx(author, abs=3e-4)
    offset = {"x": -0.571, "y": 0.002, "z": 0.384}
    assert items["gyro_fit_offset"].value == pytest.approx(offset, abs=0.02)
    assert items["gyro_cross_coupling"].value["yx"] == pytest.approx(-0.00875, abs=3e-4)
    assert items["gyro_cross_coupling"].value["xy"] == pytest.approx(+0.0086, abs=3e-4)


def test_vn200_says_what_it_cannot_give_and_what_it_left_out(real):
    calibration = result(real("vn200_imu0_rate_table"))
    assert set(calibration.items["gyro_bias"].value.values()) == {None}
    assert "gyro triad" in calibration.unavailable["gyro_bias"]
    assert "gyro triad" in calibration.unavailable["gyro_g_sensitivity"]
    assert {"number_of_rates", "disturbed", "one_heading"} <= codes(calibration)
    left_out = {s.name: s.rows_left_out for s in calibration.segments}
    assert left_out["static_+z"] >= 23


def test_ln100_books_earth_rotation_as_g_sensitivity_until_it_is_removed(real):
    calibration = result(real("ln100_two_position"))
    item = calibration.items["gyro_g_sensitivity"]
    assert item.value["xx"] * 3600 == pytest.approx(11.73, abs=0.005)
    assert item.value_without_earth_rotation["xx"] * 3600 == pytest.approx(0.03, abs=0.005)
    given = {"xx", "yx", "zx"}
    assert {name for name, value in item.value.items() if value is not None} == given
    assert "+y, -y, +z, -z" in calibration.unavailable["gyro_g_sensitivity"]
    assert item.value_without_earth_rotation["yx"] is None
    assert "one heading" in calibration.unavailable["gyro_g_sensitivity"]


def test_vn200_57630_labels_that_gravity_contradicts_are_not_believed(real):
    calibration = result(real("vn200_57630_six_position"))
    (axes,) = (r for r in calibration.remarks if r.code == "axes")
    assert "x: −x, y: −y" in axes.en
    assert "--axes x=-x,y=-y" in axes.en
    assert axes.run == "invalid"
    assert axes.blocks_pass
    assert calibration.items["accel_scale_factor"].value == pytest.approx(
        {"x": 1.0, "y": 1.0, "z": 1.0}, abs=0.002
    )


def test_xsens_rests_are_found_and_nothing_is_made_up_of_them(real):
    calibration = result(real("xsens_multiposition"))
    assert len(calibration.segments) == 38
    assert {s.origin for s in calibration.segments} == {"found"}
    values = [v for item in calibration.items.values() for v in item.value.values()]
    assert set(values) == {None}


def test_a_recording_that_never_rests_has_no_rest(real):
    assert result(real("encoder_mpu6050_pitch_slow")).segments == ()


def test_turns_by_a_known_angle_on_a_table_have_its_angle_and_its_axis_in_the_budget(real):
    by_hand = real("ferraris_session")
    manifest = by_hand.manifest.model_copy(update={"standard": "JJF 2003-2022"})
    items = result(replace(by_hand, manifest=manifest)).items
    lines = {line.symbol for line in items["gyro_scale_factor"].budgets["x"].inputs}
    assert {"α1", "α1θ"} <= lines


def test_ferraris_session_agrees_with_the_package_imucal(real):
    recording = real("ferraris_session")
    regions = {}
    for segment in recording.manifest.segments:
        rows = recording.imu.rows(segment.t_start, segment.t_end)
        regions[f"acc_{segment.name}"] = recording.imu.stack(ACCEL, rows)
        regions[f"gyr_{segment.name}"] = np.degrees(recording.imu.stack(GYRO, rows))
    theirs = FerrarisCalibration(expected_angle=-360).compute(
        FerrarisSignalRegions(**regions), 102.4, from_acc_unit="m/s^2", from_gyr_unit="deg/s"
    )
    ours = result(recording).items
    k_accel, k_gyro = theirs.K_a @ theirs.R_a, theirs.K_g @ theirs.R_g
    side_by_side = {
        "gyro_scale_factor": dict(zip(AXES, np.diag(k_gyro), strict=True)),
        "accel_scale_factor": dict(zip(AXES, np.diag(k_accel), strict=True)),
        "gyro_bias": dict(zip(AXES, theirs.b_g, strict=True)),
        "accel_cross_coupling": {a: k_accel["xyz".index(a[0]), "xyz".index(a[1])]
                                 for a in ours["accel_cross_coupling"].value},
    }  # fmt: skip
    assert ours["accel_scale_factor"].value == pytest.approx(
        side_by_side["accel_scale_factor"], abs=1e-5
    )
    assert ours["accel_cross_coupling"].value == pytest.approx(
        side_by_side["accel_cross_coupling"], abs=1e-5
    )
    # One turn by hand lasts 3 s: where exactly the rest ends moves the integral by 1e-3.
    assert ours["gyro_scale_factor"].value == pytest.approx(
        side_by_side["gyro_scale_factor"], abs=1e-3
    )
    assert ours["gyro_bias"].value == pytest.approx(side_by_side["gyro_bias"], abs=5e-3)
    # imucal takes the mean of an axis up and down, eq. (10) the mean of all six positions.
    own_pair = {axis: recording_pair_mean(recording, axis) for axis in AXES}
    assert own_pair == pytest.approx(dict(zip(AXES, theirs.b_a, strict=True)), abs=1e-6)


def recording_pair_mean(recording: Recording, axis: str) -> float:
    means = [
        recording.imu.columns[f"accel_{axis}"][recording.imu.rows(s.t_start, s.t_end)].mean()
        for s in recording.manifest.segments
        if s.up in (f"+{axis}", f"-{axis}")
    ]
    return float(np.mean(means))


def test_plant_clean_is_within_two_and_a_half_standard_uncertainties_of_its_truth(plant):
    recording = plant("plant_clean", 4)
    off = off_the_truth("plant_clean", result(recording), recording.manifest.station.gravity_m_s2)
    assert len(off) == 39
    assert max(map(abs, off.values())) < 2.5
    assert 0.5 < np.sqrt(np.mean(np.square(list(off.values())))) < 1.5


def test_earth_rotation_leaves_the_diagonal_only_where_it_is_removed(shared, plant):
    recording = plant("plant_earth_rotation", 4)
    found = result(recording)
    off = off_the_truth("plant_earth_rotation", found, recording.manifest.station.gravity_m_s2)
    assert all(off[f"gyro_g_sensitivity.{a}{a}"] > 5 for a in AXES)
    item = found.items["gyro_g_sensitivity"]
    truth = json.loads((shared / "plant" / "plant_earth_rotation" / "truth.json").read_text())[
        "parameters"
    ]["G"]
    sensitivity = np.degrees(np.array(truth)) * recording.manifest.station.gravity_m_s2
    for i, a in enumerate(AXES):
        for j, b in enumerate(AXES):
            left = item.value_without_earth_rotation[a + b] - sensitivity[i, j]
            assert abs(left) < 3 * item.u_without_earth_rotation[a + b]


def test_a_lever_arm_is_returned_as_p_in_metres(plant):
    value = result(plant("plant_lever_arm", 4)).items["accel_rate_sensitivity"].value
    lever = {"yx": -0.018, "zx": 0.007, "xy": 0.012, "zy": 0.007, "xz": 0.012, "yz": -0.018}
    assert value == pytest.approx(lever, abs=0.001)
