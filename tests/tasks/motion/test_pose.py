"""The motion of a tracked body, against the formulas that it was moved by."""

from dataclasses import replace

import numpy as np
import pytest

from schemas.recording import Stream
from tasks.motion.pose import band_edge, motion_smoothed_twice, seen_by_gyros, tracked_motion
from tasks.motion.whole import whole_motion
from tests.moved_by_hand import GRAVITY, RATE, SECONDS, by_hand, poses, readings, recording

T = np.arange(0.0, SECONDS, 1.0 / RATE)
INNER = (T > 1.0) & (T < SECONDS - 1.0)


def rms(values: np.ndarray) -> float:
    return float(np.sqrt((values**2).mean()))


def test_positions_give_the_specific_force_of_a_body_that_moves():
    motion, true = whole_motion(recording()), by_hand(T)
    force = GRAVITY * true.up + true.translation
    assert rms(true.translation) > 1.5
    assert rms((motion.force - force)[INNER]) < 0.1
    assert rms((motion.rate - true.rate)[INNER]) < 0.01
    assert motion.up[INNER] == pytest.approx(true.up[INNER], abs=1e-3)


def test_exact_poses_give_an_exact_motion():
    motion, true = whole_motion(recording(reference=poses(1, 0.0, 0.0))), by_hand(T)
    assert rms((motion.translation - true.translation)[INNER]) < 5e-3
    assert rms((motion.acceleration - true.acceleration)[INNER]) < 0.05


@pytest.mark.parametrize("noise", [0.0, 2e-4])
def test_neither_the_smoothing_nor_the_time_between_frames_makes_a_swing_smaller(noise):
    """At 120 Hz a straight line from frame to frame takes 3e-4 of a swing at 1.2 Hz."""
    motion, true = whole_motion(recording(reference=poses(1, noise, noise))), by_hand(T)
    inner = (T > 2.0) & (T < SECONDS - 2.0)
    for found, was in ((motion.rate, true.rate), (motion.translation, true.translation)):
        assert found is not None
        gain = (found * was)[inner].sum() / (was[inner] ** 2).sum()
        assert gain == pytest.approx(1.0, abs=5e-5)


def test_frames_that_were_interpolated_to_the_units_rate_are_not_taken_for_quiet_ones():
    frames = poses()
    rows = T[: np.searchsorted(T, frames.t[-1])]
    between = {name: np.interp(rows, frames.t, series) for name, series in frames.columns.items()}
    motion, true = whole_motion(recording(reference=Stream(rows, between))), by_hand(T)
    inner = (T > 1.0) & (T < SECONDS - 1.0)
    assert rms((motion.translation - true.translation)[inner]) < 0.15


def test_frames_that_a_host_stamped_in_batches_tell_the_same_motion():
    frames, true = poses(), by_hand(T)
    place = np.arange(len(frames.t)) % 6
    batched = frames.t + 0.9 * (2.5 - place) / 120.0  # stamps close up to the middle of six
    motion = whole_motion(recording(reference=replace(frames, t=batched)))
    assert rms((motion.rate - true.rate)[INNER]) < 0.02


def test_a_few_lost_frames_are_bridged_and_more_are_not():
    frames = poses()
    kept = np.ones(len(frames.t), bool)
    kept[2400:2402] = False  # at 20 s
    kept[4800:4836] = False  # 0.3 s at 40 s
    motion = whole_motion(recording(reference=frames.at(kept)))
    known = motion.felt[:, 3]
    assert known[(T > 19.8) & (T < 20.2)].all()
    assert not known[(T > 40.0) & (T < 40.3)].any()
    assert known[(T > 41.0) & (T < 42.0)].all()
    assert np.isnan(motion.up[np.searchsorted(T, 40.15)]).all()


def test_without_positions_the_force_of_a_body_that_moves_is_not_known():
    motion = whole_motion(recording(reference=poses(places=False)))
    assert motion.felt[INNER, 0].all()
    assert not motion.felt[:, 3].any()


def test_without_positions_the_force_is_known_where_the_body_rests():
    held = poses(places=False)
    still = held.t > 30.0
    columns = {
        name: np.where(still, series[still][0], series) for name, series in held.columns.items()
    }
    rng = np.random.default_rng(3)
    columns["qx"] = columns["qx"] + 1e-4 * rng.standard_normal(len(held.t))
    imu = readings()
    resting = {
        name: np.where(imu.t > 30.0, series[imu.t > 30.0][0], series)
        + 0.02 * rng.standard_normal(len(imu.t))
        for name, series in imu.columns.items()
    }
    motion = whole_motion(recording(replace(imu, columns=resting), Stream(held.t, columns)))
    assert motion.felt[(T > 32.0) & (T < 58.0), 3].mean() > 0.95
    assert not motion.felt[T < 29.0, 3].any()


def test_a_body_on_a_table_keeps_its_place():
    station = {"id": "s", "table_axes": [{"name": "a", "direction": [0, 0, 1]}]}
    motion = whole_motion(recording(reference=poses(places=False), station=station))
    assert motion.felt[INNER].all()
    assert motion.translation is not None
    assert not motion.translation[INNER].any()


def test_a_stretch_whose_even_grid_ends_a_hair_late_is_read_to_its_end():
    """The usual interval is 0.01 s but for its last digits, which add up over 33 s."""
    stamps = np.round(0.01 * np.arange(10265), 2)
    stamps = stamps[(stamps <= 54.37) | (stamps >= 69.67)]
    interval = float(np.median(np.diff(stamps)))
    assert np.arange(69.67, stamps[-1], interval)[-1] > stamps[-1]
    still = {"qw": np.ones(len(stamps))} | {q: np.zeros(len(stamps)) for q in ("qx", "qy", "qz")}
    imu = readings(seconds=110.0)
    motion = whole_motion(recording(imu, Stream(stamps, still)))
    assert motion.felt[(imu.t > 71.0) & (imu.t < 101.0), 0].all()


# The band of poses, where their noise is not the same at all frequencies.

INTERVAL, SECONDS_BAND = 0.01, 120.0  # s
SWINGS = ((1.0, 0.3), (0.02, 3.0), (0.01, 6.0))  # rad, Hz: slow turns and a hand that shakes
TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def turns() -> tuple[np.ndarray, np.ndarray]:
    """Angles (n, 3) as a solver tells them, whose noise is white in the rate, and true rates."""
    rng = np.random.default_rng(4)
    t = np.arange(0.0, SECONDS_BAND, INTERVAL)
    phases = rng.uniform(0.0, 2 * np.pi, (len(SWINGS), 3))
    swings = [(a, 2 * np.pi * f, p) for (a, f), p in zip(SWINGS, phases, strict=True)]
    angle = sum(a * np.sin(w * t[:, None] + p) for a, w, p in swings)
    rate = sum(a * w * np.cos(w * t[:, None] + p) for a, w, p in swings)
    noise = np.cumsum(rng.normal(0.0, 5e-4, angle.shape), axis=0)
    return np.asarray(angle + noise), np.asarray(rate)


def test_gyros_show_that_poses_tell_a_motion_that_their_own_spectrum_hides():
    angle, rate = turns()
    assert band_edge([angle], INTERVAL) < 2.0
    assert 5.0 < seen_by_gyros([angle], [rate], INTERVAL) < 8.0


def test_neither_axes_nor_scale_factors_nor_a_delay_of_the_gyros_matter():
    angle, rate = turns()
    late = np.roll(1.2 * rate @ TURN, 7, axis=0)
    assert seen_by_gyros([angle], [late], INTERVAL) == seen_by_gyros([angle], [rate], INTERVAL)


def test_gyros_of_another_body_see_nothing():
    angle, rate = turns()
    other = np.random.default_rng(5).normal(0.0, 1.0, rate.shape)
    assert seen_by_gyros([angle], [other], INTERVAL) == 0.0


# What smoothing takes off a tracked motion shows when it is smoothed again.


def test_smoothing_again_takes_about_what_smoothing_took():
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
