"""Events are recognised for what they are, and nothing is found where nothing happened."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.explain.events.codes import (
    CodeFault,
    NoiseEstimate,
    Quantisation,
    cut_off,
    find_repeats,
    find_torn_codes,
    rounding_bias,
    torn_codes,
)
from tasks.explain.events.event import Events
from tasks.explain.events.saturation import clipping_loss
from tasks.readings.lattice import Quantiser, quantiser_of
from tasks.words import say, texts
from tests.tasks.explain.events.made_up import (
    SIGMA,
    counted,
    found_in,
    mean_readings,
    motion,
    noisy,
    sizes,
)

MADE = motion(minutes=2.0)
EVERY = len(MADE.t)


def _effects(events: Events) -> list[str]:
    return [event.effect for event in events.events]


def _found(events: Events, name: str) -> float:
    (event,) = events.events
    return next(each.value for each in event.parameters if each.name == name)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("steps", [None, (1e-4, 2e-3), (1e-3, 5e-3)])
def test_clean_run_has_no_events(seed, steps):
    readings = noisy(mean_readings(MADE), seed)
    events = found_in(readings if steps is None else counted(readings, steps), MADE)
    assert events.events == ()
    assert not events.masked.any()


@pytest.mark.parametrize("limit", [4.9, 5.013])
def test_gyro_limit_is_found_and_its_mean_predicted(limit):
    made = motion()
    mean = mean_readings(made)
    readings = noisy(mean, 1)
    readings[:, :3] = np.clip(readings[:, :3], -limit, limit)
    events = found_in(counted(readings), made)
    assert _effects(events) == ["gyro_saturation"]
    assert _found(events, "limit") == pytest.approx(limit, abs=1e-4)
    beyond = np.abs(mean[:, 2]) > limit
    assert events.masked[beyond, 2].all()
    applied = events.applied(made.t, mean)
    assert np.mean(readings[beyond] - applied[beyond]) == pytest.approx(0, abs=5 * 5e-3 / 50)


def test_limit_on_one_side_leaves_the_other_side_alone():
    made = motion()
    mean = mean_readings(made)
    readings = noisy(mean, 2)
    readings[:, :3] = np.minimum(readings[:, :3], 4.5)
    events = found_in(counted(readings), made)
    assert _effects(events) == ["gyro_saturation"]
    low = mean[:, 2] < -4.6
    assert low.any()
    assert np.array_equal(events.applied(made.t, mean)[low], mean[low])


def test_visible_steps_are_found_with_the_noise_below_them():
    made = motion()
    readings = counted(noisy(mean_readings(made), 4), (3e-3, 2e-3))
    events = found_in(readings, made)
    assert _effects(events) == ["coarse_quantisation"]
    (event,) = events.events
    assert isinstance(event, Quantisation)
    assert event.channels == (0, 1, 2)
    assert _found(events, "gyro") == pytest.approx(3e-3, rel=1e-6)
    assert np.array(event.noises) == pytest.approx([1e-3] * 3, rel=0.1)


def test_mean_of_rounded_noise_follows_the_series():
    noise = np.random.default_rng(5).standard_normal(400_000)
    for mean in (0.1, 0.31, 0.45):
        shift = rounding_bias(np.array([mean]), Quantiser(1.0, 0.0), 0.3)[0]
        assert np.round(mean + 0.3 * noise).mean() == pytest.approx(mean + shift, abs=4e-3)


def test_what_a_limit_cuts_off_is_the_mean_beyond_it():
    noise = np.random.default_rng(6).standard_normal(400_000)
    for mean in (-1.0, 0.0, 2.0):
        lost = clipping_loss(np.array([mean]), 0.5, 1.0)[0]
        assert np.minimum(mean + noise, 0.5).mean() == pytest.approx(mean - lost, abs=8e-3)
    assert clipping_loss(np.array([2.0]), 0.5, 0.0)[0] == 1.5


def test_lost_samples_are_counted_and_placed():
    made = motion()
    mean = mean_readings(made)
    gone = np.r_[6_710, 14_711, 14_712]  # one within a ramp, two within another
    arrived = np.delete(counted(noisy(mean, 7)), gone, axis=0)
    t = made.t[: len(arrived)]
    observed = made.taken(np.arange(len(arrived)))
    events = found_in(arrived, observed)
    assert _effects(events) == ["dropped_samples"]
    assert [_found(events, name) for name in ("lost_1", "lost_2")] == [1, 2]
    assert _found(events, "time_1") == pytest.approx(67.1, abs=0.1)
    assert _found(events, "time_2") == pytest.approx(147.1, abs=0.1)
    off = arrived - events.applied(t, mean[: len(t)])
    assert off[15_000:-10].std(axis=0) == pytest.approx(SIGMA, rel=0.1)


@pytest.mark.parametrize("late", [0.0123, 1e-4])
def test_delays_that_do_not_jump_are_left_to_the_regression(late):
    made = motion()
    taken_at = made.t + (late if late > 1e-3 else late * made.t)  # an offset, or a fast clock
    mean = np.column_stack([np.interp(taken_at, made.t, each) for each in mean_readings(made).T])
    assert found_in(counted(noisy(mean, 8)), made).events == ()


def test_gaps_in_the_stamps_are_a_remark():
    made = motion()
    kept = np.delete(np.arange(len(made.t)), np.r_[900:905, 12_000])
    readings = counted(noisy(mean_readings(made), 9))[kept]
    events = found_in(readings, made.taken(kept))
    assert events.events == ()
    assert "2 gaps, 6" in say(events.remarks[0], "en")


def test_spikes_are_counted_and_masked():
    made = motion()
    readings = noisy(mean_readings(made), 12)
    at = np.array([300, 5_100, 12_345, 15_300])
    readings[at, 4] += 0.1
    events = found_in(counted(readings), made)
    assert _effects(events) == ["unnamed"]
    assert _found(events, "spikes") == len(at)
    assert events.masked[at, 4].all()
    assert events.masked.sum() <= 5 * len(at)


def test_unknown_motion_and_absent_triad_are_no_events():
    made = motion()
    readings = counted(noisy(mean_readings(made), 15))
    readings[:, 3:] = np.nan
    assert found_in(readings, made).events == ()
    nowhere = replace(made, up=made.up * np.nan, rate=made.rate * np.nan)
    assert found_in(readings, nowhere).events == ()


# Rows that repeat others are told; coarse, quiet or smooth readings repeat by themselves.


def test_one_vibration_that_all_axes_share_is_no_repeat():
    shaken = 0.02 * np.random.default_rng(12).standard_normal(EVERY)
    readings = mean_readings(MADE)
    readings[:, :3] = noisy(readings, 13)[:, :3]
    readings[:, 3:] += shaken[:, None] * np.array([0.9, 0.5, -0.7])
    assert found_in(counted(readings, (1e-4, 4e-3)), MADE).events == ()


def test_readings_without_noise_are_no_repeats():
    readings = counted(mean_readings(MADE))
    assert find_repeats(readings, MADE, [quantiser_of(column) for column in readings.T]) is None
    assert find_repeats(mean_readings(MADE), MADE, [None] * 6) is None


def test_accelerometers_read_twice_as_often_as_they_sample_are_held():
    readings = counted(noisy(mean_readings(MADE), 6))
    readings[1::2, 3:] = readings[: EVERY // 2 * 2 : 2, 3:]
    events = found_in(readings, MADE)
    assert [event.effect for event in events.events] == ["repeated_samples"]
    assert events.events[0].channels == (3, 4, 5)
    assert sizes(events) == pytest.approx({"held_accel": 0.5}, abs=0.01)
    mean = mean_readings(MADE)
    held = events.applied(MADE.t, mean)
    assert np.mean(held[1::2, 3:] == mean[: EVERY // 2 * 2 : 2, 3:]) > 0.99
    assert np.array_equal(held[:, :3], mean[:, :3])
    right = events.corrected(MADE.t, readings, mean) - mean
    assert abs(right[1000:].mean(axis=0)).max() < 5e-4


def test_a_few_held_rows_are_told_and_their_stamps_are_right():
    readings = counted(noisy(mean_readings(MADE), 7))
    rows = np.random.default_rng(8).choice(np.arange(10, EVERY), 60, replace=False)
    readings[np.sort(rows)] = readings[np.sort(rows) - 1]
    events = found_in(readings, MADE)
    assert sizes(events) == pytest.approx(
        {"held_gyro": 60 / EVERY, "held_accel": 60 / EVERY}, rel=0.1
    )
    assert np.array_equal(events.events[0].sampled_at(MADE.t), MADE.t)


def test_doubled_rows_let_later_stamps_slip():
    right = counted(noisy(mean_readings(MADE), 9))
    twice = np.sort(np.random.default_rng(10).choice(EVERY, 80, replace=False))
    readings = np.repeat(right, 1 + np.isin(np.arange(EVERY), twice), axis=0)[:EVERY]
    events = found_in(readings, MADE)
    assert set(sizes(events)) == {"doubled_gyro", "doubled_accel"}
    assert events.events[0].sampled_at(MADE.t)[-1] == pytest.approx(MADE.t[-1] - 0.8, abs=0.03)


def test_rows_between_their_neighbours_are_interpolated():
    readings = noisy(mean_readings(MADE), 11)
    last = EVERY // 2 * 2 - 1
    readings[1:last:2] = 0.5 * (readings[0 : last - 1 : 2] + readings[2 : last + 1 : 2])
    events = found_in(readings, MADE)
    assert [event.effect for event in events.events] == ["repeated_samples"]
    assert sizes(events) == pytest.approx(
        {"interpolated_gyro": 0.5, "interpolated_accel": 0.5}, abs=0.01
    )


def test_rows_interpolated_by_their_number_are_told_though_stamps_scatter():
    rows, fresh = np.arange(EVERY), np.arange(0, EVERY, 3)
    sampled = noisy(mean_readings(MADE), 14)[fresh]
    readings = np.column_stack([np.interp(rows, fresh, column) for column in sampled.T])
    scattered = MADE.t + 1e-3 * np.random.default_rng(15).standard_normal(EVERY)
    quantisers = [quantiser_of(column) for column in readings.T]
    repeats = find_repeats(readings, replace(MADE, t=scattered), quantisers)
    assert repeats is not None
    assert repeats.parameters[0].name == "interpolated_gyro"
    assert repeats.parameters[0].value == pytest.approx(2 / 3, abs=0.02)


# A high byte of the row before is put right; noise, held rows and a lag are no such fault.

STEP = np.repeat([1.0 / 131.0 * np.pi / 180.0, 9.8 / 16384.0], 3)


MADE_TORN_CODES = motion(minutes=2.0, top=4.0)  # 30,000 codes either way


def codes(seed: int) -> np.ndarray:
    """Whole codes of a run with noise of some codes."""
    return np.round(noisy(mean_readings(MADE_TORN_CODES), seed) / STEP).astype(int)


def fault(faulty: np.ndarray) -> CodeFault | None:
    return find_torn_codes(faulty * STEP, MADE_TORN_CODES)


def test_a_high_byte_of_the_row_before_is_put_right():
    right = codes(9)
    faulty, late = right.copy(), np.random.default_rng(9).random(len(right)) < 0.4
    late[0] = False
    mixed = (np.roll(right[:, 4], 1) >> 8 << 8) + (right[:, 4] & 0xFF)
    faulty[:, 4] = np.where(late, mixed, right[:, 4])
    found = fault(faulty)
    assert found is not None
    assert found.channels == (4,)
    assert all("high byte" in text or "高字节" in text for text in texts(found.title).values())
    wrong = (found.undone(faulty * STEP) - right * STEP)[:, 4] / STEP[4]
    assert np.mean(np.abs(wrong) > 0.5) < 1e-3


def wide_noise(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Whole codes of a step so fine that noise is a fourth of a byte, and the step (6,)."""
    step = SIGMA / 64.0
    return np.round(noisy(mean_readings(MADE_TORN_CODES), seed) / step).astype(int), step


def test_a_high_byte_of_the_row_before_is_told_where_noise_hides_each_one():
    right, step = wide_noise(11)
    faulty, late = right.copy(), np.random.default_rng(11).random(len(right)) < 0.7
    late[0] = False
    mixed = (np.roll(right, 1, axis=0) >> 8 << 8) + (right & 0xFF)
    faulty[:, :3] = np.where(late[:, None], mixed, right)[:, :3]
    found = find_torn_codes(faulty * step, MADE_TORN_CODES)
    assert found is not None
    assert found.channels == (0, 1, 2)
    was, wrong = faulty - right, found.undone(faulty * step) / step - right
    assert np.mean(was[:, :3] != 0) > 0.1
    assert np.mean(np.abs(wrong[:, :3]) > 0.5) < 0.2 * np.mean(was[:, :3] != 0)


def test_a_high_byte_of_the_row_after_is_not_called_that_of_the_row_before():
    right, step = wide_noise(12)
    faulty, early = right.copy(), np.random.default_rng(12).random(len(right)) < 0.7
    early[-1] = False
    mixed = (np.roll(right, -1, axis=0) >> 8 << 8) + (right & 0xFF)
    faulty[:, 0] = np.where(early, mixed[:, 0], right[:, 0])
    assert torn_codes(faulty[:, 0], mean_readings(MADE_TORN_CODES)[:, 0] / step[0]) is None


@pytest.mark.parametrize("share", [0.25, 0.5])
def test_held_rows_have_no_high_byte_of_their_own(share):
    """What a logger of three rows in four lost looks late, as a high byte does."""
    right = codes(13)
    fresh = np.random.default_rng(13).random(len(right)) < share
    fresh[0] = True
    held = right[np.maximum.accumulate(np.where(fresh, np.arange(len(right)), 0))]
    assert fault(held) is None


@pytest.mark.parametrize("seed", [2, 6, 7])
def test_a_unit_that_lags_has_the_high_byte_of_an_earlier_row_and_the_low_one_as_well(
    seed,
):
    """It is off by a byte wherever the prediction is well ahead, but smoothly."""
    rng = np.random.default_rng(seed)
    t = np.arange(12_000) / 200.0
    waves = [(rng.uniform(500, 2500), rng.uniform(0.1, 2.5), rng.uniform(0, 6)) for _ in range(5)]
    early, late = (
        sum(size * np.sin(2.0 * np.pi * f * at + phase) for size, f, phase in waves)
        for at in (t, t - 0.033)
    )
    assert torn_codes(np.round(late + 8.0 * rng.standard_normal(len(t))), np.asarray(early)) is None


# Steps that show because a limit took a channel's noise away are no coarse resolution.


def found_quantisation(noise: float, step: float, scale: float = 1.0) -> Events:
    """Accelerometer z with a part of the others' noise and signal, all in the same steps, m/s²."""
    made = motion(minutes=6.0)
    mean = mean_readings(made)
    readings = noisy(mean, 21)
    readings[:, 5] = scale * mean[:, 5] + noise * (readings[:, 5] - mean[:, 5])
    return found_in(counted(readings, (1e-4, step)), made)


def test_a_channel_that_lost_noise_and_signal_is_a_remark():
    events = found_quantisation(0.2, 5e-3, 0.7)
    assert events.events == ()
    assert "the accelerometer z reads 70 % of what its motion gives" in say(
        events.remarks[-1], "en"
    )


def test_a_channel_that_is_quieter_than_the_others_shows_its_resolution():
    (event,) = found_quantisation(0.2, 5e-3).events
    assert (event.effect, event.channels) == ("coarse_quantisation", (5,))


def test_a_bias_in_place_of_an_input_is_no_share_of_it():
    steps = [Quantiser(1e-3, 0.0)] * 3
    estimates = [NoiseEstimate(c, q, 0.1 if c == 0 else 0.7, 0.0) for c, q in enumerate(steps)]
    readings = np.full((100, 6), -0.01)
    assert cut_off(estimates, readings, lambda _: np.full(100, 5e-5)) == {}
    assert cut_off(estimates, np.full((100, 6), 0.7), lambda _: np.ones(100)) == {0: 0.7}
