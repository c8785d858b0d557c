"""What nothing explains is told of where it stands clear of the noise of unit and reference."""

from dataclasses import replace

import numpy as np
import pytest
from engine_run import motion, read, segments

from tasks.explain.evidence.left_over import LeftOver, band_of, remainder
from tasks.explain.inputs.full_rate import FullRate

RUN = motion()
SIGMA = np.repeat([2e-5, 5e-4], 3)
SHAPE = (len(RUN.t), 6)
FREQUENCY = 3.0  # Hz


def run() -> FullRate:
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
    full, found = run(), predicted()
    assert remainder(full, found, left_of(full, found)) is None


def test_what_is_left_is_told_of_without_a_name_in_its_channel_and_adds_nothing() -> None:
    full, found = run(), predicted(wave=3.0)
    rest = remainder(full, found, left_of(full, found))
    assert rest is not None
    assert (rest.effect, rest.channels, rest.share) == ("unnamed", (4,), 0.0)
    assert not rest.contribution.any()


def test_its_band_holds_the_frequency_of_the_wave() -> None:
    full, found = run(), predicted(wave=3.0)
    low, high = band_of(full, found, left_of(full, found), (4,))
    assert low == pytest.approx(FREQUENCY, abs=0.2)
    assert high == pytest.approx(FREQUENCY, abs=0.2)


def test_what_may_be_the_noise_of_the_reference_is_not_told_of() -> None:
    full, found = run(), predicted(wave=3.0)
    left = left_of(full, found)
    assert left.chi2_per_degree[4] > 2.0
    assert remainder(full, found, replace(left, reference=0.5 * left.noise)) is None


def test_a_residual_of_less_power_than_noise_has_a_band_all_the_same() -> None:
    """As where the few readings that are above the noise are masked."""
    full, found = run(), read(RUN)
    full = replace(full, readings=found)
    low, high = band_of(full, found, left_of(full, found), (4,))
    assert 0.0 < low <= high
