"""The table's motion in the body frame, against an independent rotation library."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from schemas.recording import Manifest, Recording, Segment, Stream
from tasks.motion.table import axis_in_body, mean_rate, mount_of, rotation
from tests.manifests import manifest_of

angle = st.floats(-10.0, 10.0)
component = st.floats(-1.0, 1.0)


def manifest(mount: list[float]) -> Manifest:
    axes = [("outer", [0, 0, 1]), ("middle", [1, 0, 0]), ("inner", [0, 0, 2])]
    return manifest_of("t", axes=dict(axes), mount={"quaternion_wxyz": mount})


STILL = Segment(name="s", kind="static", t_start=0.0, t_end=10.0)


@settings(deadline=None)
@given(st.tuples(component, component, component), angle)
def test_rotation_is_that_of_scipy(direction, turn):
    size = np.linalg.norm(direction)
    if size < 1e-3:
        return
    unit = np.array(direction) / size
    expected = Rotation.from_rotvec(unit * turn).as_matrix()
    assert np.allclose(rotation(unit, turn), expected, atol=1e-12)


@settings(deadline=None)
@given(st.tuples(angle, angle, angle), st.integers(0, 2), angle)
def test_an_axis_in_the_body_follows_what_lies_inside_it(angles, axis, turned):
    mount = Rotation.from_rotvec([0.3 * turned, 0.1, -0.2])
    described = manifest(mount.as_quat(scalar_first=True).tolist())
    assert np.allclose(mount_of(described, STILL), mount.as_matrix(), atol=1e-12)
    directions = np.array([[0, 0, 1], [1, 0, 0], [0, 0, 1]], float)
    whole = Rotation.identity()
    for direction, turn in zip(directions, angles, strict=True):
        whole = whole * Rotation.from_rotvec(direction * turn)
    # The axis in n, seen from the body: turned by the axes outside it, then back by everything.
    outside = Rotation.identity()
    for direction, turn in zip(directions[:axis], angles[:axis], strict=True):
        outside = outside * Rotation.from_rotvec(direction * turn)
    expected = (whole * mount).inv().apply(outside.apply(directions[axis]))
    assert np.allclose(axis_in_body(described, STILL, np.array(angles), axis), expected, atol=1e-10)


def test_mean_rate_is_the_angle_turned_over_the_time():
    t = np.round(np.arange(0, 10, 0.01), 9)
    columns = {
        "outer_angle": 0.5 * t + 0.001 * np.sin(40 * t),
        "middle_angle": np.full(len(t), np.pi / 2),
        "inner_angle": np.full(len(t), np.pi / 2),
    }
    described = manifest([1, 0, 0, 0])
    recording = Recording(described, Stream(t, {}), table=Stream(t, columns))
    assert mean_rate(recording, STILL) == pytest.approx([0.5, 0, 0], abs=3e-4)


def test_without_encoders_nothing_is_assumed():
    recording = Recording(manifest([1, 0, 0, 0]), Stream(np.arange(10.0), {}))
    assert mean_rate(recording, STILL) is None
