"""Losses in a motion that swings all the time, beyond the period of its resonance."""

import numpy as np
import pytest

from tasks.explain.events.lost_samples import LostSamples, find_lost_samples
from tasks.motion.whole import Motion
from tasks.readings.slips import window_delays
from tasks.words import say

T = np.arange(0.0, 64.0, 0.01)
NOISE = 0.02  # rad/s
LATE = 1.2  # samples, all along


def rate(t: np.ndarray) -> np.ndarray:
    """Strokes of 8 s, of uneven strength, and a resonance of 13 Hz."""
    strokes = np.sin(2.0 * np.pi * t / 8.0) + 0.4 * np.sin(2.0 * np.pi * t / 1.7)
    return np.asarray(strokes + 0.5 * np.sin(2.0 * np.pi * 13.0 * t))


def shaft(moved: float = 1.0) -> Motion:
    nothing = np.zeros(len(T))
    speed = np.column_stack([nothing, moved * rate(T), nothing])
    level = np.tile([0.0, 0.0, 1.0], (len(T), 1))
    return Motion(T, level, np.full((len(T), 3), np.nan), speed, np.zeros_like(speed), 9.8)


def read(lost: float, at: float) -> np.ndarray:
    """Readings (n, 6) of which so many were lost from a time on."""
    taken_at = T + 0.01 * (np.where(at <= T, lost, 0.0) - LATE)
    noise = np.random.default_rng(12).standard_normal((len(T), 6)) * NOISE
    noise[:, 1] += 0.97 * rate(taken_at) + 0.05
    noise[:, 5] += 9.8
    return noise


def losses(readings: np.ndarray, start: float = 0.0) -> LostSamples | None:
    motion, masked = shaft(), np.zeros((len(T), 6), bool)
    return find_lost_samples(readings, motion, masked, start)


@pytest.mark.parametrize("lost", [3, 8, 9, 20])
def test_lost_samples_are_counted_across_periods_of_a_resonance(lost: int) -> None:
    found = losses(read(lost, 31.0))
    assert found is not None
    assert found.lost.tolist() == [lost]
    assert found.times == pytest.approx([31.0], abs=0.05)


def test_times_are_told_on_the_clock_of_the_recording() -> None:
    found = losses(read(9, 31.0), start=5000.0)
    assert found is not None
    values = {each.name: each.value for each in found.parameters}
    assert values["time_1"] == pytest.approx(5031.0, abs=0.05)
    assert "at 5031 s" in say(found.description, "en")


def test_a_constant_delay_is_no_loss() -> None:
    assert losses(read(0, 31.0)) is None


def test_every_window_has_its_delay() -> None:
    delays = window_delays(T, 0.01, read(9, 32.0)[:, :3], shaft().rate)
    assert delays is not None
    before = delays.at < 32.0
    assert delays.delay[before] == pytest.approx(np.full(before.sum(), -LATE), abs=0.15)
    assert delays.delay[~before] == pytest.approx(np.full((~before).sum(), 9 - LATE), abs=0.15)
    assert delays.cost(delays.delay).max() < 1.0
    assert (delays.cost(delays.delay + 3.0) > 10.0).all()


def test_rests_tell_no_delay() -> None:
    still = 0.02 * np.random.default_rng(4).standard_normal((len(T), 3))
    assert window_delays(T, 0.01, still, shaft(moved=0.0).rate) is None


def ladder(t: np.ndarray) -> np.ndarray:
    """Ten rates of both signs, each for 6 s, with ramps of 0.6 s."""
    rates = np.array([-5.2, 0.9, -0.9, 1.8, -1.8, 3.5, -3.5, 5.2, -5.2, 1.8, -1.8])
    number, within = np.minimum(t // 6.0, 9.0).astype(int), t % 6.0
    share = np.minimum(within / 0.6, 1.0)
    return np.asarray(rates[number] + (rates[number + 1] - rates[number]) * share)


@pytest.mark.parametrize(("ramps", "is_found"), [(5, True), (3, True), (1, False)])
def test_a_loss_with_three_ramps_on_either_side_is_found(ramps: int, *, is_found: bool) -> None:
    at = 6.0 * ramps - 2.0
    turning = shaft().rate.copy()
    turning[:, 1] = ladder(T)
    nothing = np.zeros((len(T), 6), bool)
    motion = Motion(T, shaft().up, shaft().north, turning, np.gradient(turning, T, axis=0), 9.8)
    readings = np.random.default_rng(3).standard_normal((len(T), 6)) * 1e-3
    readings[:, 1] += ladder(np.clip(T + 0.02 * (at <= T), 0.0, T[-1]))
    readings[:, 5] += 9.8
    found = find_lost_samples(readings, motion, nothing)
    assert (found is not None) is is_found
    if found is not None:
        assert found.lost.tolist() == [2]
        assert found.times == pytest.approx([at], abs=4.0)
