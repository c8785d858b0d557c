"""A simulated reading of the motion errs as its reference does."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from schemas.recording import Recording, Stream
from tasks.explain.inputs.blocks import full_rate
from tasks.explain.inputs.signals import _smoothed, with_gyro_acceleration, within_jumps
from tasks.explain.inputs.simulated_reading import dither, simulated_reading
from tasks.motion.whole import Motion, whole_motion
from tests.moved_by_hand import by_hand, poses, readings, recording
from tests.on_shaft import T, swinging

SEED = 7


def test_a_simulated_reading_errs_as_much_as_the_encoder():
    recording = swinging(1e-3)
    full = full_rate(recording)
    simulated = simulated_reading(recording, full, np.random.default_rng(SEED))
    assert simulated is not None
    true, read = simulated
    resting = (T > 1.0) & (T < 19.0)
    error = (read.rate - true.rate)[resting, 2].std()
    assert 0.5 < error / full.motion.rate[resting, 2].std() < 2.0


def test_rounding_shifts_a_rest_as_a_whole_though_nothing_scatters():
    recording, step = swinging(0.0), 2e-3
    angle = np.interp(T, [20.0, 25.0, 40.0, 45.0], [0.0, 1.5, 1.5, 2.6])
    rounded = Stream(T, {"a_angle": step * np.round(angle / step)})
    recording = replace(recording, table=rounded)
    full = full_rate(recording)
    axes = [
        one.axes
        for one in simulated_reading(recording, full, np.random.default_rng(SEED)) or ()
        if one.axes
    ]
    error = axes[1].angles[:, 0] - axes[0].angles[:, 0]
    rests = [error[(first < T) & (last > T)] for first, last in ((2, 18), (27, 38), (47, 58))]
    assert max(np.ptp(one) for one in rests) < 1e-6
    means = np.array([one.mean() for one in rests])
    assert np.abs(means).max() < 0.51 * step
    assert np.ptp(means) > 0.02 * step


def test_encoders_that_stand_still_have_no_errors_to_simulate():
    recording = swinging(0.0)
    recording = replace(recording, table=Stream(T, {"a_angle": np.zeros(len(T))}))
    assert simulated_reading(recording, full_rate(recording), np.random.default_rng(SEED)) is None


@pytest.mark.parametrize("ratio", [0.0, 0.2, 0.4, 1.5])
def test_the_noise_before_rounding_is_told_by_how_rests_scatter(ratio):
    step, rng = 1e-3, np.random.default_rng(8)
    rests = np.repeat(rng.uniform(0.0, 1.0, 600), 60)
    read = step * np.round(rests / step + ratio * rng.standard_normal(len(rests)))
    level = np.diff(rests, append=rests[-1]) == 0.0
    at_rest = np.convolve(~level, np.ones(13), "same") == 0
    assert dither(read, at_rest, step) / step == pytest.approx(ratio, abs=0.05)


# A unit's temperature without its thermometer's noise, and how fast it changes.

T_RECORDED_SIGNALS = np.arange(0.0, 900.0, 0.02)  # s
SECONDS = np.arange(900.0)
TAU = 300.0  # s
NOISE = 0.03  # K


def read(series: np.ndarray) -> np.ndarray:
    return series + NOISE * np.random.default_rng(4).standard_normal(len(series))


def test_a_warm_up_and_its_rate_are_told_far_better_than_the_thermometer_reads():
    true = 30.0 - 8.0 * np.exp(-T_RECORDED_SIGNALS / TAU)
    series, rate = _smoothed(T_RECORDED_SIGNALS, read(true))
    assert np.std(series - true) < 0.05 * NOISE
    slope = 8.0 / TAU * np.exp(-T_RECORDED_SIGNALS / TAU)
    assert np.abs(rate - slope).max() < 0.02 * slope.max()


def test_a_chamber_that_cycles_is_followed():
    true = 25.0 + 2.0 * np.sin(2.0 * np.pi * T_RECORDED_SIGNALS / 200.0)
    series, rate = _smoothed(T_RECORDED_SIGNALS, read(true))
    assert np.std(series - true) < 0.1 * NOISE
    slope = 2.0 * np.pi / 100.0 * np.cos(2.0 * np.pi * T_RECORDED_SIGNALS / 200.0)
    assert np.std(rate - slope) < 0.01 * np.std(slope)


def test_what_no_polynomial_follows_stays_as_it_was_read():
    jumping = read(25.0 + np.where((T_RECORDED_SIGNALS // 37.0) % 2 == 0, 0.0, 3.0))
    series, _ = _smoothed(T_RECORDED_SIGNALS, jumping)
    assert series is jumping


@pytest.mark.parametrize("rows", [10, len(T_RECORDED_SIGNALS)])
def test_a_constant_temperature_has_no_rate(rows):
    series, rate = _smoothed(T_RECORDED_SIGNALS[:rows], np.full(rows, 22.5))
    assert not rate.any()
    assert (series == 22.5).all()


def of_room(voltage: np.ndarray) -> Recording:
    return cast(Recording, SimpleNamespace(environment=Stream(SECONDS, {"supply": voltage})))


def test_when_a_supply_jumps_between_two_samples_is_not_known():
    wander = 1e-4 * np.round(3.0 * np.sin(SECONDS / 20.0))
    unknown = within_jumps(of_room(5.0 + wander + 0.02 * (SECONDS > 101.0)), T_RECORDED_SIGNALS)
    assert unknown.any()
    assert T_RECORDED_SIGNALS[unknown] == pytest.approx(
        np.clip(T_RECORDED_SIGNALS[unknown], 101.0, 102.0)
    )
    assert unknown.sum() == pytest.approx(50, abs=1)


@pytest.mark.parametrize("series", [np.sin(SECONDS / 20.0), np.floor(SECONDS / 5.0)])
def test_what_goes_its_way_without_a_jump_is_known_everywhere(series):
    assert not within_jumps(of_room(series), T_RECORDED_SIGNALS).any()


# The angular acceleration of a tracked body, against the formula that it was turned by.

TURNED = np.array([[0.0, 1.02, 0.01], [-0.97, 0.0, 0.02], [0.0, 0.01, 1.0]])


def error(motion: Motion) -> float:
    true, inner = by_hand(motion.t), slice(400, -400)
    return float((motion.acceleration - true.acceleration)[inner].std())


def read_gyro_acceleration(turned: np.ndarray | None = None, noise: float = 1e-3) -> np.ndarray:
    values = np.column_stack(list(readings(gyro_noise=noise).columns.values()))
    if turned is not None:
        values[:, :3] = values[:, :3] @ turned.T + 0.05
    return values


@pytest.mark.parametrize("turned", [None, TURNED])
def test_gyros_that_are_less_noisy_give_the_acceleration_however_they_are_mounted(turned):
    motion = whole_motion(recording(reference=poses(1, 1e-3)))
    better = with_gyro_acceleration(motion, read_gyro_acceleration(turned))
    assert error(better) < 0.3 * error(motion)


def test_exact_poses_keep_their_own():
    motion = whole_motion(recording(reference=poses(1, 0.0, 0.0)))
    assert with_gyro_acceleration(motion, read_gyro_acceleration(noise=0.1)) is motion


def test_gyros_that_say_something_else_are_not_used():
    motion = whole_motion(recording(reference=poses(1, 1e-3)))
    other = np.random.default_rng(6).standard_normal((len(motion.t), 6))
    assert with_gyro_acceleration(motion, other) is motion
