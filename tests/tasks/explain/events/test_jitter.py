"""Stamps that scatter are told from sampling that is uneven, and even stamps are left alone."""

from dataclasses import replace

import numpy as np
import pytest
from made_up import counted, mean_readings, motion, noisy

from tasks.explain.events.detect import events_in_readings
from tasks.explain.events.event import Events
from tasks.motion.samples import interpolated
from tasks.motion.whole import Motion
from tasks.words import texts

MADE = motion(minutes=2.0)
COUNT = len(MADE.t)


def moved(at: np.ndarray) -> Motion:
    """The motion at other times than it was made for."""
    return MADE.mapped(lambda v: interpolated(at, MADE.t, v.reshape(COUNT, -1)).reshape(v.shape))


def jitter(size: float, seed: int) -> np.ndarray:
    return size * np.random.default_rng(seed).standard_normal(COUNT).clip(-3.0, 3.0)


def found(t: np.ndarray, readings: np.ndarray) -> Events:
    """What is found in readings stamped t, beside the motion at these stamps."""
    events = events_in_readings(readings, replace(moved(t), t=t))
    assert all(all(texts(event.description).values()) for event in events.events)
    return events


@pytest.mark.parametrize("size", [3e-4, 1e-3, 2.5e-3])
def test_stamps_that_scatter_about_even_sampling_are_told(size: float) -> None:
    t = MADE.t + jitter(size, 1)
    events = found(t, counted(noisy(mean_readings(MADE), 2)))
    assert [event.effect for event in events.events] == ["timestamp_jitter"]
    (event,) = events.events
    (parameter,) = event.parameters
    assert abs(parameter.value - np.std(t - MADE.t)) < 2.0 * parameter.u
    assert np.std(event.sampled_at(t) - MADE.t) < 0.3 * size


@pytest.mark.parametrize(("first", "size"), [(0, 300), (4000, 300), (2500, 90)])
def test_a_backlog_is_no_part_of_the_jitter_and_moves_no_other_stamp(first: int, size: int) -> None:
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
def test_uneven_sampling_with_right_stamps_is_no_jitter(seed: int) -> None:
    t = MADE.t + jitter(1e-3, seed)
    readings = counted(noisy(mean_readings(moved(t)), seed + 10))
    assert "timestamp_jitter" not in [event.effect for event in found(t, readings).events]


@pytest.mark.parametrize("seed", range(2))
def test_even_stamps_do_not_scatter(seed: int) -> None:
    readings = counted(noisy(mean_readings(MADE), seed + 20))
    assert found(MADE.t, readings).events == ()


@pytest.mark.parametrize("seed", range(2))
def test_coarse_steps_do_not_deny_stamps_that_are_right(seed: int) -> None:
    t = MADE.t + jitter(1e-3, seed)
    readings = counted(noisy(mean_readings(moved(t)), seed), (0.02, 0.1))
    assert "timestamp_jitter" not in [event.effect for event in found(t, readings).events]


def test_stamps_that_close_up_to_a_batch_s_arrival_are_told() -> None:
    away = (5 - np.arange(COUNT) % 6) / 100.0
    t = MADE.t + 0.9 * (away - away.mean())
    events = found(t, counted(noisy(mean_readings(MADE), 5)))
    assert [event.effect for event in events.events] == ["timestamp_jitter"]
    assert events.remarks == ()  # no rows are missing
    assert np.std(events.events[0].sampled_at(t) - MADE.t) < 1e-3


def test_a_noisy_reference_does_not_hide_stamps_that_scatter() -> None:
    t = MADE.t + jitter(1e-3, 6)
    readings = counted(noisy(mean_readings(MADE), 7))
    observed = replace(moved(t), t=t)
    rough = observed.rate + 0.03 * np.random.default_rng(8).standard_normal(observed.rate.shape)
    events = events_in_readings(readings, replace(observed, rate=rough))
    assert "timestamp_jitter" in [event.effect for event in events.events]
