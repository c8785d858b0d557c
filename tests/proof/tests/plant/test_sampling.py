"""Converter and filter against brute force."""

import numpy as np
import pytest

from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.effects.electronics import Bandwidth
from tests.proof.plant.procedures import plan_of
from tests.proof.plant.simulate import at_times, filtered, mean_limited, mean_reading
from tests.proof.plant.world import Setting

DEVIATION = 0.3


def noisy(signal: float) -> np.ndarray:
    return signal + DEVIATION * np.random.default_rng(8).standard_normal(400_000)


@pytest.mark.parametrize("signal", [0.0, 0.2, 0.45, 0.8])
def test_the_mean_reading_of_coarse_steps_is_that_of_many_readings(signal: float) -> None:
    declared = mean_reading(np.full((1, 1), signal), np.array([1.0]), np.array([DEVIATION]))
    assert declared[0, 0] == pytest.approx(np.round(noisy(signal)).mean(), abs=3e-3)


@pytest.mark.parametrize("signal", [-1.1, -0.7, 0.0, 0.9, 1.0, 1.4])
def test_the_mean_reading_at_a_limit_is_that_of_many_readings(signal: float) -> None:
    declared = mean_limited(np.full((1, 1), signal), np.array([1.0]), np.array([DEVIATION]))
    assert declared[0, 0] == pytest.approx(np.clip(noisy(signal), -1.0, 1.0).mean(), abs=3e-3)


def test_steps_below_the_noise_change_nothing() -> None:
    signal = np.linspace(-1.0, 1.0, 50)[None]
    assert np.allclose(mean_reading(signal, np.array([0.3]), np.array([0.3])), signal, atol=1e-6)


def test_the_low_pass_lets_half_the_power_through_at_its_corner() -> None:
    case = Case(seed=1)
    call = EffectCall(name="bandwidth", parameters={"corner": 20.0})
    effect = Bandwidth.of(call, Setting(case, plan_of(case)))
    t = np.arange(0.0, 20.0, 0.002)
    for frequency, passed in ((2.0, 1.0), (20.0, np.sqrt(0.5)), (80.0, 1.0 / 16.0)):
        wave = np.sin(2.0 * np.pi * frequency * t)[None]
        inner = filtered(wave, 0.002, [effect])[0, 2000:-2000]
        assert inner.std() / wave[0, 2000:-2000].std() == pytest.approx(passed, rel=5e-3)


def test_sampling_between_points_is_cubic_and_rests_at_the_ends() -> None:
    grid = np.arange(0.0, 10.0)
    cubic = np.stack([grid**3 - 4.0 * grid, 2.0 * grid])
    times = np.array([1.5, 4.25, 7.9])
    declared = at_times(cubic, 0.0, 1.0, times)
    assert np.allclose(declared, [times**3 - 4.0 * times, 2.0 * times])
    assert np.array_equal(at_times(cubic, 0.0, 1.0, np.array([-3.0, 30.0]))[1], [0.0, 18.0])
