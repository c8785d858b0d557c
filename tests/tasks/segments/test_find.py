"""Rests and steady turns found without labels."""

import numpy as np

from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.segments.find import find_segments, segments_of, up_of
from tests.manifests import manifest_of


def test_every_labelled_point_of_the_plant_is_found_again(plant):
    recording = plant("plant_clean")
    labels = [s for s in recording.manifest.segments if s.kind in ("static", "rate")]
    found = find_segments(recording)
    for label in labels:
        inside = [f for f in found if f.t_start >= label.t_start - 1 and f.t_end <= label.t_end + 1]
        assert len(inside) == 1, label.name
        assert inside[0].kind == label.kind
        if label.kind == "static":
            assert inside[0].up == label.up
        else:
            assert inside[0].axis == label.axis
            assert abs(inside[0].rate_deg_s - label.rate_deg_s) < 0.01


def test_hand_held_rests_of_xsens_are_found(real):
    recording = real("xsens_multiposition")
    found = find_segments(recording)
    assert len(found) == 38
    for segment in found:
        rows = recording.imu.rows(segment.t_start, segment.t_end)
        gyro = recording.imu.stack(GYRO, rows)
        assert gyro.std(axis=0).max() < 0.02


def test_a_shaft_that_never_stops_has_no_rest(real):
    assert find_segments(real("encoder_mpu6050_pitch_slow")) == ()


def test_a_steady_turn_that_nobody_measured_is_not_called_a_rest():
    t = np.round(np.arange(6000) * 0.01, 9)
    values = np.random.default_rng(2).normal(0.0, 0.001, (6000, 6))
    values[:, 5] += 9.8
    values[2000:4000, 2] += 1.0
    manifest = manifest_of("t")
    columns = dict(zip(GYRO + ACCEL, values.T, strict=True))
    found = find_segments(Recording(manifest, Stream(t, columns)))
    assert [(s.kind, s.up) for s in found] == [("static", "+z"), ("static", "+z")]


def test_what_is_not_gravity_points_nowhere():
    assert up_of(np.array([0.0, 0.0, -9.8])) == "-z"
    assert up_of(np.array([0.0, 0.0, 980.0])) is None
    assert up_of(np.array([7.0, 7.0, 0.0])) is None
    assert up_of(np.full(3, np.nan)) is None


def test_labelled_segments_are_taken_in_the_order_of_time():
    def labelled(name: str, start: float) -> dict[str, object]:
        return {"name": name, "kind": "static", "up": "+z", "t_start": start, "t_end": start + 1}

    manifest = manifest_of("t", segments=[labelled("late", 5.0), labelled("early", 1.0)])
    recording = Recording(manifest, Stream(np.arange(10.0), {"gyro_x": np.zeros(10)}))
    assert [segment.name for segment in segments_of(recording)] == ["early", "late"]
