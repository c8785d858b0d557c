"""Rates of coarse encoders, against the motion that was read."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from tasks.motion.encoder_rate import EncoderRate, encoder_rate, rests

T = np.arange(0.0, 60.0, 0.01)
NOISE = 1e-3  # rad
RAMP = np.clip((T - 20.0) / 1.5, 0.0, 1.0) - np.clip((T - 40.0) / 1.5, 0.0, 1.0)
TRUE = 2.5 * RAMP  # rad/s: at rest, up a ramp, held, down again, at rest
CORNERS = np.min([np.abs(T - t) for t in (20.0, 21.5, 40.0, 41.5)], axis=0)


def found(noise: float) -> EncoderRate:
    turned = cumulative_trapezoid(TRUE, T, initial=0.0)
    angle = turned + noise * np.random.default_rng(7).standard_normal(len(T))
    return encoder_rate(angle[:, None], 0.01, np.full((len(T), 1), noise**2))


def errors(of: EncoderRate) -> np.ndarray:
    return of.rate[:, 0] - TRUE


def test_a_coarse_encoder_is_smoothed_by_as_much_as_rests_and_held_rates_bear() -> None:
    of = found(NOISE)
    steady = (CORNERS > 3.0) & (T > 1.0) & (T < 59.0)
    shortest = NOISE * np.linalg.norm(of.kernels[0]) / 0.01
    assert errors(of)[steady].std() < 0.02 * shortest


def test_the_ends_of_a_ramp_are_not_rounded_off() -> None:
    of = found(NOISE)
    near = CORNERS < 0.5
    assert np.sqrt((errors(of)[near] ** 2 / of.variance[near, 0]).mean()) < 1.5
    assert np.abs(errors(of)).max() < 0.25  # half a second of smoothing would round off 0.4


def test_the_variance_is_that_of_the_errors_and_of_their_means() -> None:
    of = found(NOISE)
    turning = ~of.at_rest[:, 0]  # each rest has one error
    ratio = errors(of)[turning] ** 2 / of.variance[turning, 0]
    assert np.median(ratio) == pytest.approx(0.45, rel=0.7)
    whole = turning.reshape(-1, 50).all(axis=1)
    means = errors(of).reshape(-1, 50).mean(axis=1)[whole]
    expected = of.variance_of_mean(0.5)[:, 0].reshape(-1, 50).mean(axis=1)[whole]
    assert np.sqrt((means**2).mean()) == pytest.approx(np.sqrt(expected.mean()), rel=0.5)


def test_a_fine_encoder_keeps_the_shortest_window() -> None:
    of = found(1e-9)
    assert len(of.kernels) == 1
    assert np.abs(errors(of)[CORNERS > 0.1]).max() < 0.01


def test_a_rest_has_one_rate_whose_mean_is_no_less_uncertain() -> None:
    of = found(NOISE)
    rest = of.at_rest[:, 0] & (T < 20.0)
    assert rest.mean() > 0.3
    assert np.ptp(of.rate[rest]) == 0.0
    assert of.variance_of_mean(0.5)[rest] == pytest.approx(of.variance[rest])


def test_a_rest_of_which_an_encoder_gives_one_sample_has_no_rate_of_its_own() -> None:
    """Read once in four seconds; of the rests in between smoothing leaves the middle alone."""
    angle = np.repeat([0.0, 0.5, 1.0, 1.5], 11)
    found = list(rests(angle, 4.0, np.full(len(angle), 1e-12)))
    assert [(rest.first, rest.last) for rest in found] == [(0, 3), (36, 44)]
