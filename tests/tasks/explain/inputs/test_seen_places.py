"""Positions are smoothed no more than what the unit sees of the same motion asks for."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from schemas.recording import Recording, Stream
from tasks.explain.inputs.seen_places import with_seen_places
from tasks.motion.pose import Tracking
from tasks.motion.whole import whole_motion
from tests.moved_by_hand import by_hand, poses, readings, recording

TREMOR, AT = 4e-4, 7.0  # m, Hz: far above the carrying, which ends at 1.3 Hz


def trembling(*, felt: bool, late: float = 0.0) -> Recording:
    """A hand that trembles as it carries the body; felt: by the unit as well."""
    reference, imu = poses(seconds=40.0), readings(seconds=40.0)
    seen = TREMOR * np.sin(2 * np.pi * AT * reference.t)
    reference = replace(
        reference, columns={**reference.columns, "px": reference.columns["px"] + seen}
    )
    pushed = -TREMOR * (2 * np.pi * AT) ** 2 * np.sin(2 * np.pi * AT * imu.t)
    attitude = Rotation.from_quat(by_hand(imu.t).attitude, scalar_first=True)
    inside = attitude.inv().apply(np.outer(pushed, (1.0, 0.0, 0.0))) * felt
    own = {name: imu.columns[name] + c for name, c in zip(ACCEL, inside.T, strict=True)}
    return recording(Stream(imu.t - late, {**imu.columns, **own}), reference)


ACCEL = ("accel_x", "accel_y", "accel_z")


def tracking_of(one: Recording) -> tuple[Tracking, Tracking]:
    motion = whole_motion(one)
    seen = with_seen_places(one, motion)
    assert motion.tracking is not None
    assert seen.tracking is not None
    return motion.tracking, seen.tracking


@pytest.mark.parametrize("late", [0.0, 0.045])
def test_what_the_accelerometers_feel_is_motion(late: float) -> None:
    alone, seen = tracking_of(trembling(felt=True, late=late))
    assert alone.place is not None
    assert seen.place is not None
    assert seen.place > AT


def test_what_they_do_not_feel_is_smoothed_as_before() -> None:
    alone, seen = tracking_of(trembling(felt=False))
    assert seen.place == alone.place


def test_a_stretch_that_outlasts_the_readings_is_compared_as_far_as_they_go() -> None:
    whole = trembling(felt=True)
    shorter = replace(whole, imu=whole.imu.at(whole.imu.rows(2.0, 38.0)))
    _, seen = tracking_of(shorter)
    assert seen.place is not None
    assert seen.place > AT
