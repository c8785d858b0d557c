"""Readings set to zero and a bias taken off at rest are told; small and coarse ones are not."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.explain.events.rest import find_bias_at_rest, mean_within
from tasks.motion.whole import Motion
from tests.tasks.explain.events.made_up import (
    SIGMA,
    counted,
    found_in,
    mean_readings,
    motion,
    noisy,
)

MADE, LONGER = motion(), motion(minutes=6.0)


def at_rest(made: Motion) -> np.ndarray:
    return np.linalg.norm(made.rate, axis=1) == 0.0


REST = at_rest(MADE)


@pytest.mark.parametrize(("threshold", "steps"), [(0.003, (1e-4, 2e-3)), (0.02, None)])
def test_small_rates_set_to_zero_are_told_with_their_threshold(threshold, steps):
    readings = noisy(mean_readings(LONGER), 1)
    readings = readings if steps is None else counted(readings, steps)
    gyros = readings[:, :3]
    gyros[np.abs(gyros) < threshold] = 0.0
    events = found_in(readings, LONGER)
    assert [event.effect for event in events.events] == ["dead_zone"]
    (event,) = events.events
    assert event.channels == (0, 1, 2)
    for parameter in event.parameters:
        assert parameter.value == pytest.approx(threshold, rel=0.1)
    assert events.masked[at_rest(LONGER), :3].all()
    assert not events.masked[:, 3:].any()


def test_a_hole_that_no_motion_exceeds_says_nothing():
    readings = noisy(mean_readings(MADE), 1)
    alone = 0.05 * np.random.default_rng(5).standard_normal(len(readings))
    readings[:, 0] = np.where(np.abs(alone) < 0.04, 0.0, alone)
    assert "dead_zone" not in [event.effect for event in found_in(readings, MADE).events]


def test_what_a_threshold_takes_is_the_mean_within_it():
    noise = np.random.default_rng(2).standard_normal(400_000)
    for mean in (-1.0, 0.2, 1.4):
        read = np.where(np.abs(mean + noise) < 1.0, 0.0, mean + noise)
        lost = mean_within(np.array([mean]), 1.0, 1.0)[0]
        assert read.mean() == pytest.approx(mean - lost, abs=5e-3)


def test_zeros_that_a_logger_filled_in_are_no_dead_zone():
    readings = counted(noisy(mean_readings(MADE), 3))
    lost = np.random.default_rng(4).choice(len(readings), 300, replace=False)
    readings[lost, :3] = 0.0
    assert "dead_zone" not in [event.effect for event in found_in(readings, MADE).events]


@pytest.mark.parametrize(
    ("seed", "steps"), [(0, (1e-4, 2e-3)), (1, (2e-3, 0.01)), (2, (0.01, 0.1))]
)
def test_steps_through_zero_are_no_dead_zone(seed, steps):
    mean = mean_readings(MADE) - np.repeat([0.004, 0.0], 3)
    events = found_in(counted(noisy(mean, seed), steps), MADE)
    assert "dead_zone" not in [event.effect for event in events.events]


def test_a_bias_taken_off_at_each_rest_is_told():
    readings, rests = noisy(mean_readings(LONGER), 7), at_rest(LONGER).astype(int)
    edges = np.flatnonzero(np.diff(rests, prepend=0, append=0)).reshape(-1, 2)
    for start, stop in edges:
        readings[start:stop, :3] -= readings[start:stop, :3].mean(axis=0)
        half = (start + stop) // 2
        readings[half:stop, :3] -= readings[half:stop, :3].mean(axis=0)
    events = found_in(readings, LONGER)
    assert [event.effect for event in events.events] == ["dead_zone"]
    assert events.events[0].channels == (0, 1, 2)


@pytest.mark.parametrize("seed", range(2))
def test_a_bias_taken_off_once_is_no_dead_zone(seed):
    readings = noisy(mean_readings(MADE), seed)
    readings[:, :3] -= readings[REST, :3].mean(axis=0)
    assert found_in(readings, MADE).events == ()
    assert SIGMA[0] > 0.0


@pytest.mark.parametrize("steps", [None, (1e-4, 2e-3)])
def test_a_threshold_taken_off_all_readings_is_told(steps):
    readings = noisy(mean_readings(MADE), 1)
    readings = readings if steps is None else counted(readings, steps)
    right, threshold = readings.copy(), 0.02
    gyros = readings[:, :3]
    readings[:, :3] = np.sign(gyros) * np.maximum(np.abs(gyros) - threshold, 0.0)
    events = found_in(readings, MADE)
    assert [event.effect for event in events.events] == ["dead_zone"]
    for parameter in events.events[0].parameters:
        assert parameter.value == pytest.approx(threshold, rel=0.02)
    shown = events.corrected(MADE.t, readings, mean_readings(MADE))
    off = np.where(events.masked, np.nan, shown - right)[:, :3]
    assert np.nanmax(np.abs(off)) < 0.05 * threshold


def test_zeros_are_told_by_a_reference_that_errs_slowly():
    """As tracked poses do: neighbouring predictions err alike."""
    threshold, readings = 0.004, noisy(mean_readings(MADE), 6)
    gyros = readings[:, :3]
    gyros[np.abs(gyros) < threshold] = 0.0
    off = 0.008 * np.sin(2.0 * np.pi * 0.3 * MADE.t)[:, None] * np.ones(3)
    events = found_in(readings, replace(MADE, rate=MADE.rate + off))
    assert "dead_zone" in [event.effect for event in events.events]


def test_a_fixture_that_swings_as_each_rest_begins_is_no_bias_taken_off():
    readings = noisy(mean_readings(MADE), 15)
    readings[:, :3] -= 0.004  # a unit whose bias has been corrected
    starts = np.flatnonzero(np.diff(REST.astype(int)) > 0) + 1
    for start in starts:
        since = MADE.t[start : start + 200] - MADE.t[start]
        swing = 0.02 * np.exp(-since / 0.3) * np.cos(2.0 * np.pi * 1.6 * since)
        readings[start : start + 200, :3] += swing[:, None]
    assert "dead_zone" not in [event.effect for event in found_in(readings, MADE).events]


# A bias that the firmware follows at rest is found with its constants; a warm-up is not.

MADE_BIAS_AT_REST = motion(minutes=2.0)
INTERVAL = float(np.median(np.diff(MADE_BIAS_AT_REST.t)))


def followed(readings: np.ndarray, quiet: float, wait: float, tau: float) -> np.ndarray:
    """What a firmware writes that follows the gyros' bias while no rate exceeds `quiet`."""
    written, bias, quiet_for = readings.copy(), np.zeros(3), 0.0
    for row, rates in enumerate(readings[:, :3]):
        quiet_for = quiet_for + INTERVAL if np.all(np.abs(rates - bias) < quiet) else 0.0
        if quiet_for > wait:
            bias = bias + (rates - bias) * INTERVAL / (tau + INTERVAL)
        written[row, :3] = rates - bias
    return written


@pytest.mark.parametrize(("quiet", "wait", "tau"), [(0.05, 1.0, 0.8), (0.03, 0.6, 2.0)])
def test_a_bias_followed_at_rest_is_found_and_put_back(quiet, wait, tau):
    readings = noisy(mean_readings(MADE_BIAS_AT_REST), 1)
    written = followed(readings, quiet, wait, tau)
    event = find_bias_at_rest(written, MADE_BIAS_AT_REST)
    assert event is not None
    assert {one.name: one.value for one in event.parameters}["tau"] == pytest.approx(tau, rel=0.2)
    put_back = written - event.applied(MADE_BIAS_AT_REST.t, np.zeros(written.shape))
    lost = np.abs(readings - written)[:, :3].max()
    assert np.abs(put_back - readings)[:, :3].max() < 0.2 * lost


@pytest.mark.parametrize("tau", [2.0, 20.0, 60.0])
def test_a_bias_that_warms_up_is_not_one_followed_at_rest(tau):
    readings = noisy(mean_readings(MADE_BIAS_AT_REST), 3)
    readings[:, :3] += np.array([6e-3, -4e-3, 2e-3]) * np.exp(-MADE_BIAS_AT_REST.t / tau)[:, None]
    assert find_bias_at_rest(readings, MADE_BIAS_AT_REST) is None


def test_a_step_after_one_quiet_moment_is_no_firmware():
    """All gyros read little for 0.4 s by chance, and their bias steps there: no estimate follows
    a bias within the little that is left of that beyond the wait.
    """
    rng = np.random.default_rng(5)
    readings = (
        mean_readings(MADE_BIAS_AT_REST) + rng.standard_normal((len(MADE_BIAS_AT_REST.t), 6)) * 0.02
    )
    moment = (MADE_BIAS_AT_REST.t >= 62.0) & (MADE_BIAS_AT_REST.t < 62.4)
    readings[moment, :3] = 0.003 + 1e-4 * rng.standard_normal((np.count_nonzero(moment), 3))
    readings[MADE_BIAS_AT_REST.t >= 62.4, :3] -= 0.01
    assert find_bias_at_rest(readings, MADE_BIAS_AT_REST) is None
