"""Poses of a body whose axes are not the unit's become poses of the unit."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.explain.explain import explain
from tasks.explain.inputs.tracked_body import in_unit_axes
from tasks.motion.whole import whole_motion
from tasks.words import say
from tests.moved_by_hand import by_hand, poses, readings, recording

SECONDS = 40.0
QUATERNION = ("qw", "qx", "qy", "qz")
TURN = Rotation.from_rotvec([0.1, -0.12, 0.15])  # 12.4°


def marked_askew(of: Recording, turn: Rotation = TURN) -> Recording:
    """The recording as if the markers had been stuck on turned."""
    pose = of.reference
    assert pose is not None
    attitude = Rotation.from_quat(pose.stack(QUATERNION), scalar_first=True) * turn
    columns = dict(zip(QUATERNION, attitude.as_quat(scalar_first=True).T, strict=True))
    return replace(of, reference=replace(pose, columns={**pose.columns, **columns}))


def moved(**more: tuple[float, ...]) -> Recording:
    return recording(readings(seconds=SECONDS, **more), poses(seconds=SECONDS))


def test_the_turn_of_the_markers_is_taken_back() -> None:
    askew = marked_askew(moved())
    pose, (remark,) = in_unit_axes(askew, whole_motion(askew))
    assert pose is not None
    found = Rotation.from_quat(pose.stack(QUATERNION), scalar_first=True)
    true = Rotation.from_quat(by_hand(pose.t).attitude, scalar_first=True)
    assert (true.inv() * found).mean().magnitude() < 2e-4
    assert "12.4°" in say(remark, "en")


def read_as(of: Recording, names: tuple[str, ...], matrix: object) -> Recording:
    """The recording with the columns of a triad exchanged or inverted."""
    exchanged = of.imu.stack(names) @ np.array(matrix, float).T
    columns = {**of.imu.columns, **dict(zip(names, exchanged.T, strict=True))}
    return replace(of, imu=replace(of.imu, columns=columns))


CYCLIC = ((0, 1, 0), (0, 0, 1), (1, 0, 0))
TWO_EXCHANGED = ((0, 1, 0), (1, 0, 0), (0, 0, 1))


@pytest.mark.parametrize(
    ("names", "matrix"),
    [
        (GYRO, CYCLIC), (ACCEL, CYCLIC), (GYRO, TWO_EXCHANGED), (ACCEL, np.diag([-1, -1, 1])),
        (ACCEL, np.diag([1, 1, -1])), (GYRO, np.diag([1, -1, -1])),
    ],
)  # fmt: skip
def test_columns_that_are_exchanged_in_one_triad_are_no_turn_of_the_body(
    names: tuple[str, ...], matrix: object
) -> None:
    askew = read_as(marked_askew(moved()), names, matrix)
    pose, (remark,) = in_unit_axes(askew, whole_motion(askew))
    assert pose is None
    assert "normal" not in say(remark, "en")
    assert "exchanged or inverted" in say(remark, "en")


@pytest.mark.parametrize(
    ("least", "most"),
    [
        ((0.6, 2.0, 2.0), (0.6, 2.0, 2.0)), ((0.3, 0.3, 0.3), (0.3, 0.3, 0.3)),
        ((0.5, 0.5, 2.0), (0.2, 2.0, 0.3)),
    ],
)  # fmt: skip
def test_clipped_rows_do_not_spoil_the_turn(
    least: tuple[float, ...], most: tuple[float, ...]
) -> None:
    """least, most: limits of each gyro to either side, times its largest rate."""
    askew = marked_askew(moved())
    gyro = askew.imu.stack(GYRO)
    low, high = (np.abs(gyro).max(axis=0) * limits for limits in (least, most))
    columns = {**askew.imu.columns, **dict(zip(GYRO, np.clip(gyro, -low, high).T, strict=True))}
    clipped = replace(askew, imu=replace(askew.imu, columns=columns))
    pose, _ = in_unit_axes(clipped, whole_motion(clipped))
    assert pose is not None
    found = Rotation.from_quat(pose.stack(QUATERNION), scalar_first=True)
    true = Rotation.from_quat(by_hand(pose.t).attitude, scalar_first=True)
    assert np.degrees((true.inv() * found).mean().magnitude()) < 0.1


def test_gyros_that_turn_about_one_axis_do_not_say_how_the_markers_sit() -> None:
    t = np.arange(0.0, SECONDS, 0.005)
    angle = np.sin(t)
    turned = Rotation.from_rotvec(np.outer(angle, [0.0, 0.0, 1.0])).as_quat(scalar_first=True)
    columns = {"gyro_x": 0.0 * t, "gyro_y": 0.0 * t, "gyro_z": np.cos(t)}
    flat = recording(Stream(t, columns), Stream(t, dict(zip(QUATERNION, turned.T, strict=True))))
    assert in_unit_axes(flat, whole_motion(flat)) == (None, ())


def test_a_lever_arm_is_named_and_told_along_the_units_axes() -> None:
    arm = (0.05, -0.03, 0.02)
    (finding,) = explain(marked_askew(moved(arm=arm))).findings
    assert finding.effect == "lever_arm"
    values = {one.name: one.value for one in finding.parameters}
    assert [values[f"r_{axis}"] for axis in "xyz"] == pytest.approx(arm, abs=2e-3)
