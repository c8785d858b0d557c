"""Runs that are not as the clauses have them: what is computed, and what is said."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.recording import ANGLE, Mount, Recording, Segment, Station, Stream
from tasks.specifications.jjf1536 import JJF1536
from tests.manifests import described, relabelled
from tests.tasks.items_only import items_only
from tests.tasks.specifications.jjf1536.conftest import COMPASS, EARTH, FOUR

AXES = "xyz"
DEG = float(np.degrees(1.0))


def result(recording: Recording) -> Calibration:
    return items_only(JJF1536, recording)


NOT_RECORDED = {"no_reference", "supply_not_recorded", "unit_temperature_not_recorded"}


def codes(calibration: Calibration) -> set[str]:
    """Of the remarks, but for what this bench never records."""
    return {remark.code for remark in calibration.remarks} - NOT_RECORDED


def without(recording: Recording, unwanted) -> Recording:
    return relabelled(recording, lambda s: None if unwanted(s) else {})


def with_angles(recording: Recording, angles: np.ndarray) -> Recording:
    columns = {**recording.imu.columns, **dict(zip(ANGLE, angles.T.copy(), strict=True))}
    return replace(recording, imu=Stream(recording.imu.t, columns))


def named(recording: Recording, name: str) -> Segment:
    return next(s for s in recording.manifest.segments if s.name == name)


def test_the_conditions_are_those_of_clause_6_and_7(ahrs_run):
    assert codes(result(ahrs_run(hold=60.0))) == {"short_position"}
    short = [r for r in result(ahrs_run(hold=60.0)).remarks if r.code == "short_position"]
    assert len(short) == 3
    assert not any(r.blocks_pass for r in short)
    assert "校准时间可根据被校航姿仪工作时间确定" in short[0].zh


def test_a_full_half_hour_at_each_position_leaves_nothing_to_say(bench):
    made = bench()
    for points in ("ENU", "ESD", "WSU", "WND"):
        made.position("x", points, 1800.0)
    assert codes(result(made.recording())) == set()


@pytest.mark.parametrize(("column", "value"), [("temperature", 23.5), ("humidity", 29.0)])
def test_a_room_outside_6_2_1_is_said(ahrs_run, column, value):
    recording = ahrs_run()
    columns = {**recording.environment.columns}
    columns[column] = np.full(len(recording.environment), value)
    room = Stream(recording.environment.t, columns)
    text = [r for r in result(replace(recording, environment=room)).remarks
            if r.code == "environment"]  # fmt: skip
    assert text
    assert all("6.2.1" in r.en and r.blocks_pass for r in text)


def test_a_missing_position_gives_no_zero_offset_of_that_axis_and_says_why(ahrs_run):
    recording = without(ahrs_run(B=(0.01, 0.02, 0.03)), lambda s: s.name == "zero_y_DES")
    calibration = result(recording)
    value = calibration.items["ahrs_zero_offset"].value
    assert value["y"] is None
    assert (value["x"], value["z"]) == pytest.approx((0.01, 0.03), abs=1e-8)
    assert "y: 3 positions leave up to 33 %" in calibration.unavailable["ahrs_zero_offset"]
    assert "y：3 个位置" in calibration.unavailable_zh["ahrs_zero_offset"]


def test_no_positions_leave_the_other_items(ahrs_run):
    calibration = result(without(ahrs_run(), lambda s: s.item == "four_position"))
    assert set(calibration.items["ahrs_zero_offset"].value.values()) == {None}
    assert None not in calibration.items["ahrs_misalignment"].value.values()


def test_a_position_held_twice_counts_once(bench):
    made = bench(B=(0.01, 0, 0))
    for points in ("ENU", "ENU", "ESD", "WSU", "WND"):
        made.position("x", points, 60.0)
    recording = made.recording()
    value = result(recording).items["ahrs_zero_offset"].value
    assert value["x"] == pytest.approx(0.01, abs=1e-8)


def test_positions_may_last_differently(bench):
    made = bench(B=(0, 0, 0.01))
    for points, seconds in (("NUE", 40.0), ("SDE", 80.0), ("SUW", 50.0), ("NDW", 120.0)):
        made.position("z", points, seconds)
    value = result(made.recording()).items["ahrs_zero_offset"].value
    assert value["z"] == pytest.approx(0.01, abs=1e-8)


def test_positions_that_face_earth_cancel_only_as_a_set(bench):
    made = bench(B=(0.01, 0, 0))
    for points in ("NUE", "SDE", "SUW", "NDW"):  # x points north and south
        made.position("x", points, 60.0)
    assert result(made.recording()).items["ahrs_zero_offset"].value["x"] == pytest.approx(
        0.01, abs=1e-8
    )


def test_two_opposite_positions_are_positions_at_equal_angles_and_too_few(bench):
    made = bench(B=(0.01, 0, 0))
    for points in ("ENU", "WSU"):
        made.position("x", points, 60.0)
    calibration = result(made.recording())
    assert calibration.items["ahrs_zero_offset"].value["x"] == pytest.approx(0.01, abs=1e-8)
    assert "number_of_positions" in codes(calibration)


def round_table(bench, by: str, headings=range(0, 360, 30)) -> Recording:
    """Positions about the vertical with z up, told by a table's encoder or by turn_deg."""
    made = bench(B=(0.01, 0.02, 0.03))
    east, north = np.eye(3)[0], np.eye(3)[1]
    earth = 7.292115e-5 * np.array([0, np.cos(np.radians(40)), np.sin(np.radians(40))])
    angle, t = [], []
    for heading in headings:
        cos, sin = np.cos(np.radians(heading)), np.sin(np.radians(heading))
        x, y = cos * east + sin * north, cos * north - sin * east
        label = {"name": f"at_{heading}", "kind": "static", "item": "multi_position", "up": "+z"}
        label |= {"turn_deg": heading} if by == "label" else {}
        made.add(label, np.array([x, y, [0, 0, 1]]) @ earth, 60.0)
        angle += [np.radians(heading)] * 2
        t += [made.segments[-1]["t_start"], made.segments[-1]["t_end"] - 0.01]
    recording = made.recording()
    if by == "label":
        return recording
    axes = [{"name": "a", "direction": [0, 0, 1]}]
    station = Station.model_validate({"id": "t", "latitude_deg": 40.0, "table_axes": axes})
    manifest = recording.manifest.model_copy(update={"station": station})
    table = Stream(np.array(t), {"a_angle": np.array(angle)})
    return replace(recording, manifest=manifest, table=table)


@pytest.mark.parametrize("by", ["label", "table"])
def test_twelve_positions_about_the_vertical_give_the_two_level_axes(bench, by):
    calibration = result(round_table(bench, by))
    value = calibration.items["ahrs_zero_offset"].value
    assert (value["x"], value["y"]) == pytest.approx((0.01, 0.02), abs=1e-8)
    assert value["z"] is None  # the vertical part of Earth's rotation stays
    assert "z: 12 positions leave up to 100 %" in calibration.unavailable["ahrs_zero_offset"]


def test_any_equally_spaced_set_will_do_and_others_will_not(bench):
    five = result(round_table(bench, "table", range(0, 360, 72))).items["ahrs_zero_offset"].value
    assert (five["x"], five["y"]) == pytest.approx((0.01, 0.02), abs=1e-8)
    half = result(round_table(bench, "table", range(0, 180, 30))).items["ahrs_zero_offset"].value
    assert set(half.values()) == {None}


def test_positions_whose_pointing_nobody_tells_are_taken_by_name_and_that_is_said(ahrs_run):
    bare = relabelled(ahrs_run(B=(0.01, 0, 0)), lambda s: {"points": None})
    calibration = result(bare)
    assert calibration.items["ahrs_zero_offset"].value["x"] == pytest.approx(0.01, abs=1e-8)
    text = [r for r in calibration.remarks if r.code == "pointing_not_recorded"]
    assert len(text) == 3
    assert all(r.blocks_pass for r in text)
    three = result(without(bare, lambda s: s.name == "zero_x_ENU"))
    assert three.items["ahrs_zero_offset"].value["x"] is None


def test_without_a_table_the_segments_own_mount_tells(bench):
    made = bench(B=(0.01, 0, 0))
    mounts = {"ENU": (1, 0, 0, 0), "ESD": (0, 1, 0, 0), "WSU": (0, 0, 0, 1), "WND": (0, 0, 1, 0)}
    for points in mounts:
        made.position("x", points, 60.0)
    recording = relabelled(made.recording(), lambda s: {
        "points": None, "mount": Mount(quaternion_wxyz=mounts[s.name[-3:]])})  # fmt: skip
    calibration = result(recording)
    assert calibration.items["ahrs_zero_offset"].value["x"] == pytest.approx(0.01, abs=1e-8)
    assert "pointing_not_recorded" not in codes(calibration)


def test_one_direction_of_turning_gives_no_misalignment(ahrs_run):
    recording = without(ahrs_run(), lambda s: s.axis == "y" and (s.angle_deg or 0) < 0)
    calibration = result(recording)
    value = calibration.items["ahrs_misalignment"].value
    assert [e for e, v in value.items() if v is None] == ["xy", "zy"]
    assert "no backward turns about y;" in calibration.unavailable["ahrs_misalignment"]


def test_no_turns_about_an_axis_are_said(ahrs_run):
    recording = without(ahrs_run(), lambda s: s.axis == "z" and s.kind == "rotation")
    assert result(recording).unavailable["ahrs_misalignment"] == "no turns about z"


def test_one_rate_alone_gives_no_scale_factor(ahrs_run):
    recording = without(ahrs_run(), lambda s: s.kind == "rate" and s.axis == "x"
                        and s.rate_deg_s != 100)  # fmt: skip
    calibration = result(recording)
    assert calibration.items["ahrs_scale_factor"].value["x"] is None
    assert calibration.items["ahrs_scale_factor"].u["x"] is None
    assert "only one constant rate about x" in calibration.unavailable["ahrs_scale_factor"]


def test_rates_of_one_sign_and_too_few_of_them_are_said(ahrs_run):
    recording = without(ahrs_run(K=(1.01, 1, 1)), lambda s: (s.rate_deg_s or 1) < 0)
    calibration = result(recording)
    assert {"one_direction", "number_of_rates"} <= codes(calibration)
    assert calibration.items["ahrs_scale_factor"].value["x"] == pytest.approx(1.01, abs=1e-8)


def test_a_missing_rest_does_not_touch_the_scale_factor_and_is_said(ahrs_run):
    errors = {"K": (1.01, 1, 1), "B": (0.5, 0, 0)}
    calibration = result(without(ahrs_run(**errors), lambda s: s.name == "start_x"))
    assert calibration.items["ahrs_scale_factor"].value["x"] == pytest.approx(1.01, abs=1e-8)
    text = [r for r in calibration.remarks if r.code == "rest_missing"]
    assert ["before" in r.en and "after" not in r.en for r in text] == [True]


def test_a_short_dwell_at_a_rate_is_said(ahrs_run):
    recording = relabelled(ahrs_run(), lambda s: {"t_end": s.t_start + 15.0}
                           if s.name == "scale_x_+100" else {})  # fmt: skip
    text = [r for r in result(recording).remarks if r.code == "short_dwell"]
    assert [r.segments for r in text] == [("scale_x_+100",)]
    assert "20 s" in text[0].en


def test_slow_sampling_of_positions_and_turns_is_said(ahrs_run):
    calibration = result(ahrs_run(rate_hz=1.0, B=(0.01, 0, 0)))
    assert "slow_sampling" in codes(calibration)
    assert calibration.items["ahrs_zero_offset"].value["x"] == pytest.approx(0.01, abs=1e-8)
    assert calibration.items["ahrs_scale_factor"].value["x"] == pytest.approx(1.0, abs=1e-8)


def encoded(bench, forward: float, back: float, labelled: float = 3600.0) -> Recording:
    """Turns about x by the given angles (deg), seen by a table whose axis is x of the unit."""
    made = bench(L=np.array([[0, 0, 0], [0.001, 0, 0], [0, 0, 0]]))
    for turned, text in ((forward, labelled), (back, -labelled)):
        label = {"name": f"turns_{text:+.0f}", "kind": "rotation", "item": "misalignment",
                 "angle_deg": text}  # fmt: skip
        made.turn(0, turned / 36.0, label, 36.0)
    recording = made.recording()
    station = Station.model_validate({"id": "t", "table_axes": [{"name": "a",
                                      "direction": [1, 0, 0]}]})  # fmt: skip
    manifest = recording.manifest.model_copy(update={"station": station})
    table = Stream(recording.imu.t, {"a_angle": np.concatenate(made.turned).cumsum()})
    return replace(recording, manifest=manifest, table=table)


def test_the_encoder_counts_where_the_label_is_wrong(bench):
    calibration = result(encoded(bench, 1800.0, -1800.0))
    value = calibration.items["ahrs_misalignment"].value["yx"]
    assert value == pytest.approx(0.001 * DEG, abs=1e-7)
    assert "turned_angle_contradicted" in codes(calibration)
    assert "turns_as_agreed" in codes(calibration)


def test_turns_that_are_not_whole_are_said(bench):
    calibration = result(encoded(bench, 3690.0, -3690.0, labelled=3690.0))
    assert "not_whole_turns" in codes(calibration)
    assert "turned_angle_contradicted" not in codes(calibration)


def test_turns_at_a_held_rate_labelled_as_such_are_turns_too(ahrs_run):
    recording = relabelled(
        ahrs_run(L=np.array([[0, 0, 0.001], [0, 0, 0], [0, 0, 0]])),
        lambda s: {"kind": "rate", "rate_deg_s": np.sign(s.angle_deg) * 100.0, "angle_deg": None}
        if s.kind == "rotation" else {},
    )  # fmt: skip
    calibration = result(recording)
    assert calibration.items["ahrs_misalignment"].value["xz"] == pytest.approx(
        0.001 * DEG, abs=1e-8
    )
    assert calibration.items["ahrs_scale_factor"].value["z"] == pytest.approx(1.0, abs=1e-8)


def slower_back(bench, positions: bool) -> Recording:
    made = bench(B=(0, 0.02, 0))
    for points in ("UEN", "DES", "UWS", "DWN") if positions else ():
        made.position("y", points, 60.0)
    for rate, seconds in ((100.0, 36.0), (-50.0, 72.0)):
        label = {"name": f"turns_{rate:+.0f}", "kind": "rotation", "item": "misalignment",
                 "angle_deg": rate * seconds}  # fmt: skip
        made.turn(0, rate, label, seconds)
    return made.recording()


def test_a_slower_way_back_leaves_no_zero_offset_in_the_misalignment(bench):
    calibration = result(slower_back(bench, positions=True))
    assert calibration.items["ahrs_misalignment"].value["yx"] == pytest.approx(0.0, abs=1e-8)


def test_a_slower_way_back_is_said_where_the_zero_offset_is_not_known(bench):
    assert "turn_times_differ" in codes(result(slower_back(bench, positions=False)))


def test_angles_that_begin_anew_with_each_segment_change_nothing(ahrs_run):
    recording = ahrs_run(K=(1.01, 1, 1), L=np.full((3, 3), 0.001) - 0.001 * np.eye(3))
    angles = recording.imu.stack(ANGLE).copy()
    starts = [s.t_start for s in recording.manifest.segments]
    for begin, end in pairwise([*np.searchsorted(recording.imu.t, starts), len(angles)]):
        angles[begin:end] -= angles[begin]
    whole, anew = result(recording), result(with_angles(recording, angles))
    for name, item in whole.items.items():
        assert anew.items[name].value == pytest.approx(item.value, abs=1e-8)


def test_a_restart_right_at_the_end_of_a_segment_is_left_out(bench):
    made = bench(B=(0.01, 0, 0))
    for points in ("ENU", "ESD", "WSU", "WND"):
        made.position("x", points, 60.0)
    recording = made.recording()
    angles = recording.imu.stack(ANGLE).copy()
    for segment in recording.manifest.segments:
        after = np.searchsorted(recording.imu.t, segment.t_end)
        angles[after:] += 1.0
    calibration = result(with_angles(recording, angles))
    assert calibration.items["ahrs_zero_offset"].value["x"] == pytest.approx(0.01, abs=1e-8)
    text = [r for r in calibration.remarks if r.code == "corrupted_rows"]
    assert len(text) == 4
    assert "angle_x 1" in text[0].en


@pytest.mark.parametrize("name", ["zero_x_ENU", "scale_x_+100", "turns_x"])
@pytest.mark.parametrize("place", [0, 57])
def test_a_spike_moves_no_value(ahrs_run, name, place):
    recording = ahrs_run(L=np.array([[0, 0, 0], [0.001, 0, 0], [0, 0, 0]]))
    angles = recording.imu.stack(ANGLE).copy()
    start = np.searchsorted(recording.imu.t, named(recording, name).t_start)
    angles[start + place] = 1e5
    spoiled, whole = result(with_angles(recording, angles)), result(recording)
    for item in whole.items:
        assert spoiled.items[item].value == pytest.approx(whole.items[item].value, abs=1e-6)
    (text,) = [r for r in spoiled.remarks if r.code == "corrupted_rows"]
    assert text.segments[0] == name


def test_an_axis_that_stands_still_is_said(ahrs_run):
    recording = ahrs_run()
    angles = recording.imu.stack(ANGLE).copy()
    rows = recording.imu.rows(*(getattr(named(recording, "scale_y_+100"), end)
                                for end in ("t_start", "t_end")))  # fmt: skip
    angles[rows.start + 50 : rows.stop, 1] = angles[rows.start + 50, 1]
    text = [r for r in result(with_angles(recording, angles)).remarks if r.code == "stuck"]
    assert text
    assert "angle_y was stuck" in text[0].en


def test_a_turn_that_its_axis_does_not_read_is_left_out_and_said(ahrs_run):
    recording = relabelled(ahrs_run(K=(1.01, 1, 1)), lambda s: {"axis": "x"}
                           if s.name == "scale_y_+200" else {})  # fmt: skip
    calibration = result(replace(recording, table=None))
    assert calibration.items["ahrs_scale_factor"].value["x"] == pytest.approx(1.01, abs=1e-8)
    assert {"rate_not_read", "rate_contradicted"} & codes(calibration)


def test_a_wrong_rate_label_does_not_spoil_the_uncertainty_of_other_values(plant):
    recording = plant("ahrs_clean")
    wrong = relabelled(recording, lambda s: {"rate_deg_s": 150.0}
                       if s.name == "scale_y_+200" else {})  # fmt: skip
    right, calibration = result(recording), result(wrong)
    assert "rate_contradicted" in codes(calibration)
    for name, item in right.items.items():
        assert calibration.items[name].u == pytest.approx(dict(item.u), rel=1e-3)
        assert calibration.items[name].value == pytest.approx(dict(item.value), abs=1e-12)


def test_without_labels_an_axis_that_the_mount_does_not_tell_is_not_made_up(plant):
    recording = plant("ahrs_clean")
    calibration = result(described(recording, segments=None))
    scale = calibration.items["ahrs_scale_factor"].value
    assert (scale["x"], scale["y"]) == (None, None)
    assert scale["z"] == pytest.approx(0.9997259, abs=1e-5)
    assert "rate_not_read" in codes(calibration)


def test_points_that_table_and_mount_contradict_are_said(plant):
    recording = plant("ahrs_clean")
    wrong = relabelled(recording, lambda s: {"points": {"x": "N", "y": "W", "z": "U"}}
                       if s.name == "zero_x_1" else {})  # fmt: skip
    text = [r for r in result(wrong).remarks if r.code == "pointing_contradicted"]
    assert [r.segments for r in text] == [("zero_x_1",)]


@pytest.mark.parametrize("rows", [1, 2, 5, 300])
def test_a_few_rows_are_a_result_without_values_or_with_some(ahrs_run, rows):
    recording = ahrs_run()
    columns = {name: values[:rows] for name, values in recording.imu.columns.items()}
    calibration = result(replace(recording, imu=Stream(recording.imu.t[:rows], columns)))
    assert set(calibration.items["ahrs_scale_factor"].value.values()) == {None}
    assert set(calibration.unavailable) == set(calibration.items)


def test_turns_that_the_named_axis_does_not_read_give_no_misalignment(ahrs_run):
    run = ahrs_run()
    columns = dict(run.imu.columns)
    names = [name for name in ("angle_x", "angle_y", "gyro_x", "gyro_y") if name in columns]
    swapped = dict(zip(names, (columns[n] for n in (names[1], names[0])), strict=True))
    imu = replace(run.imu, columns=columns | swapped)
    found = items_only(JJF1536, replace(run, imu=imu))
    value = found.items["ahrs_misalignment"].value
    assert [value[e] for e in ("xy", "zy", "yx", "zx")] == [None] * 4
    assert "the angle that x reads disagrees" in found.unavailable["ahrs_misalignment"]


def test_an_angle_that_starts_anew_each_turn_is_refused_with_its_row(ahrs_run):
    run = ahrs_run()
    turns = {name: np.angle(np.exp(1j * run.imu.columns[name])) for name in ANGLE}
    imu = replace(run.imu, columns={**run.imu.columns, **turns})
    with pytest.raises(Unusable, match=r"column angle_x, row \d+: the angle jumps by [+-]3\d\d°"):
        items_only(JJF1536, replace(run, imu=imu))


CROOKED = np.array([[0.9999, -0.008, 0.011], [0.008, 0.9999, 0.006], [-0.011, -0.006, 0.9999]])


def crooked_run(bench, axes: str, **errors) -> Recording:
    """Scale factor and turns about some axes, the unit fixed crooked and that stated each time."""
    made = bench(**errors)
    for name in axes:
        axis = AXES.index(name)
        attitude = Rotation.from_matrix(np.roll(np.eye(3), 2 - axis, axis=0) @ CROOKED)
        mount = {"mount": {"quaternion_wxyz": attitude.as_quat(scalar_first=True).tolist()}}
        about = attitude.as_matrix()[2]
        label = {"axis": name, "up": f"+{name}", **mount}
        for rate in (-200.0, -100.0, 100.0, 200.0):
            held = {"name": f"scale_{name}_{rate}", "kind": "rate", "rate_deg_s": rate}
            made.add({**label, **held, "item": "scale_factor"}, np.radians(rate) * about, 20.0)
        for sign in (1.0, -1.0):
            turns = {"name": f"turns_{name}_{sign}", "kind": "rotation", "angle_deg": sign * 3600.0}
            made.add(
                {**label, **turns, "item": "misalignment"}, sign * np.radians(100.0) * about, 36.0
            )
    return made.recording()


def test_a_fixing_that_is_stated_crooked_is_no_misalignment(bench):
    errors = {"K": (1.01, 0.99, 1.0), "L": [[0, 2e-3, 0], [0, 0, -1e-3], [3e-3, 0, 0]]}
    items = result(crooked_run(bench, AXES, **errors)).items
    assert list(items["ahrs_scale_factor"].value.values()) == pytest.approx(errors["K"], abs=1e-7)
    misalignment = items["ahrs_misalignment"].value
    assert [misalignment[e] / DEG for e in ("xy", "yz", "zx", "xz")] == pytest.approx(
        [2e-3, -1e-3, 3e-3, 0.0], abs=1e-7
    )


def test_crooked_turns_about_one_axis_alone_tell_nothing_and_that_is_said(bench):
    calibration = result(crooked_run(bench, "x"))
    assert calibration.items["ahrs_scale_factor"].value["x"] is None
    assert "its other axes too" in calibration.unavailable["ahrs_misalignment"]


def positions_showing(bench, share: float) -> Calibration:
    """Four positions an axis in which so much of Earth's rotation is read."""
    made = bench(B=(0.01, 0.02, 0.03))
    for axis, positions in FOUR.items():
        for points in positions:
            made.position(axis, points, 60.0)
    for place, label in enumerate(made.segments):  # a row, its pause, and the next
        body = np.array([COMPASS[letter] for letter in label["points"].values()]) @ EARTH
        made.increments[1 + 2 * place] -= (1.0 - share) * body / made.rate_hz
    return result(made.recording(rate_noise=1e-9))


@pytest.mark.parametrize(("share", "lost"), [(0.04, True), (0.6, True), (0.92, False)])
def test_a_unit_that_takes_steady_rates_off_has_no_u_of_its_zero_offset(bench, share, lost):
    calibration = positions_showing(bench, share)
    assert ("steady_rate_lost" in codes(calibration)) == lost
    assert (calibration.items["ahrs_zero_offset"].U["x"] is None) == lost
    assert calibration.items["ahrs_zero_offset"].value["x"] == pytest.approx(0.01, abs=1e-6)
    assert calibration.validity.verdict != "invalid"


@pytest.mark.parametrize(("cut", "told"), [(0.0, False), (0.5, True)])
def test_a_turn_of_which_the_label_misses_a_part_has_no_u_and_is_told(ahrs_run, cut, told):
    recording = relabelled(
        ahrs_run(L=[[0, 2e-3, 0], [0, 0, 0], [0, 0, 0]]),
        lambda s: {"t_start": s.t_start + cut} if s.kind == "rotation" and s.axis == "y" else {},
    )
    calibration = result(recording)
    assert ("turned_angle_wrong" in codes(calibration)) == told
    misalignment = calibration.items["ahrs_misalignment"]
    assert (misalignment.U["xy"] is None, misalignment.U["yx"] is None) == (told, False)
