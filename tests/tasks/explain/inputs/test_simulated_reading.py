"""A simulated reading of the motion errs as its reference does."""

from dataclasses import replace

import numpy as np
import pytest

from schemas.recording import Stream
from tasks.explain.inputs.full_rate import full_rate
from tasks.explain.inputs.simulated_reading import dither, simulated_reading
from tests.on_shaft import T, swinging

SEED = 7


def test_a_simulated_reading_errs_as_much_as_the_encoder() -> None:
    recording = swinging(1e-3)
    full = full_rate(recording)
    simulated = simulated_reading(recording, full, np.random.default_rng(SEED))
    assert simulated is not None
    true, read = simulated
    resting = (T > 1.0) & (T < 19.0)
    error = (read.rate - true.rate)[resting, 2].std()
    assert 0.5 < error / full.motion.rate[resting, 2].std() < 2.0


def test_rounding_shifts_a_rest_as_a_whole_though_nothing_scatters() -> None:
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


def test_encoders_that_stand_still_have_no_errors_to_simulate() -> None:
    recording = swinging(0.0)
    recording = replace(recording, table=Stream(T, {"a_angle": np.zeros(len(T))}))
    assert simulated_reading(recording, full_rate(recording), np.random.default_rng(SEED)) is None


@pytest.mark.parametrize("ratio", [0.0, 0.2, 0.4, 1.5])
def test_the_noise_before_rounding_is_told_by_how_rests_scatter(ratio: float) -> None:
    step, rng = 1e-3, np.random.default_rng(8)
    rests = np.repeat(rng.uniform(0.0, 1.0, 600), 60)
    read = step * np.round(rests / step + ratio * rng.standard_normal(len(rests)))
    level = np.diff(rests, append=rests[-1]) == 0.0
    at_rest = np.convolve(~level, np.ones(13), "same") == 0
    assert dither(read, at_rest, step) / step == pytest.approx(ratio, abs=0.05)
