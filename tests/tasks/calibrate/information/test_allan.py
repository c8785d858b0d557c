"""The overlapping Allan variance: published values, allantools, and known noise recovered."""

import allantools
import numpy as np
import pytest

from tasks.calibrate.information.noise import (
    STARTS,
    allan_curve,
    flicker_dof,
    overlapping_variances,
    white_dof,
    white_noise,
)

RATE_HZ = 100.0
# NIST SP 1065, 12.4: the nine points of NBS Monograph 140 and their overlapping Allan deviations.
NBS14 = (892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0)


def sp1065_thousand_points() -> np.ndarray:
    """The 1000-point test suite of NIST SP 1065, 12.4 (a congruential generator)."""
    numbers = [1234567890]
    while len(numbers) < 1000:
        numbers.append(16807 * numbers[-1] % 2147483647)
    return np.array(numbers) / 2147483647


def white(rng: np.random.Generator, density: float, count: int) -> np.ndarray:
    return density * np.sqrt(RATE_HZ) * rng.normal(size=count)


def flicker(rng: np.random.Generator, h: float, count: int) -> np.ndarray:
    """S(f) = h/f by shaping the spectrum of a record twice as long."""
    f = np.fft.rfftfreq(2 * count, 1.0 / RATE_HZ)
    shape = np.zeros(len(f))
    shape[1:] = np.sqrt(h / f[1:] * RATE_HZ / 2.0)
    return np.fft.irfft(np.fft.rfft(rng.normal(size=2 * count)) * shape)[:count]


@pytest.mark.parametrize(("size", "deviation"), [(1, 91.22945), (2, 85.95287)])
def test_the_nine_points_of_nist_sp_1065(size, deviation):
    found = np.sqrt(overlapping_variances(np.array([NBS14]), [size])[0, 0])
    assert found == pytest.approx(deviation, abs=5e-6)


@pytest.mark.parametrize(
    ("size", "deviation"), [(1, 2.922319e-1), (10, 9.159953e-2), (100, 3.241343e-2)]
)
def test_the_thousand_points_of_nist_sp_1065(size, deviation):
    found = np.sqrt(overlapping_variances(sp1065_thousand_points()[None], [size])[0, 0])
    assert found == pytest.approx(deviation, rel=2e-7)


def test_allantools_gives_the_same_overlapping_deviations():
    readings = np.random.default_rng(3).normal(size=(2, 5000)).cumsum(axis=1) + 7.0
    curve = allan_curve([readings], 1.0 / RATE_HZ)
    for channel in range(2):
        _, theirs, _, _ = allantools.oadev(
            readings[channel], rate=RATE_HZ, data_type="freq", taus=curve.tau
        )
        ours = np.sqrt(curve.variance[:, channel])
        every_start = curve.tau * RATE_HZ < 2 * STARTS
        assert ours[every_start] == pytest.approx(theirs[every_start], rel=1e-9)
        assert ours == pytest.approx(theirs, rel=0.02)


@pytest.mark.parametrize("size", [1, 2, 16, 256])
def test_allantools_gives_the_same_degrees_of_freedom(size):
    points = 3001
    assert white_dof(points - 1, size) == pytest.approx(
        allantools.edf_simple(points, size, alpha=0), rel=1e-12
    )
    if size > 1:  # at 1, allantools lacks the square of the numerator that SP 1065 prints
        assert flicker_dof(points - 1, size) == pytest.approx(
            allantools.edf_simple(points, size, alpha=-1), rel=1e-12
        )


def test_rests_count_by_their_length():
    rng = np.random.default_rng(5)
    short, long = rng.normal(size=(1, 300)), rng.normal(size=(1, 900))
    curve = allan_curve([short, long], 0.01)
    expected = 0.25 * overlapping_variances(short, [4]) + 0.75 * overlapping_variances(long, [4])
    assert curve.variance[2] == pytest.approx(expected[0])


def test_white_noise_is_recovered_beside_flicker_walk_and_angle_noise():
    rng = np.random.default_rng(11)
    density, z = 2e-3, []
    for _ in range(60):
        rests = []
        for _ in range(6):
            noise = white(rng, density, 3000) + flicker(rng, 0.3 * density**2, 3000)
            noise += 2e-3 * density * rng.normal(size=3000).cumsum()
            noise += 0.02 * np.diff(rng.normal(size=3001))
            rests.append(noise[None])
        found = white_noise(allan_curve(rests, 1.0 / RATE_HZ), 0)
        assert found is not None
        z.append((np.sqrt(found.density) - density) / (found.u / (2.0 * density)))
    assert np.mean(np.abs(z) < 2.0) > 0.85
    assert abs(np.mean(z)) < 0.6


def test_a_low_pass_does_not_hide_the_white_noise():
    rng = np.random.default_rng(13)
    density = 1e-3
    readings = white(rng, density, 40000)
    filtered = np.empty_like(readings)
    last = 0.0
    for k, reading in enumerate(readings):
        last += 0.5 * (reading - last)
        filtered[k] = last
    found = white_noise(allan_curve([filtered[None, 100:]], 1.0 / RATE_HZ), 0)
    assert found is not None
    assert np.sqrt(found.density) == pytest.approx(density, rel=0.04)


def test_where_a_random_walk_alone_rules_no_white_noise_is_claimed():
    walk = np.random.default_rng(17).normal(size=400_000).cumsum()
    readings = walk.reshape(1, -1, 20).mean(axis=2)
    assert white_noise(allan_curve([readings], 0.01), 0) is None


def test_rests_of_three_rows_have_no_curve():
    assert len(allan_curve([np.ones((3, 3))], 0.01).tau) == 0
