"""Rests of a noisy encoder, against the motion that was read."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from tasks.motion.encoder_rate import Rest, rests

T = np.arange(0.0, 30.0, 0.01)
NOISE = 1e-3  # rad
RAMPS = np.clip(T - 10.0, 0.0, 1.0) - np.clip(T - 14.0, 0.0, 1.0)  # up in 1 s, held, down in 1 s


def found(rate: np.ndarray, seed: int = 3, step: float = 0.0) -> list[Rest]:
    noise = NOISE * np.random.default_rng(seed).standard_normal(len(T))
    angle = cumulative_trapezoid(rate, T, initial=0.0) + noise
    if step:
        angle = step * np.round(angle / step)
    variance = np.full(len(T), NOISE**2 + step**2 / 12.0)
    return list(rests(angle, 0.01, variance))


def test_the_stretches_before_and_after_a_turn_are_rests_up_to_its_corners() -> None:
    for seed in range(10):
        before, after = found(RAMPS, seed)
        assert before.first < 10
        assert after.last == len(T)
        assert 9.5 < T[before.last - 1] < 10.06
        assert 14.94 < T[after.first] < 15.5


@pytest.mark.parametrize("step", [0.0, 2e-3])
def test_the_rate_of_a_rest_is_as_uncertain_as_it_errs(step: float) -> None:
    drift = 2e-5 * np.ones_like(T)
    errors = [(one.rate - 2e-5) / one.u for seed in range(40) for one in found(drift, seed, step)]
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(1.0, abs=0.3)


def test_a_rate_that_is_held_and_one_that_swings_are_no_rests() -> None:
    assert not found(np.full_like(T, 0.02))
    assert not found(0.05 * np.sin(2.0 * np.pi * 0.2 * T))
    assert not found(0.3 * np.sin(2.0 * np.pi * 13.0 * T), step=5e-4)  # a stepper's resonance


def test_an_angle_shorter_than_the_means_has_no_rests() -> None:
    assert not list(rests(np.zeros(50), 0.01, np.full(50, NOISE**2)))
