"""Labels that gravity, gyros or encoders contradict are left out, and named."""

from dataclasses import replace

import numpy as np

from schemas.recording import Recording, Stream
from tasks.explain.channels import CHANNELS
from tasks.explain.inputs.full_rate import full_rate
from tasks.explain.inputs.labels import disturbed_rows, with_usable_labels
from tasks.explain.inputs.prepared import prepare
from tasks.words import say
from tests.manifests import manifest_of

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


def test_right_labels_stay() -> None:
    recording = run(UPS)
    kept, remarks = with_usable_labels(recording)
    assert kept is recording
    assert remarks == ()


def test_a_label_that_gravity_contradicts_is_left_out_and_named() -> None:
    full = full_rate(run(("+x", "-x", "+y", "-y", "-z", "-z")))
    assert [segment.name for segment in full.segments].count("rest4") == 0
    assert not full.motion.felt[4000:5000].any()
    assert full.motion.felt[:4000].all()
    assert any("rest4" in say(remark, "en") for remark in full.remarks)


def test_a_label_of_another_rate_is_left_out_and_named() -> None:
    full = full_rate(run(UPS, (-90.0, -45.0, 45.0, 60.0)))
    assert not full.motion.felt[9000:].any()
    assert any("turn9" in say(remark, "en") for remark in full.remarks)


def test_labels_stay_where_most_are_contradicted_for_then_the_unit_is_wrong() -> None:
    """x and y exchanged: four of six labels are not what gravity shows."""
    kept, remarks = with_usable_labels(run(("+y", "-y", "+x", "-x", "+z", "-z")))
    assert len(kept.manifest.segments or ()) == len(UPS) + len(TURNS)
    assert remarks == ()


def test_gyros_alone_with_labels_that_tell_no_vertical_are_a_run() -> None:
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


def test_rows_in_which_a_rest_was_touched_are_not_used_and_it_is_said() -> None:
    recording = touched(slice(4985, 5000), -1.1)  # the end of the fifth rest: it moved already
    disturbed, (remark,) = disturbed_rows(recording)
    assert disturbed[4985:5000].all()
    assert not disturbed[:4970].any()
    assert not disturbed[5000:].any()
    assert "30 rows in rest4" in say(remark, "en")
    masked = prepare(recording).masked
    assert masked[4985:5000].all()
    assert not masked[:4970].any()


def test_a_level_that_stays_changed_is_no_disturbance() -> None:
    assert not disturbed_rows(touched(slice(4700, 5000), -1.1))[0].any()


def test_where_an_encoder_tells_the_motion_nothing_is_left_out() -> None:
    recording = touched(slice(4985, 5000), -1.1)
    table = Stream(recording.imu.t, {"outer_angle": np.zeros(len(recording.imu.t))})
    disturbed, remarks = disturbed_rows(replace(recording, table=table))
    assert not disturbed.any()
    assert remarks == ()


def test_an_axis_whose_labels_are_all_contradicted_is_used_and_what_is_wrong_is_named() -> None:
    inverted = run(("+x", "-x", "+y", "-y", "-z", "+z"))
    kept, remarks = with_usable_labels(inverted)
    assert kept is inverted
    assert remarks == ()
    prepared = prepare(inverted)
    assert [fault.effect for fault in prepared.faults] == ["axis_mapping"]
    assert "accelerometer z inverted" in say(prepared.full.remarks[0], "en")
