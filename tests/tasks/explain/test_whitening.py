"""What the engine takes for noise: white and flicker, and not the physics it does not know yet."""

from dataclasses import replace

import numpy as np
import pytest
from engine_run import RATE, flicker, motion, observed

from tasks.explain.noise import (
    Bands,
    ChannelResidual,
    Noise,
    bands_of,
    in_band,
    padded_length,
    transformed,
    triad_noises,
    weighted,
)

COUNT = padded_length(40_000)  # 27 min at 25 Hz
BANDS = bands_of(COUNT, RATE)


def estimated(series: np.ndarray, floor: float = 0.0) -> Noise:
    return triad_noises([left(series)], BANDS, [floor])[0]


def left(series: np.ndarray) -> ChannelResidual:
    return ChannelResidual(transformed(series[None])[0], np.ones(len(BANDS.sizes)))


def drifting(w: float, b: float, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.sqrt(w) * rng.standard_normal(COUNT) + flicker(COUNT, RATE, b, rng)


@pytest.mark.parametrize("count", [200, 401, 40_000])
def test_bands_hold_every_coefficient_once(count):
    bands: Bands = bands_of(count, RATE)
    assert bands.edges[0] == 0
    assert bands.edges[-1] >= count
    assert (bands.sizes > 0).all()
    assert (np.diff(bands.frequency) > 0).all()
    assert bands.frequency[-1] <= RATE / 2


def test_the_transform_keeps_the_power():
    series = drifting(1.0, 0.1, 3)
    assert (transformed(series[None]) ** 2).sum() == pytest.approx((series**2).sum())


@pytest.mark.parametrize(
    ("w", "b", "scatter"), [(1.0, 0.05, 0.3), (4e-8, 8e-9, 0.13), (1e-10, 2e-10, 0.08)]
)
def test_white_and_flicker_noise_are_recovered(w, b, scatter):
    """Scatter: what the bands between 6 mHz and the corner b/w leave of one run's b."""
    found = [estimated(drifting(w, b, seed)) for seed in range(8)]
    flickers = np.array([one.flicker for one in found])
    assert np.mean([one.white for one in found]) == pytest.approx(w, rel=0.02)
    assert abs(flickers.mean() - b) < scatter * b
    assert flickers.std() < 1.5 * scatter * b


def test_white_noise_alone_has_next_to_no_flicker():
    for seed in range(10):
        one = estimated(drifting(1.0, 0.0, seed))
        assert one.white == pytest.approx(1.0, rel=0.05)
        assert one.flicker < 0.02  # Hz: where it would be as large as the white noise


@pytest.mark.parametrize("what", ["line", "step", "ramp"])
def test_sparse_physics_does_not_pass_for_flicker(what):
    """Each would gain chi-squared by the thousand; corners are tried 22 % apart."""
    t = np.arange(COUNT) / RATE
    series = {
        "line": 0.3 * np.sin(2.0 * np.pi * 0.137 * t),
        "step": 1.0 * (t > 700.0),
        "ramp": 3.0 * t / t[-1],
    }[what]
    assert (series - series.mean()) @ (series - series.mean()) > 1500.0
    for seed in range(3):
        plain = drifting(1.0, 0.05, seed)
        without, updated_noises = estimated(plain), estimated(plain + series)
        assert updated_noises.flicker < 1.3 * without.flicker
        assert updated_noises.white == pytest.approx(without.white, rel=0.02)


def test_the_noise_is_never_below_that_of_rounding():
    rest_variance = 1e-6 * drifting(1.0, 0.0, 0)
    floor = 1e-4
    found = estimated(rest_variance, floor)
    assert (found.variance(BANDS.frequency[BANDS.frequency > 1.0]) >= 0.99 * floor).all()
    assert estimated(np.zeros(COUNT)).white > 0  # something to divide by


def test_noise_scales_with_the_square_of_the_readings():
    series = drifting(1.0, 0.05, 4)
    plain, larger = estimated(series), estimated(1e3 * series)
    assert larger.white == pytest.approx(1e6 * plain.white)
    assert larger.flicker == pytest.approx(1e6 * plain.flicker)


def test_a_triad_tells_the_flicker_of_each_of_its_sensors_better():
    alone, together = [], []
    for seed in range(8):
        lefts = [left(drifting(1.0, 0.01, 3 * seed + k)) for k in range(3)]
        alone += [triad_noises([one], BANDS, [0.0])[0].flicker for one in lefts]
        together += [one.flicker for one in triad_noises(lefts, BANDS, [0.0] * 3)]
    assert np.std(together) < 0.8 * np.std(alone)
    assert np.mean(together) == pytest.approx(0.01, rel=0.4)


def test_a_sensor_unlike_the_others_of_its_triad_keeps_its_own_flicker():
    lefts = [left(drifting(1.0, b, 5)) for b in (0.02, 0.02, 2.0)]
    found = [one.flicker for one in triad_noises(lefts, BANDS, [0.0] * 3)]
    assert found[2] == pytest.approx(2.0, rel=0.25)
    assert max(found[:2]) < 0.06


def test_what_a_fit_took_from_a_band_is_not_taken_for_less_noise():
    """A fit that takes half of the power below 0.05 Hz, and says so, changes nothing."""
    whole = left(drifting(1.0, 0.05, 7))
    count = int(np.searchsorted(BANDS.frequency, 0.05))
    free = np.where(np.arange(len(BANDS.sizes)) < count, 0.5, 1.0)
    fitted = whole.coefficients * np.sqrt(np.repeat(free, BANDS.sizes))
    plain, text, blind = (
        triad_noises([one], BANDS, [0.0])[0].flicker
        for one in (whole, ChannelResidual(fitted, free), ChannelResidual(fitted, whole.free))
    )
    assert text == pytest.approx(plain, rel=0.1)
    assert blind < 0.9 * plain


@pytest.mark.parametrize("line", [3.0, RATE + 3.0])  # Hz; blocks fold what is faster than they are
def test_at_a_line_nothing_is_compared_and_beside_it_all_is(line):
    run = motion()
    blocks = replace(observed(np.zeros((len(run.t), 6)), run), lines=(line,))
    at, beside = (np.cos(2.0 * np.pi * frequency * run.t) for frequency in (3.0, 3.2))
    rows = in_band(weighted([at, beside], np.ones(len(run.t)), blocks), blocks)
    kept = (rows**2).sum(axis=1)
    assert kept[0] < 0.05 * (at**2).sum()
    assert kept[1] > 0.95 * (beside**2).sum()


@pytest.mark.parametrize("order", [2, 4])
def test_noise_of_derivatives_is_recovered(order):
    frequency = np.arange(COUNT) * RATE / 2 / COUNT
    rng = np.random.default_rng(order)
    rising = np.sqrt(1.0 + (frequency / 3.0) ** order) * rng.standard_normal((3, COUNT))
    lefts = [ChannelResidual(each, np.ones(len(BANDS.sizes))) for each in rising]
    for found in triad_noises(lefts, BANDS, [0.0] * 3, order):
        assert found.rises == pytest.approx(3.0, rel=0.1)
        assert found.white == pytest.approx(1.0, rel=0.2)


def test_white_noise_rises_nowhere():
    lefts = [left(drifting(1.0, 0.0, seed)) for seed in range(3)]
    for found in triad_noises(lefts, BANDS, [0.0] * 3, 4):
        assert found.rise(BANDS.frequency[-1:])[0] < 1.1
