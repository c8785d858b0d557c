"""A table's reported rate is taken only where it is the rate of its angle."""

import numpy as np
import pytest

from tasks.motion.reported_rate import is_rate_of

INTERVAL = 0.01  # s
RAMP = 40  # samples of a ramp
NOISE = 4e-9  # rad, of the encoder


def _course() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, angle and rate of a table that dwells at rates between smooth ramps."""
    fine = 20
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, RAMP * fine))
    pieces, last = [], 0.0
    for rate in (0.5, -1.0, 3.0, -5.0, 0.0, 2.0):
        pieces += [last + (rate - last) * ramp, np.full(400 * fine, rate)]
        last = rate
    rates = np.concatenate(pieces)
    steps = 0.5 * (rates[1:] + rates[:-1]) * INTERVAL / fine
    angles = np.concatenate([[0.0], np.cumsum(steps)])
    return np.arange(len(rates[::fine])) * INTERVAL, angles[::fine], rates[::fine]


@pytest.fixture
def turning() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    t, angle, rate = _course()
    rng = np.random.default_rng(3)
    return t, angle + NOISE * rng.standard_normal(len(t)), rate + 1e-7 * rng.standard_normal(len(t))


def test_the_measured_rate_is_taken(turning: tuple[np.ndarray, ...]) -> None:
    assert is_rate_of(*turning)


def test_a_rate_without_any_noise_is_taken() -> None:
    assert is_rate_of(*_course())


@pytest.mark.parametrize("off", [1.0001, 0.999])
def test_a_rate_of_another_scale_is_not_taken(turning: tuple[np.ndarray, ...], off: float) -> None:
    t, angle, rate = turning
    assert not is_rate_of(t, angle, rate * off)


def test_a_late_rate_is_not_taken(turning: tuple[np.ndarray, ...]) -> None:
    t, angle, rate = turning
    assert not is_rate_of(t, angle, np.interp(t - 0.05 * INTERVAL, t, rate))


def test_differences_of_the_angle_are_not_taken_for_a_measured_rate(
    turning: tuple[np.ndarray, ...],
) -> None:
    t, angle, _ = turning
    assert not is_rate_of(t, angle, np.gradient(angle, t))
    assert not is_rate_of(t, angle, np.concatenate([[0.0], np.diff(angle) / INTERVAL]))


def test_a_filtered_rate_is_not_taken(turning: tuple[np.ndarray, ...]) -> None:
    t, angle, rate = turning
    assert not is_rate_of(t, angle, np.convolve(rate, [0.25, 0.5, 0.25], "same"))


def test_a_coarse_rate_is_not_taken(turning: tuple[np.ndarray, ...]) -> None:
    t, angle, rate = turning
    assert not is_rate_of(t, angle, np.round(rate, 3))


def test_a_rate_that_lacks_what_the_encoder_reads_once_a_turn_is_not_taken(
    turning: tuple[np.ndarray, ...],
) -> None:
    t, angle, rate = turning
    assert not is_rate_of(t, angle, rate * (1.0 + 2e-5 * np.cos(angle)))


def test_gaps_and_few_samples_are_left_to_the_angle(turning: tuple[np.ndarray, ...]) -> None:
    t, angle, rate = turning
    assert not is_rate_of(t[:40], angle[:40], rate[:40])
    with_gap = np.where(np.arange(len(t)) == 500, np.nan, rate)
    assert not is_rate_of(t, angle, with_gap)
    assert not is_rate_of(np.where(t > 10.0, t + 1.0, t), angle, rate)
