"""Rows that repeat others are told; coarse, quiet or smooth readings repeat by themselves."""

from dataclasses import replace

import numpy as np
import pytest
from made_up import counted, mean_readings, motion, noisy

from tasks.explain.events.detect import events_in_readings
from tasks.explain.events.event import Events
from tasks.explain.events.repeats import find_repeats
from tasks.motion.whole import Motion
from tasks.readings.lattice import quantiser_of
from tasks.words import texts

MADE = motion(minutes=2.0)
EVERY = len(MADE.t)


def found(readings: np.ndarray, made: Motion = MADE) -> Events:
    events = events_in_readings(readings, made)
    assert all(all(texts(event.description).values()) for event in events.events)
    return events


def shares(events: Events) -> dict[str, float]:
    return {each.name: each.value for event in events.events for each in event.parameters}


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("steps", [None, (1e-4, 2e-3), (1e-3, 5e-3)])
def test_fresh_rows_are_no_repeats(seed: int, steps: tuple[float, float] | None) -> None:
    readings = noisy(mean_readings(MADE), seed)
    readings = readings if steps is None else counted(readings, steps)
    quantisers = [quantiser_of(column) for column in readings.T]
    assert find_repeats(readings, MADE, quantisers) is None


def test_one_vibration_that_all_axes_share_is_no_repeat() -> None:
    shaken = 0.02 * np.random.default_rng(12).standard_normal(EVERY)
    readings = mean_readings(MADE)
    readings[:, :3] = noisy(readings, 13)[:, :3]
    readings[:, 3:] += shaken[:, None] * np.array([0.9, 0.5, -0.7])
    assert found(counted(readings, (1e-4, 4e-3))).events == ()


def test_readings_without_noise_are_no_repeats() -> None:
    readings = counted(mean_readings(MADE))
    assert find_repeats(readings, MADE, [quantiser_of(column) for column in readings.T]) is None
    assert find_repeats(mean_readings(MADE), MADE, [None] * 6) is None


def test_accelerometers_read_twice_as_often_as_they_sample_are_held() -> None:
    readings = counted(noisy(mean_readings(MADE), 6))
    readings[1::2, 3:] = readings[: EVERY // 2 * 2 : 2, 3:]
    events = found(readings)
    assert [event.effect for event in events.events] == ["repeated_samples"]
    assert events.events[0].channels == (3, 4, 5)
    assert shares(events) == pytest.approx({"held_accel": 0.5}, abs=0.01)
    mean = mean_readings(MADE)
    held = events.applied(MADE.t, mean)
    assert np.mean(held[1::2, 3:] == mean[: EVERY // 2 * 2 : 2, 3:]) > 0.99
    assert np.array_equal(held[:, :3], mean[:, :3])
    right = events.corrected(MADE.t, readings, mean) - mean
    assert abs(right[1000:].mean(axis=0)).max() < 5e-4


def test_a_few_held_rows_are_told_and_their_stamps_are_right() -> None:
    readings = counted(noisy(mean_readings(MADE), 7))
    rows = np.random.default_rng(8).choice(np.arange(10, EVERY), 60, replace=False)
    readings[np.sort(rows)] = readings[np.sort(rows) - 1]
    events = found(readings)
    assert shares(events) == pytest.approx(
        {"held_gyro": 60 / EVERY, "held_accel": 60 / EVERY}, rel=0.1
    )
    assert np.array_equal(events.events[0].sampled_at(MADE.t), MADE.t)


def test_doubled_rows_let_later_stamps_slip() -> None:
    right = counted(noisy(mean_readings(MADE), 9))
    twice = np.sort(np.random.default_rng(10).choice(EVERY, 80, replace=False))
    readings = np.repeat(right, 1 + np.isin(np.arange(EVERY), twice), axis=0)[:EVERY]
    events = found(readings)
    assert set(shares(events)) == {"doubled_gyro", "doubled_accel"}
    assert events.events[0].sampled_at(MADE.t)[-1] == pytest.approx(MADE.t[-1] - 0.8, abs=0.03)


def test_rows_between_their_neighbours_are_interpolated() -> None:
    readings = noisy(mean_readings(MADE), 11)
    last = EVERY // 2 * 2 - 1
    readings[1:last:2] = 0.5 * (readings[0 : last - 1 : 2] + readings[2 : last + 1 : 2])
    events = found(readings)
    assert [event.effect for event in events.events] == ["repeated_samples"]
    assert shares(events) == pytest.approx(
        {"interpolated_gyro": 0.5, "interpolated_accel": 0.5}, abs=0.01
    )


def test_rows_interpolated_by_their_number_are_told_though_stamps_scatter() -> None:
    rows, fresh = np.arange(EVERY), np.arange(0, EVERY, 3)
    sampled = noisy(mean_readings(MADE), 14)[fresh]
    readings = np.column_stack([np.interp(rows, fresh, column) for column in sampled.T])
    scattered = MADE.t + 1e-3 * np.random.default_rng(15).standard_normal(EVERY)
    quantisers = [quantiser_of(column) for column in readings.T]
    repeats = find_repeats(readings, replace(MADE, t=scattered), quantisers)
    assert repeats is not None
    assert repeats.parameters[0].name == "interpolated_gyro"
    assert repeats.parameters[0].value == pytest.approx(2 / 3, abs=0.02)
