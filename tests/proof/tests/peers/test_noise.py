"""Noise by the Allan variance inside the segments, and whitening by it."""

from dataclasses import replace

import numpy as np
import pytest

from tests.proof.peers.noise import Noise, noises_of, whitened
from tests.proof.peers.observation import Observation
from tests.proof.plant.grades import channel_noise


def test_white_noise_of_the_grade_is_found(observation_clean: Observation) -> None:
    for found, true in zip(observation_clean.noises, channel_noise("tactical"), strict=True):
        assert np.sqrt(found.white) == pytest.approx(true.white, rel=0.1)


def test_what_differs_between_segments_is_no_noise(observation_clean: Observation) -> None:
    observed = observation_clean.observed
    levels = np.random.default_rng(1).normal(0.0, 1.0, len(observed.segments) + 1)
    left = observation_clean.left + levels[observed.segment][:, None] * observation_clean.left.std(
        axis=0
    )
    moved = noises_of(observed, left)
    for found, before in zip(moved, observation_clean.noises, strict=True):
        assert found.white == pytest.approx(before.white, rel=0.02)
        assert found.flicker == pytest.approx(before.flicker, rel=0.05)


def test_channel_that_was_not_recorded_is_left_out(observation_clean: Observation) -> None:
    weight = observation_clean.observed.weight.copy()
    weight[:, 4] = 0.0
    without = replace(
        observation_clean, observed=replace(observation_clean.observed, weight=weight)
    )
    assert without.used == (0, 1, 2, 3, 5)
    assert without.equations[4] is None
    assert without.equations[5] is not None


def test_whitened_noise_has_unit_variance_at_all_frequencies() -> None:
    rate, noise = 25.0, Noise(2.0, 1.0)
    rng = np.random.default_rng(3)
    flat = rng.standard_normal((1, 5000)) * np.sqrt(noise.white * rate / 2.0)
    white = whitened(flat, Noise(noise.white, 0.0), rate)
    assert white.std() == pytest.approx(1.0, rel=0.05)
    assert abs(whitened(np.ones((1, 5000)), noise, rate)).max() < abs(white).max()
