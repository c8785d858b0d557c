"""What is slow to be written is no delay of all stamps."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from schemas.recording import Recording, Stream
from tasks.explain.explanation import CHANNELS
from tasks.explain.inputs.blocks import full_rate
from tasks.explain.inputs.prepared import known_before, prepare, shown_segments
from tasks.explain.inputs.reference import clock_remarks, disturbed_rows, with_usable_labels
from tasks.motion.whole import Motion, whole_motion
from tasks.segments.find import segments_of
from tasks.words import say
from tests.manifests import manifest_of
from tests.moved_by_hand import by_hand, poses, readings, recording
from tests.tasks.explain.inputs.test_blocks import on_a_shaft
from tests.tasks.readings.makers import mistakes
from tests.tasks.readings.makers.bench import bench
from tests.tasks.readings.makers.recorded import recorded

# Labels that gravity, gyros or encoders contradict are left out, and named.

REST, RATE = 10.0, 100.0  # s, Hz
UPS = ("+x", "-x", "+y", "-y", "+z", "-z")
TURNS = (-90.0, -45.0, 45.0, 90.0)  # deg/s


def run(
    labels: tuple[str, ...], turns: tuple[float, ...] = TURNS, gyro_only: bool = False
) -> Recording:
    """Six rests, as they were, with the labels' axes up; then turns about z, with the labels'."""
    count = round(REST * RATE)
    t = np.arange((len(UPS) + len(TURNS)) * count) / RATE
    values = 1e-3 * np.random.default_rng(1).standard_normal((len(t), 6))
    segments = []
    for k, (up, label) in enumerate(zip(UPS, labels, strict=True)):
        values[k * count : (k + 1) * count, 3 + "xyz".index(up[1])] += 9.8 * (
            1 if up[0] == "+" else -1
        )
        segments.append({"name": f"rest{k}", "kind": "static", "up": None if gyro_only else label})
    for k, (rate, label) in enumerate(zip(TURNS, turns, strict=True), len(UPS)):
        rows = slice(k * count, (k + 1) * count)
        values[rows, 2] += np.radians(rate)
        values[rows, 5] += 9.8
        segments.append({"name": f"turn{k}", "kind": "rate", "axis": "z", "rate_deg_s": label,
                         "up": None if gyro_only else "+z"})  # fmt: skip
    timed = [s | {"t_start": k * REST, "t_end": (k + 1) * REST} for k, s in enumerate(segments)]
    manifest = manifest_of("labels", {"gravity_m_s2": 9.8}, segments=timed)
    names = CHANNELS[:3] if gyro_only else CHANNELS
    return Recording(manifest, Stream(t, {name: values[:, c] for c, name in enumerate(names)}))


def test_right_labels_stay():
    recording = run(UPS)
    kept, remarks = with_usable_labels(recording)
    assert kept is recording
    assert remarks == ()


def test_a_label_that_gravity_contradicts_is_left_out_and_named():
    full = full_rate(run(("+x", "-x", "+y", "-y", "-z", "-z")))
    assert [segment.name for segment in full.segments].count("rest4") == 0
    assert not full.motion.felt[4000:5000].any()
    assert full.motion.felt[:4000].all()
    assert any("rest4" in say(remark, "en") for remark in full.remarks)


def test_a_label_of_another_rate_is_left_out_and_named():
    full = full_rate(run(UPS, (-90.0, -45.0, 45.0, 60.0)))
    assert not full.motion.felt[9000:].any()
    assert any("turn9" in say(remark, "en") for remark in full.remarks)


def test_labels_stay_where_most_are_contradicted_for_then_the_unit_is_wrong():
    """x and y exchanged: four of six labels are not what gravity shows."""
    kept, remarks = with_usable_labels(run(("+y", "-y", "+x", "-x", "+z", "-z")))
    assert len(kept.manifest.segments or ()) == len(UPS) + len(TURNS)
    assert remarks == ()


def test_gyros_alone_with_labels_that_tell_no_vertical_are_a_run():
    full = full_rate(run(UPS, gyro_only=True))
    assert full.motion.felt[:, :3].all()
    assert not full.motion.felt[:, 3:].any()
    assert np.degrees(full.motion.rate[9500, 2]) == 90.0


def touched(rows: slice, size: float) -> Recording:
    """The run of right labels with accelerometer x off by a size in some rows of the rest +z up."""
    recording = run(UPS)
    columns = dict(recording.imu.columns)
    columns["accel_x"] = columns["accel_x"].copy()
    columns["accel_x"][rows] += size
    return replace(recording, imu=Stream(recording.imu.t, columns))


def test_rows_in_which_a_rest_was_touched_are_not_used_and_it_is_said():
    recording = touched(slice(4985, 5000), -1.1)  # the end of the fifth rest: it moved already
    disturbed, (remark,) = disturbed_rows(recording)
    assert disturbed[4985:5000].all()
    assert not disturbed[:4970].any()
    assert not disturbed[5000:].any()
    assert "30 rows in rest4" in say(remark, "en")
    masked = prepare(recording).masked
    assert masked[4985:5000].all()
    assert not masked[:4970].any()


def test_a_level_that_stays_changed_is_no_disturbance():
    assert not disturbed_rows(touched(slice(4700, 5000), -1.1))[0].any()


def test_where_an_encoder_tells_the_motion_nothing_is_left_out():
    recording = touched(slice(4985, 5000), -1.1)
    table = Stream(recording.imu.t, {"outer_angle": np.zeros(len(recording.imu.t))})
    disturbed, remarks = disturbed_rows(replace(recording, table=table))
    assert not disturbed.any()
    assert remarks == ()


def test_an_axis_whose_labels_are_all_contradicted_is_used_and_what_is_wrong_is_named():
    inverted = run(("+x", "-x", "+y", "-y", "-z", "+z"))
    kept, remarks = with_usable_labels(inverted)
    assert kept is inverted
    assert remarks == ()
    prepared = prepare(inverted)
    assert [fault.effect for fault in prepared.faults] == ["axis_mapping"]
    assert "accelerometer z inverted" in say(prepared.full.remarks[0], "en")


def without_frames(start: float, end: float) -> Motion:
    """By poses of 20 s, none of them between two times, s."""
    frames = poses(seconds=20.0)
    kept = frames.at(np.flatnonzero((frames.t < start) | (frames.t > end)))
    return whole_motion(recording(readings(seconds=20.0), kept))


LOST = without_frames(8.0, 11.0)
GAP = slice(1400, 2400)  # rows of 5 ms about it


def test_samples_that_are_held_are_no_delay():
    recording = on_a_shaft(0.0)
    held = np.arange(len(recording.imu.t)) // 4 * 4
    columns = {name: recording.imu.columns[name][held] for name in CHANNELS}
    recording = replace(recording, imu=replace(recording.imu, columns=columns))
    found = prepare(recording)
    assert found.delay == 0.0
    assert [event.effect for event in found.events.events] == ["repeated_samples"]


@pytest.mark.parametrize(("late", "before", "behind"), [(0.0, 4, 5), (0.1, 0, 25)])
def test_beside_lost_frames_nothing_is_compared_that_a_late_reading_needs(late, before, behind):
    """It is interpolated between ten rows."""
    felt, known = (each[:, 0] for each in (LOST.felt, known_before(LOST, late)))
    last, first = np.flatnonzero(np.diff(felt[GAP].astype(int))) + GAP.start + (0, 1)
    expected = felt.copy()
    expected[last - before + 1 : first + behind] = False
    assert (known == expected)[GAP].all()


def test_rests_that_only_labels_tell_are_compared_whole():
    rests = replace(LOST, axes=None, tracking=None)
    assert (known_before(rests, 0.0) == rests.felt).all()


@pytest.mark.rehearsal
def test_the_acceleration_that_late_gyros_show_is_no_smaller_as_stamped():
    """Half a row between two rows: a straight line there would take 5 % of a swing at 1.2 Hz."""
    sparse = slice(None, None, 16)
    imu = readings(seconds=240.0, gyro_noise=1e-4)
    imu = Stream(imu.t[sparse] + 0.04, {name: c[sparse] for name, c in imu.columns.items()})
    reference = poses(seconds=240.0, turn_noise=2e-3)
    full = prepare(recording(imu, reference)).full
    true = by_hand(full.motion.t + full.start).acceleration
    known = np.isfinite(full.motion.acceleration).all(axis=1)
    shown = full.motion.acceleration[known]
    assert known.mean() > 0.9
    gains = (shown * true[known]).sum(axis=0) / (true[known] ** 2).sum(axis=0)
    assert gains == pytest.approx(1.0, abs=0.01)


# What the station found of the unit's clock is told where it can matter, and only there.

CLOCK = {
    "at_s": 300.0, "offset_s": -0.004, "half_width_s": 0.01, "u_offset_s": 0.006, "skew": 1e-6,
    "u_skew": 1e-7,
}  # fmt: skip


def recording_remarks(**extra: Any) -> Recording:
    manifest = manifest_of("clocked", **extra)
    return Recording(manifest, Stream(np.arange(3.0), {}))


def statement(**extra: Any) -> list[str]:
    return [say(remark, "en") for remark in clock_remarks(recording_remarks(**extra))]


def test_the_clocks_part_of_a_delay_is_told_with_its_uncertainty():
    (document,) = statement(unit_clock=CLOCK)
    assert "4.0 ms ± 12.0 ms" in document


def test_stamps_that_were_moved_to_the_tables_clock_leave_the_rest():
    (document,) = statement(unit_clock=CLOCK | {"offset_s": 7.001}, unit_clock_shift_s=7.0)
    assert "-1.0 ms ± 12.0 ms" in document


@pytest.mark.parametrize(
    "extra",
    [
        {},
        {"unit_clock": CLOCK | {"u_offset_s": 0.2}},
        {"unit_clock": {n: value for n, value in CLOCK.items() if n != "half_width_s"}},
        {"unit_clock": CLOCK, "unit_power_on_s": [30.0]},
        {"unit_clock": "slow"},
        {"unit_clock": CLOCK, "unit_clock_shift_s": "much"},
    ],
    ids=["not compared", "too uncertain", "of an earlier version", "switched on again", "text",
         "no number"],
)  # fmt: skip
def test_what_is_not_known_well_enough_is_not_told(extra):
    assert statement(**extra) == []


# Labels that are late or early as a whole are put right before anything is compared with them.


@pytest.mark.parametrize("seconds", [3.0, -7.3])
def test_labels_shifted_as_a_whole_are_put_right_and_told(seconds):
    made = bench(2)
    on_time = [label["t_start"] for label in recorded(made).manifest.model_dump()["segments"]]
    mistakes.labels_late(made, seconds)
    found = prepare(recorded(made))
    starts = [label.t_start for label in found.recording.manifest.segments or ()]
    np.testing.assert_allclose(
        starts, on_time, atol=0.2
    )  # and a few hundredths of a second shorter
    assert any("labels-shifted" in str(remark) for remark in found.full.remarks)


# A report knows no rest in which the poses turn.

BY_HAND = recording(readings(seconds=40.0), poses(seconds=40.0))


def test_no_rest_is_shown_where_poses_turn():
    (found,) = segments_of(BY_HAND)
    assert found.kind == "static"
    assert shown_segments(BY_HAND) == ()


def test_labels_stay_as_they_are():
    label = {"name": "rest", "kind": "static", "t_start": 25.0, "t_end": 35.0}
    manifest = BY_HAND.manifest
    labelled = manifest.model_validate({**manifest.model_dump(), "segments": [label]})
    one = replace(BY_HAND, manifest=labelled)
    assert shown_segments(one) == segments_of(one)
