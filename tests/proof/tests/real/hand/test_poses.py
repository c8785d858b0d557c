"""The fit by hand to poses finds a made-up delay, lever arm and lean."""

import numpy as np
import pytest

from tests.moved_by_hand import poses, readings, recording, tilted
from tests.proof.real.hand.poses import by_poses

ARM = (0.03, -0.02, 0.05)


def test_delay_and_lever_arm_are_found() -> None:
    found = by_poses(recording(readings(arm=ARM), poses(delay=-0.005)))
    assert found["seconds"].value == pytest.approx(0.005, abs=2e-4)
    assert [found[f"r_{a}"].value for a in "xyz"] == pytest.approx(ARM, abs=1.5e-3)


def test_a_room_that_leans_is_found() -> None:
    found = by_poses(recording(readings(), tilted(poses(), np.radians(0.8))))
    lean = np.hypot(found["lean_x"].value, found["lean_y"].value)
    assert lean == pytest.approx(0.8, abs=0.1)
