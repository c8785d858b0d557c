"""What is left is held against noise read off rests, and not off what a model leaves."""

from dataclasses import replace

import numpy as np
import pytest
from engine_run import motion, read, segments

from tasks.explain.evidence.left_over import LeftOver, band_of, remainder, rest_noise
from tasks.explain.inputs.blocks import FullRate
from tasks.motion.pose import Tracking
from tasks.motion.reference_noise import ReferenceNoise

RUN = motion()
SIGMA = np.repeat([2e-5, 5e-4], 3)
NOTHING = np.zeros((len(RUN.t), 6), bool)


def run(seed: int = 3) -> FullRate:
    readings = read(RUN) + SIGMA * np.random.default_rng(seed).standard_normal((len(RUN.t), 6))
    variance = np.tile([SIGMA[0] ** 2, SIGMA[3] ** 2], (len(segments()) + 1, 1))
    return FullRate(
        readings, RUN, np.full(len(RUN.t), -1), segments(), variance, np.zeros(6),
        np.ones(6, bool),
    )  # fmt: skip


def test_noise_alone_leaves_one_and_nothing_to_explain() -> None:
    left = LeftOver.of(run(), read(RUN), read(RUN), NOTHING)
    assert left.chi2_per_degree == pytest.approx(np.ones(6), abs=0.05)
    assert left.remaining == 0.0
    assert left.explained_share == 1.0


def test_the_share_is_of_the_mismatch_above_noise() -> None:
    full, nominal, found = run(), read(RUN), read(RUN)
    wave = SIGMA[1] * np.sin(40.0 * RUN.t)
    nominal[:, 1] += 10.0 * wave
    found[:, 1] += 5.0 * wave
    assert LeftOver.of(full, nominal, found, NOTHING).explained_share == pytest.approx(
        0.75, abs=0.02
    )


def test_noise_of_the_reference_is_none_of_the_sensor() -> None:
    full = run()
    rough = (
        full.readings - read(RUN) + 1e-3 * np.random.default_rng(4).standard_normal((len(RUN.t), 6))
    )
    assert np.sqrt(rest_noise(full, rough))[:3] == pytest.approx(SIGMA[:3], rel=0.1)


def test_a_unit_that_never_rests_has_the_noise_of_its_neighbouring_samples() -> None:
    full = run()
    moving = replace(RUN, rate=RUN.rate + 0.5)
    noise = rest_noise(replace(full, motion=moving), full.readings - read(RUN))
    assert np.sqrt(noise) == pytest.approx(SIGMA, rel=0.3)


def test_motion_beyond_the_band_of_tracked_poses_is_not_held_against_them() -> None:
    tracking = Tracking(1.0, 1.0, 0.01, 1e-12, 1e-14)
    full = replace(run(), reference_noise=ReferenceNoise(tracking=tracking))
    fast, slow = read(RUN), read(RUN)
    fast[:, 2] += 10.0 * SIGMA[2] * np.sin(2.0 * np.pi * 6.25 * RUN.t)
    slow[:, 2] += 10.0 * SIGMA[2] * np.sin(2.0 * np.pi * 0.1 * RUN.t)
    beyond = LeftOver.of(full, fast, fast, NOTHING)
    within = LeftOver.of(full, slow, slow, NOTHING)
    exact = LeftOver.of(run(), fast, fast, NOTHING)
    assert beyond.chi2_per_degree[2] < 0.15 * exact.chi2_per_degree[2]
    assert within.chi2_per_degree[2] > 50.0


# What nothing explains is told of where it stands clear of the noise of unit and reference.

SHAPE = (len(RUN.t), 6)
FREQUENCY = 3.0  # Hz


def run_left_over_remainder() -> FullRate:
    """The motion as read with noise."""
    readings = read(RUN) + SIGMA * np.random.default_rng(5).standard_normal(SHAPE)
    variance = np.tile([SIGMA[0] ** 2, SIGMA[3] ** 2], (len(segments()) + 1, 1))
    return FullRate(
        readings, RUN, np.full(len(RUN.t), -1), segments(), variance, np.zeros(6), np.ones(6, bool)
    )


def predicted(wave: float = 0.0) -> np.ndarray:
    """What the model says, in accelerometer y wrong by a wave of so many σ."""
    found = read(RUN)
    found[:, 4] += wave * SIGMA[4] * np.sin(2.0 * np.pi * FREQUENCY * RUN.t)
    return found


def left_of(full: FullRate, found: np.ndarray) -> LeftOver:
    return LeftOver.of(full, found, found, np.zeros(SHAPE, bool))


def test_noise_alone_is_not_told_of() -> None:
    full, found = run_left_over_remainder(), predicted()
    assert remainder(full, found, left_of(full, found)) is None


def test_what_is_left_is_told_of_without_a_name_in_its_channel_and_adds_nothing() -> None:
    full, found = run_left_over_remainder(), predicted(wave=3.0)
    rest = remainder(full, found, left_of(full, found))
    assert rest is not None
    assert (rest.effect, rest.channels, rest.share) == ("unnamed", (4,), 0.0)
    assert not rest.contribution.any()


def test_its_band_holds_the_frequency_of_the_wave() -> None:
    full, found = run_left_over_remainder(), predicted(wave=3.0)
    low, high = band_of(full, found, left_of(full, found), (4,))
    assert low == pytest.approx(FREQUENCY, abs=0.2)
    assert high == pytest.approx(FREQUENCY, abs=0.2)


def test_what_may_be_the_noise_of_the_reference_is_not_told_of() -> None:
    full, found = run_left_over_remainder(), predicted(wave=3.0)
    left = left_of(full, found)
    assert left.chi2_per_degree[4] > 2.0
    assert remainder(full, found, replace(left, reference=0.5 * left.noise)) is None


def test_a_residual_of_less_power_than_noise_has_a_band_all_the_same() -> None:
    """As where the few readings that are above the noise are masked."""
    full, found = run_left_over_remainder(), read(RUN)
    full = replace(full, readings=found)
    low, high = band_of(full, found, left_of(full, found), (4,))
    assert 0.0 < low <= high
