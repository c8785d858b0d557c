"""What is slow to be written is no delay of all stamps."""

from dataclasses import replace

import numpy as np
import pytest

from schemas.recording import Stream
from tasks.explain.channels import CHANNELS
from tasks.explain.inputs.prepared import known_before, prepare
from tasks.motion.whole import Motion, whole_motion
from tests.moved_by_hand import by_hand, poses, readings, recording
from tests.tasks.explain.inputs.test_blocks import on_a_shaft


def without_frames(start: float, end: float) -> Motion:
    """By poses of 20 s, none of them between two times, s."""
    frames = poses(seconds=20.0)
    kept = frames.at(np.flatnonzero((frames.t < start) | (frames.t > end)))
    return whole_motion(recording(readings(seconds=20.0), kept))


LOST = without_frames(8.0, 11.0)
GAP = slice(1400, 2400)  # rows of 5 ms about it


def test_samples_that_are_held_are_no_delay() -> None:
    recording = on_a_shaft(0.0)
    held = np.arange(len(recording.imu.t)) // 4 * 4
    columns = {name: recording.imu.columns[name][held] for name in CHANNELS}
    recording = replace(recording, imu=replace(recording.imu, columns=columns))
    found = prepare(recording)
    assert found.delay == 0.0
    assert [event.effect for event in found.events.events] == ["repeated_samples"]


@pytest.mark.parametrize(("late", "before", "behind"), [(0.0, 4, 5), (0.1, 0, 25)])
def test_beside_lost_frames_nothing_is_compared_that_a_late_reading_needs(
    late: float, before: int, behind: int
) -> None:
    """It is interpolated between ten rows."""
    felt, known = (each[:, 0] for each in (LOST.felt, known_before(LOST, late)))
    last, first = np.flatnonzero(np.diff(felt[GAP].astype(int))) + GAP.start + (0, 1)
    expected = felt.copy()
    expected[last - before + 1 : first + behind] = False
    assert (known == expected)[GAP].all()


def test_rests_that_only_labels_tell_are_compared_whole() -> None:
    rests = replace(LOST, axes=None, tracking=None)
    assert (known_before(rests, 0.0) == rests.felt).all()


@pytest.mark.rehearsal
def test_the_acceleration_that_late_gyros_show_is_no_smaller_as_stamped() -> None:
    """Half a row between two rows: a straight line there would take 5 % of a swing at 1.2 Hz."""
    sparse = slice(None, None, 16)
    imu = readings(seconds=240.0, gyro_noise=1e-4)
    imu = Stream(imu.t[sparse] + 0.04, {name: c[sparse] for name, c in imu.columns.items()})
    reference = poses(seconds=240.0, turn_noise=2e-3)
    full = prepare(recording(imu, reference)).full
    true = by_hand(full.motion.t + full.start).acceleration
    known = np.isfinite(full.motion.acceleration).all(axis=1)
    shown = full.motion.acceleration[known]
    assert known.mean() > 0.9
    gains = (shown * true[known]).sum(axis=0) / (true[known] ** 2).sum(axis=0)
    assert gains == pytest.approx(1.0, abs=0.01)
