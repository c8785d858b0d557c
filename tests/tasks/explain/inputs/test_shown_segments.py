"""A report knows no rest in which the poses turn."""

from dataclasses import replace

import numpy as np

from schemas.recording import Stream
from tasks.explain.inputs.shown_segments import shown_segments
from tasks.segments.find import segments_of
from tests.moved_by_hand import poses, readings, recording

SPIN, STOP = 0.8, 20.0  # rad/s about the vertical, s: until then the body rests


def turning_evenly() -> tuple[Stream, Stream]:
    """Readings and poses of a body that rests, and then turns as evenly as a table."""
    imu, reference = readings(seconds=40.0), poses(seconds=40.0)
    angle = SPIN * np.maximum(reference.t - STOP, 0.0)
    turned = {"qw": np.cos(angle / 2), "qx": 0.0 * angle, "qy": 0.0 * angle,
              "qz": np.sin(angle / 2)}  # fmt: skip
    turned |= {name: np.zeros(len(angle)) for name in ("px", "py", "pz")}
    noise = np.random.default_rng(1).standard_normal((len(imu.t), 6))
    columns = {f"gyro_{a}": 1e-3 * c for a, c in zip("xyz", noise.T[:3], strict=True)}
    columns |= {f"accel_{a}": 0.02 * c for a, c in zip("xyz", noise.T[3:], strict=True)}
    columns["gyro_z"] = columns["gyro_z"] + SPIN * (imu.t > STOP)
    columns["accel_z"] = columns["accel_z"] + 9.81
    return Stream(imu.t, columns), Stream(reference.t, turned)


def test_no_rest_is_shown_where_poses_turn() -> None:
    one = recording(*turning_evenly())
    found, shown = segments_of(one), shown_segments(one)
    assert any(each.t_end > STOP + 5.0 for each in found)
    assert shown
    assert all(each.t_end < STOP + 1.0 for each in shown)


def test_labels_stay_as_they_are() -> None:
    one = recording(*turning_evenly())
    label = {"name": "rest", "kind": "static", "t_start": 25.0, "t_end": 35.0}
    manifest = one.manifest.model_validate({**one.manifest.model_dump(), "segments": [label]})
    labelled = replace(one, manifest=manifest)
    assert shown_segments(labelled) == segments_of(labelled)
