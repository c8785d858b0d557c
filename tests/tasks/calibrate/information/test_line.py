"""Non-linearity and asymmetry: planted ones are found in ppm, noise is not taken for one."""

import numpy as np
import pytest

from tasks.calibrate.information.entry import asymmetry, nonlinearity

RATE = np.radians([-300.0, -200.0, -100.0, -50.0, -10.0, 10.0, 50.0, 100.0, 200.0, 300.0])
FAINT = 1e-16 * np.eye(len(RATE))


def test_a_straight_line_has_neither():
    output = 1.01 * RATE + 0.003
    crooked, lopsided = nonlinearity(RATE, output, FAINT), asymmetry(RATE, output, FAINT)
    assert crooked.value == pytest.approx(0.0, abs=1e-12)
    assert lopsided.value == pytest.approx(0.0, abs=1e-12)
    assert not crooked.significant
    assert not lopsided.significant


def test_a_cubic_term_is_found_as_its_largest_residual_over_full_scale():
    output = RATE + 1e-5 * RATE**3
    found = nonlinearity(RATE, output, FAINT)
    slope, offset = np.polyfit(RATE, output, 1)
    largest = np.abs(output - slope * RATE - offset).max()
    assert found.value == pytest.approx(largest / np.abs(output).max(), rel=1e-9)
    assert found.value > 2e-5
    assert found.significant


def test_asymmetry_is_the_difference_of_the_slopes_over_their_mean():
    output = np.where(RATE > 0, 1.002, 0.999) * RATE + 0.01
    found = asymmetry(RATE, output, FAINT)
    assert found.value == pytest.approx(0.003 / 1.0005, rel=1e-9)
    assert found.significant


def test_a_cubic_term_is_no_asymmetry():
    found = asymmetry(RATE, RATE + 1e-5 * RATE**3, FAINT)
    assert found.value == pytest.approx(0.0, abs=1e-12)


def test_the_uncertainty_of_the_asymmetry_is_its_scatter_and_noise_is_seldom_significant():
    rng = np.random.default_rng(7)
    noise = 1e-5
    found = [
        asymmetry(RATE, RATE + noise * rng.normal(size=len(RATE)), noise**2 * np.eye(len(RATE)))
        for _ in range(2000)
    ]
    z = np.array([each.value / each.u for each in found])
    assert np.std(z) == pytest.approx(1.0, abs=0.05)
    assert 0.003 < np.mean([each.significant for each in found]) < 0.02


def test_noise_is_seldom_a_significant_nonlinearity():
    rng = np.random.default_rng(8)
    noise = 1e-5
    found = [
        nonlinearity(RATE, RATE + noise * rng.normal(size=len(RATE)), noise**2 * np.eye(len(RATE)))
        for _ in range(2000)
    ]
    assert 0.003 < np.mean([each.significant for each in found]) < 0.02


@pytest.mark.parametrize("kept", [RATE > 0, abs(RATE) > 4.0])
def test_without_two_rates_each_way_there_is_no_asymmetry(kept):
    few = RATE[kept]
    assert np.isnan(asymmetry(few, few, 1e-16 * np.eye(len(few))).value)


def test_two_rates_are_always_a_straight_line_and_give_no_nonlinearity():
    few = RATE[[0, -1]]
    assert np.isnan(nonlinearity(few, few, 1e-16 * np.eye(2)).value)


def test_a_gyro_that_reads_nothing_has_neither():
    assert np.isnan(nonlinearity(RATE, 0.0 * RATE, FAINT).value)
    assert np.isnan(asymmetry(RATE, 0.0 * RATE, FAINT).value)
