"""The frame that the reference is told in, and the site."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.model.catalogue import catalogue
from tasks.model.terms.reference_frame import REFERENCE_FRAME
from tasks.model.terms.site import GRAVITY_VALUE, earth_rotation
from tasks.motion.whole import whole_motion
from tests.moved_by_hand import poses, recording, tilted
from tests.tasks.model.table_run import LATITUDE, attitude, motion, read

# A room that leans, against the same poses turned as a whole.

ANGLE = 0.01  # rad


def test_a_leaning_room_is_put_upright():
    exact = poses(1, 0.0, 0.0)
    upright = whole_motion(recording(reference=exact))
    leaning = whole_motion(recording(reference=tilted(exact, ANGLE)))
    inner = slice(400, -400)
    assert np.abs(leaning.up - upright.up)[inner].max() > 0.5 * ANGLE
    for values in ([-ANGLE, 0.0], [ANGLE, 0.0], [0.0, ANGLE]):
        right = values[0] == -ANGLE
        moved = REFERENCE_FRAME.moved(leaning, np.array(values))
        assert (np.abs(moved.up - upright.up)[inner].max() < ANGLE**2) == right
        assert moved.translation == pytest.approx(leaning.translation, nan_ok=True)


def test_a_tracked_body_tells_its_frame_and_one_place_of_the_unit():
    """The frame stands in for a tilted table, and one place for three."""
    run = recording()
    motion = whole_motion(run)
    motion = replace(motion, t=motion.t - motion.t[0])
    tracked, untracked = (
        [term.name for term in catalogue(run, each)]
        for each in (motion, replace(motion, tracking=None))
    )
    assert tracked.count("reference_frame") == tracked.count("lever_arm") == 1
    assert not {"axis_tilt", "size_effect"} & set(tracked)
    assert "reference_frame" not in untracked
    assert "size_effect" in untracked


# What the place adds, against its definition.

EARTH = 7.292115e-5  # rad/s, WGS 84


def test_earths_rate_is_felt_along_the_pole():
    pole = np.array([0.0, np.cos(LATITUDE), np.sin(LATITUDE)])
    added = read((earth_rotation(LATITUDE),), []) - read((), [])
    assert added[:, :3] == pytest.approx(EARTH * (attitude() * pole[:, None]).sum(axis=1))
    assert not added[:, 3:].any()


def test_more_gravity_is_felt_upwards():
    added = read((GRAVITY_VALUE,), [0.01]) - read((), [])
    assert added[:, 3:] == pytest.approx(0.01 * motion().up)
    assert not added[:, :3].any()
