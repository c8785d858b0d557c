"""Stamps that scatter are told from sampling that is uneven, and even stamps are left alone."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.explain.events.event import Events
from tasks.explain.events.stamps import LostSamples, find_lost_samples
from tasks.motion.samples import interpolated
from tasks.motion.whole import Motion
from tasks.words import say
from tests.tasks.explain.events.made_up import counted, found_in, mean_readings, motion, noisy

MADE = motion(minutes=2.0)
COUNT = len(MADE.t)


def moved(at: np.ndarray) -> Motion:
    """The motion at other times than it was made for."""
    return MADE.mapped(lambda v: interpolated(at, MADE.t, v.reshape(COUNT, -1)).reshape(v.shape))


def jitter(size: float, seed: int) -> np.ndarray:
    return size * np.random.default_rng(seed).standard_normal(COUNT).clip(-3.0, 3.0)


def found(t: np.ndarray, readings: np.ndarray) -> Events:
    """What is found in readings stamped t, beside the motion at these stamps."""
    return found_in(readings, replace(moved(t), t=t))


@pytest.mark.parametrize("size", [3e-4, 1e-3, 2.5e-3])
def test_stamps_that_scatter_about_even_sampling_are_told(size):
    t = MADE.t + jitter(size, 1)
    events = found(t, counted(noisy(mean_readings(MADE), 2)))
    assert [event.effect for event in events.events] == ["timestamp_jitter"]
    (event,) = events.events
    (parameter,) = event.parameters
    assert abs(parameter.value - np.std(t - MADE.t)) < 2.0 * parameter.u
    assert np.std(event.sampled_at(t) - MADE.t) < 0.3 * size


@pytest.mark.parametrize(("first", "size"), [(0, 300), (4000, 300), (2500, 90)])
def test_a_backlog_is_no_part_of_the_jitter_and_moves_no_other_stamp(first, size):
    scatter = jitter(2e-3, 6)
    t = MADE.t + scatter
    last = t[first + size - 1]
    t[first : first + size] = last - 1e-4 * np.arange(size)[::-1]
    t = np.maximum.accumulate(t + 1e-9 * np.arange(COUNT))
    events = found(t, counted(noisy(mean_readings(MADE), 2)))
    event = next(event for event in events.events if event.effect == "timestamp_jitter")
    (parameter,) = event.parameters
    assert parameter.value == pytest.approx(np.std(scatter), rel=0.1)
    off = event.sampled_at(t) - MADE.t
    assert abs(np.delete(off, np.s_[first : first + size]).mean()) < 2e-4
    assert np.abs(off[first : first + size]).mean() < 5e-3


@pytest.mark.parametrize("seed", range(2))
def test_uneven_sampling_with_right_stamps_is_no_jitter(seed):
    t = MADE.t + jitter(1e-3, seed)
    readings = counted(noisy(mean_readings(moved(t)), seed + 10))
    assert "timestamp_jitter" not in [event.effect for event in found(t, readings).events]


@pytest.mark.parametrize("seed", range(2))
def test_even_stamps_do_not_scatter(seed):
    readings = counted(noisy(mean_readings(MADE), seed + 20))
    assert found(MADE.t, readings).events == ()


@pytest.mark.parametrize("seed", range(2))
def test_coarse_steps_do_not_deny_stamps_that_are_right(seed):
    t = MADE.t + jitter(1e-3, seed)
    readings = counted(noisy(mean_readings(moved(t)), seed), (0.02, 0.1))
    assert "timestamp_jitter" not in [event.effect for event in found(t, readings).events]


def test_stamps_that_close_up_to_a_batch_s_arrival_are_told():
    away = (5 - np.arange(COUNT) % 6) / 100.0
    t = MADE.t + 0.9 * (away - away.mean())
    events = found(t, counted(noisy(mean_readings(MADE), 5)))
    assert [event.effect for event in events.events] == ["timestamp_jitter"]
    assert events.remarks == ()  # no rows are missing
    assert np.std(events.events[0].sampled_at(t) - MADE.t) < 1e-3


def test_a_noisy_reference_does_not_hide_stamps_that_scatter():
    t = MADE.t + jitter(1e-3, 6)
    readings = counted(noisy(mean_readings(MADE), 7))
    observed = replace(moved(t), t=t)
    rough = observed.rate + 0.03 * np.random.default_rng(8).standard_normal(observed.rate.shape)
    events = found_in(readings, replace(observed, rate=rough))
    assert "timestamp_jitter" in [event.effect for event in events.events]


# Losses in a motion that swings all the time, beyond the period of its resonance.

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
def test_lost_samples_are_counted_across_periods_of_a_resonance(lost):
    found = losses(read(lost, 31.0))
    assert found is not None
    assert found.lost.tolist() == [lost]
    assert found.times == pytest.approx([31.0], abs=0.05)


def test_times_are_told_on_the_clock_of_the_recording():
    found = losses(read(9, 31.0), start=5000.0)
    assert found is not None
    values = {each.name: each.value for each in found.parameters}
    assert values["time_1"] == pytest.approx(5031.0, abs=0.05)
    assert "at 5031 s" in say(found.description, "en")


def test_a_constant_delay_is_no_loss():
    assert losses(read(0, 31.0)) is None


def ladder(t: np.ndarray) -> np.ndarray:
    """Ten rates of both signs, each for 6 s, with ramps of 0.6 s."""
    rates = np.array([-5.2, 0.9, -0.9, 1.8, -1.8, 3.5, -3.5, 5.2, -5.2, 1.8, -1.8])
    number, within = np.minimum(t // 6.0, 9.0).astype(int), t % 6.0
    share = np.minimum(within / 0.6, 1.0)
    return np.asarray(rates[number] + (rates[number + 1] - rates[number]) * share)


@pytest.mark.parametrize(("ramps", "is_found"), [(5, True), (3, True), (1, False)])
def test_a_loss_with_three_ramps_on_either_side_is_found(ramps, *, is_found):
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
