"""What smoothing takes off a tracked motion shows when it is smoothed again."""

import numpy as np
import pytest

from tasks.motion.pose import motion_smoothed_twice, tracked_motion
from tests.moved_by_hand import by_hand, poses, recording


def test_smoothing_again_takes_about_what_smoothing_took() -> None:
    reference = poses(turn_noise=0.05, place_noise=0.05)
    of = recording(reference=reference)
    once = tracked_motion(of, reference, of.imu.t)
    twice = motion_smoothed_twice(of, reference, of.imu.t)
    assert once.tracking == twice.tracking
    true = by_hand(of.imu.t).translation
    known = np.isfinite(once.translation).all(axis=1)
    kept = [
        float((each.translation * true)[known].sum() / (true[known] ** 2).sum())
        for each in (once, twice)
    ]
    assert kept[0] < 0.99
    assert kept[0] - kept[1] == pytest.approx(1.0 - kept[0], rel=0.5)
