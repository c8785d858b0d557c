"""The motion of a whole recording, against an independent rotation library."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from schemas.recording import Recording, Stream
from tasks.motion.whole import north_at_rest, whole_motion
from tests.manifests import manifest_of

T = np.arange(0.0, 8.0, 0.01)
DIRECTIONS = np.array([[0, 0, 1], [1, 0, 0], [0, 0.6, 0.8]], float)
angle = st.floats(-3.0, 3.0)


def recording(
    angles: np.ndarray | None = None,
    heading: float | None = 20.0,
    mount: Rotation | None = None,
    segments: list[dict] | None = None,
    reference: Stream | None = None,
) -> Recording:
    quaternion = (mount or Rotation.identity()).as_quat(scalar_first=True).tolist()
    axes = [{"name": f"a{k}", "direction": list(d)} for k, d in enumerate(DIRECTIONS)]
    manifest = manifest_of(
        "m",
        {"heading_deg": heading, "gravity_m_s2": 9.8, "table_axes": axes},
        mount={"quaternion_wxyz": quaternion},
        segments=segments,
    )
    table = None
    if angles is not None:
        table = Stream(T, {f"a{k}_angle": column for k, column in enumerate(angles.T)})
    return Recording(manifest, Stream(T, {}), table=table, reference=reference)


def attitude(angles: np.ndarray, heading: float, mount: Rotation) -> Rotation:
    whole = Rotation.from_euler("z", -heading, degrees=True)
    for direction, turned in zip(DIRECTIONS, angles.T, strict=True):
        whole = whole * Rotation.from_rotvec(turned[:, None] * direction)
    return whole * mount


@settings(deadline=None, max_examples=30)
@given(st.tuples(angle, angle, angle), st.floats(-180.0, 180.0), st.tuples(angle, angle, angle))
def test_the_vertical_and_north_are_those_of_the_attitude(angles, heading, turned) -> None:
    mount = Rotation.from_rotvec(turned)
    held = np.tile(angles, (len(T), 1))
    motion = whole_motion(recording(held, heading, mount))
    true = attitude(held[:1], heading, mount)
    assert motion.up[5] == pytest.approx(true.inv().apply([0, 0, 1])[0], abs=1e-9)
    assert motion.north[5] == pytest.approx(true.inv().apply([0, 1, 0])[0], abs=1e-9)
    rested = north_at_rest(recording(held, heading, mount), T[:1])
    assert rested[0] == pytest.approx(motion.north[0], abs=1e-12)
    assert np.abs(motion.rate).max() < 1e-9
    assert motion.force[5] == pytest.approx(9.8 * motion.up[5])


def test_rate_and_acceleration_follow_from_the_attitude_with_every_axis_moving() -> None:
    angles = np.column_stack([np.sin(T), 0.5 * T + 0.2 * np.cos(T), 0.3 * np.sin(2 * T)])
    mount = Rotation.from_rotvec([0.2, -0.4, 0.9])
    motion = whole_motion(recording(angles, 20.0, mount))
    step = 1e-4

    def rate(t: np.ndarray) -> np.ndarray:
        def at(s: np.ndarray) -> Rotation:
            moved = [np.sin(s), 0.5 * s + 0.2 * np.cos(s), 0.3 * np.sin(2 * s)]
            return attitude(np.column_stack(moved), 20.0, mount)

        return (at(t - step).inv() * at(t + step)).as_rotvec() / (2 * step)

    inner = slice(50, -50)
    assert motion.rate[inner] == pytest.approx(rate(T)[inner], abs=5e-3)
    change = (rate(T + step) - rate(T - step)) / (2 * step)
    assert motion.acceleration[inner] == pytest.approx(change[inner], abs=2e-2)


def test_an_encoder_that_starts_anew_each_turn_is_the_same_motion() -> None:
    angles = np.column_stack([3.0 * T, 0 * T, 0 * T])
    wrapped = np.column_stack([np.mod(3.0 * T, 2 * np.pi), 0 * T, 0 * T])
    motion, same = (whole_motion(recording(each)) for each in (angles, wrapped))
    assert same.rate == pytest.approx(motion.rate, abs=1e-9)


def test_a_heading_that_is_not_told_leaves_north_unknown() -> None:
    motion = whole_motion(recording(np.zeros((len(T), 3)), None))
    assert np.isnan(motion.north).all()
    assert motion.known.all()


def test_between_mountings_nothing_is_known() -> None:
    turned = Rotation.from_euler("x", 90, degrees=True).as_quat(scalar_first=True).tolist()
    segments = [
        {"name": "a", "kind": "static", "t_start": 1.0, "t_end": 2.0,
         "mount": {"quaternion_wxyz": [1, 0, 0, 0]}},
        {"name": "b", "kind": "static", "t_start": 4.0, "t_end": 5.0,
         "mount": {"quaternion_wxyz": turned}},
    ]  # fmt: skip
    motion = whole_motion(recording(np.zeros((len(T), 3)), segments=segments))
    assert motion.known.sum() == 200
    assert motion.up[150] == pytest.approx([0, 0, 1])
    assert motion.up[450] == pytest.approx([0, 1, 0], abs=1e-9)


def test_labels_tell_rests_rates_and_turns_and_nothing_beside_them() -> None:
    segments = [
        {"name": "r", "kind": "static", "up": "-y", "t_start": 0.0, "t_end": 1.0},
        {"name": "w", "kind": "rate", "axis": "z", "up": "+z", "rate_deg_s": -90.0,
         "t_start": 2.0, "t_end": 3.0},
        {"name": "t", "kind": "rotation", "axis": "x", "angle_deg": 360.0,
         "t_start": 4.0, "t_end": 6.0},
    ]  # fmt: skip
    motion = whole_motion(recording(segments=segments))
    assert motion.up[50] == pytest.approx([0, -1, 0])
    assert motion.rate[250] == pytest.approx([0, 0, -np.pi / 2])
    assert motion.rate[500] == pytest.approx([np.pi, 0, 0])
    assert np.isnan(motion.up[500]).all()
    assert np.isnan(motion.rate[150]).all()
    assert motion.known.sum() == 200


def test_a_reference_pose_gives_attitude_and_rate() -> None:
    times = np.arange(1.0, 7.0, 0.02)
    spin = np.array([0.1, -0.4, 0.7])
    turned = Rotation.from_rotvec(times[:, None] * spin)
    columns = dict(zip(("qw", "qx", "qy", "qz"), turned.as_quat(scalar_first=True).T, strict=True))
    motion = whole_motion(recording(reference=Stream(times, columns)))
    inside = (T > 1.2) & (T < 6.7)
    assert motion.rate[inside] == pytest.approx(np.tile(spin, (inside.sum(), 1)), abs=1e-6)
    true = Rotation.from_rotvec(T[:, None] * spin).inv().apply([0, 0, 1])
    assert motion.up[inside] == pytest.approx(true[inside], abs=1e-9)
    assert np.isnan(motion.rate[T < 1.0]).all()
