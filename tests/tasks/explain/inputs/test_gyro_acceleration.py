"""The angular acceleration of a tracked body, against the formula that it was turned by."""

import numpy as np
import pytest

from tasks.explain.inputs.gyro_acceleration import with_gyro_acceleration
from tasks.motion.whole import Motion, whole_motion
from tests.moved_by_hand import by_hand, poses, readings, recording

TURNED = np.array([[0.0, 1.02, 0.01], [-0.97, 0.0, 0.02], [0.0, 0.01, 1.0]])


def error(motion: Motion) -> float:
    true, inner = by_hand(motion.t), slice(400, -400)
    return float((motion.acceleration - true.acceleration)[inner].std())


def read(turned: np.ndarray | None = None, noise: float = 1e-3) -> np.ndarray:
    values = np.column_stack(list(readings(gyro_noise=noise).columns.values()))
    if turned is not None:
        values[:, :3] = values[:, :3] @ turned.T + 0.05
    return values


@pytest.mark.parametrize("turned", [None, TURNED])
def test_gyros_that_are_less_noisy_give_the_acceleration_however_they_are_mounted(turned) -> None:
    motion = whole_motion(recording(reference=poses(1, 1e-3)))
    better = with_gyro_acceleration(motion, read(turned))
    assert error(better) < 0.3 * error(motion)


def test_exact_poses_keep_their_own() -> None:
    motion = whole_motion(recording(reference=poses(1, 0.0, 0.0)))
    assert with_gyro_acceleration(motion, read(noise=0.1)) is motion


def test_gyros_that_say_something_else_are_not_used() -> None:
    motion = whole_motion(recording(reference=poses(1, 1e-3)))
    other = np.random.default_rng(6).standard_normal((len(motion.t), 6))
    assert with_gyro_acceleration(motion, other) is motion
