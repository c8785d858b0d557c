"""Events are recognised for what they are, and nothing is found where nothing happened."""

from dataclasses import replace

import numpy as np
import pytest
from made_up import SIGMA, counted, mean_readings, motion, noisy

from tasks.explain.events.detect import events_in_readings
from tasks.explain.events.event import Events
from tasks.explain.events.quantisation import Quantisation, rounding_bias
from tasks.explain.events.saturation import clipping_loss
from tasks.readings.lattice import Quantiser
from tasks.words import say, texts


def _effects(events: Events) -> list[str]:
    """Their names; each has a sentence in every language."""
    assert all(all(texts(event.description).values()) for event in events.events)
    return [event.effect for event in events.events]


def _found(events: Events, name: str) -> float:
    (event,) = events.events
    return next(each.value for each in event.parameters if each.name == name)


@pytest.mark.parametrize("seed", range(3))
def test_clean_run_has_no_events(seed: int) -> None:
    made = motion()
    events = events_in_readings(counted(noisy(mean_readings(made), seed)), made)
    assert events.events == ()
    assert not events.masked.any()


@pytest.mark.parametrize("limit", [4.9, 5.013])
def test_gyro_limit_is_found_and_its_mean_predicted(limit: float) -> None:
    made = motion()
    mean = mean_readings(made)
    readings = noisy(mean, 1)
    readings[:, :3] = np.clip(readings[:, :3], -limit, limit)
    events = events_in_readings(counted(readings), made)
    assert _effects(events) == ["gyro_saturation"]
    assert _found(events, "limit") == pytest.approx(limit, abs=1e-4)
    beyond = np.abs(mean[:, 2]) > limit
    assert events.masked[beyond, 2].all()
    applied = events.applied(made.t, mean)
    assert np.mean(readings[beyond] - applied[beyond]) == pytest.approx(0, abs=5 * 5e-3 / 50)


def test_limit_on_one_side_leaves_the_other_side_alone() -> None:
    made = motion()
    mean = mean_readings(made)
    readings = noisy(mean, 2)
    readings[:, :3] = np.minimum(readings[:, :3], 4.5)
    events = events_in_readings(counted(readings), made)
    assert _effects(events) == ["gyro_saturation"]
    low = mean[:, 2] < -4.6
    assert low.any()
    assert np.array_equal(events.applied(made.t, mean)[low], mean[low])


def test_visible_steps_are_found_with_the_noise_below_them() -> None:
    made = motion()
    readings = counted(noisy(mean_readings(made), 4), (3e-3, 2e-3))
    events = events_in_readings(readings, made)
    assert _effects(events) == ["coarse_quantisation"]
    (event,) = events.events
    assert isinstance(event, Quantisation)
    assert event.channels == (0, 1, 2)
    assert _found(events, "gyro") == pytest.approx(3e-3, rel=1e-6)
    assert np.array(event.noises) == pytest.approx([1e-3] * 3, rel=0.1)


def test_mean_of_rounded_noise_follows_the_series() -> None:
    noise = np.random.default_rng(5).standard_normal(400_000)
    for mean in (0.1, 0.31, 0.45):
        shift = rounding_bias(np.array([mean]), Quantiser(1.0, 0.0), 0.3)[0]
        assert np.round(mean + 0.3 * noise).mean() == pytest.approx(mean + shift, abs=4e-3)


def test_what_a_limit_cuts_off_is_the_mean_beyond_it() -> None:
    noise = np.random.default_rng(6).standard_normal(400_000)
    for mean in (-1.0, 0.0, 2.0):
        lost = clipping_loss(np.array([mean]), 0.5, 1.0)[0]
        assert np.minimum(mean + noise, 0.5).mean() == pytest.approx(mean - lost, abs=8e-3)
    assert clipping_loss(np.array([2.0]), 0.5, 0.0)[0] == 1.5


def test_lost_samples_are_counted_and_placed() -> None:
    made = motion()
    mean = mean_readings(made)
    gone = np.r_[6_710, 14_711, 14_712]  # one within a ramp, two within another
    arrived = np.delete(counted(noisy(mean, 7)), gone, axis=0)
    t = made.t[: len(arrived)]
    observed = made.taken(np.arange(len(arrived)))
    events = events_in_readings(arrived, observed)
    assert _effects(events) == ["dropped_samples"]
    assert [_found(events, name) for name in ("lost_1", "lost_2")] == [1, 2]
    assert _found(events, "time_1") == pytest.approx(67.1, abs=0.1)
    assert _found(events, "time_2") == pytest.approx(147.1, abs=0.1)
    off = arrived - events.applied(t, mean[: len(t)])
    assert off[15_000:-10].std(axis=0) == pytest.approx(SIGMA, rel=0.1)


@pytest.mark.parametrize("late", [0.0123, 1e-4])
def test_delays_that_do_not_jump_are_left_to_the_regression(late: float) -> None:
    made = motion()
    taken_at = made.t + (late if late > 1e-3 else late * made.t)  # an offset, or a fast clock
    mean = np.column_stack([np.interp(taken_at, made.t, each) for each in mean_readings(made).T])
    assert events_in_readings(counted(noisy(mean, 8)), made).events == ()


def test_gaps_in_the_stamps_are_a_remark() -> None:
    made = motion()
    kept = np.delete(np.arange(len(made.t)), np.r_[900:905, 12_000])
    readings = counted(noisy(mean_readings(made), 9))[kept]
    events = events_in_readings(readings, made.taken(kept))
    assert events.events == ()
    assert "2 gaps, 6" in say(events.remarks[0], "en")


def test_spikes_are_counted_and_masked() -> None:
    made = motion()
    readings = noisy(mean_readings(made), 12)
    at = np.array([300, 5_100, 12_345, 15_300])
    readings[at, 4] += 0.1
    events = events_in_readings(counted(readings), made)
    assert _effects(events) == ["unnamed"]
    assert _found(events, "spikes") == len(at)
    assert events.masked[at, 4].all()
    assert events.masked.sum() <= 5 * len(at)


def test_unknown_motion_and_absent_triad_are_no_events() -> None:
    made = motion()
    readings = counted(noisy(mean_readings(made), 15))
    readings[:, 3:] = np.nan
    assert events_in_readings(readings, made).events == ()
    nowhere = replace(made, up=made.up * np.nan, rate=made.rate * np.nan)
    assert events_in_readings(readings, nowhere).events == ()
