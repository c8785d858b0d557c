"""Derivatives of an encoder's angle."""

import numpy as np
import pytest

from tasks.motion.smooth import smooth_derivatives

T = np.arange(0.0, 10.0, 0.01)


def swing(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return np.sin(2 * t), 2 * np.cos(2 * t), -4 * np.sin(2 * t)


@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 1000.0])
def test_derivatives_of_a_swing(rate_hz: float) -> None:
    t = np.arange(0.0, 10.0, 1 / rate_hz)
    found = smooth_derivatives(t, swing(t)[0][:, None], T[100:-100])
    for observed, true in zip(found, swing(T[100:-100]), strict=True):
        assert observed[:, 0] == pytest.approx(true, abs=0.02)


def test_uneven_stamps_are_no_motion() -> None:
    t = np.sort(T + np.random.default_rng(3).uniform(-0.003, 0.003, len(T)))
    _, rate, acceleration = smooth_derivatives(t, 0.5 * t[:, None], T[100:-100])
    assert rate[:, 0] == pytest.approx(np.full(len(rate), 0.5), abs=1e-9)
    assert np.abs(acceleration).max() < 1e-6


def test_the_noise_of_the_encoder_does_not_become_acceleration() -> None:
    noise = 5e-6 * np.random.default_rng(4).standard_normal(len(T))
    angle = (0.3 * T**2 + noise)[:, None]
    _, _, acceleration = smooth_derivatives(T, angle, T[100:-100])
    assert acceleration.mean() == pytest.approx(0.6, abs=1e-3)
    assert acceleration.std() < 0.02
    assert np.diff(angle[:, 0], 2).std() / 0.01**2 > 0.1  # what it would be without a window


def test_ramps_keep_their_sharp_ends() -> None:
    rate = np.clip(2.0 * (T - 3.0), 0.0, 5.0)
    angle = np.cumsum(rate) * 0.01
    _, _, acceleration = smooth_derivatives(T, angle[:, None], T)
    true = np.where((T > 3.0) & (T < 5.5), 2.0, 0.0)
    gain = acceleration[:, 0] @ true / (acceleration[:, 0] @ acceleration[:, 0])
    assert gain == pytest.approx(1.0, abs=0.01)


def test_two_samples_have_no_derivative() -> None:
    assert np.isnan(smooth_derivatives(T[:2], T[:2, None], T[:2])[1]).all()


def test_nothing_is_known_in_a_gap_of_the_samples() -> None:
    kept = (T < 4.0) | (T > 6.0)
    found = smooth_derivatives(T[kept], swing(T[kept])[0][:, None], np.array([2.0, 5.0, 8.0, 11.0]))
    for each in found:
        assert np.isfinite(each[:, 0]).tolist() == [True, False, True, False]


def test_no_derivative_is_made_of_a_line_drawn_over_a_gap() -> None:
    kept = (T < 4.0) | (T > 4.08)  # short enough for the angle to be known all through
    angle, rate, acceleration = smooth_derivatives(T[kept], swing(T[kept])[0][:, None], T[100:-100])
    assert np.isfinite(angle).all()
    for found, true in ((rate, 2 * np.cos(2 * T)), (acceleration, -4 * np.sin(2 * T))):
        known = np.isfinite(found[:, 0])
        assert 10 <= (~known).sum() <= 20
        assert found[known, 0] == pytest.approx(true[100:-100][known], abs=0.02)


def test_a_fast_oscillation_is_as_large_between_the_samples_as_at_them() -> None:
    """Else every unit whose clock is late would seem to amplify, as one that has a lead does."""
    pulse = 2 * np.pi * 3.0
    middles = T[100:-100] + 0.005
    _, rate, _ = smooth_derivatives(T, np.sin(pulse * T)[:, None], middles)
    assert rate[:, 0] == pytest.approx(pulse * np.cos(pulse * middles), abs=3e-3 * pulse)


def test_the_rate_of_a_quiet_encoder_is_not_rounded_on_a_smooth_ramp() -> None:
    rate = 2.5 * (1.0 - np.cos(np.pi * T / 2.0))
    angle = (2.5 * (T - 2.0 / np.pi * np.sin(np.pi * T / 2.0)))[:, None]
    inner = T[100:-100]
    _, quiet, _ = smooth_derivatives(T, angle, inner)
    assert quiet[:, 0] == pytest.approx(rate[100:-100], abs=1e-6)
    noise = 1e-4 * np.random.default_rng(6).standard_normal(angle.shape)
    _, noisy, _ = smooth_derivatives(T, angle + noise, inner)
    assert (noisy[:, 0] - rate[100:-100]).std() < 0.5 * 0.95 * 1e-4 / 0.01  # not the quartic's


def test_a_coarse_encoder_does_not_damp_a_shaft_that_shakes() -> None:
    """A stepper's resonance of 13 Hz, ten times the encoder's step: a parabola takes a third."""
    angle = 0.006 * np.sin(2 * np.pi * 13.0 * T)
    rate = 0.006 * 2 * np.pi * 13.0 * np.cos(2 * np.pi * 13.0 * T)[100:-100]
    coarse = (0.0015 * np.round(angle / 0.0015))[:, None]
    _, found, _ = smooth_derivatives(T, coarse, T[100:-100])
    assert found[:, 0] @ rate / (rate @ rate) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("interval", [0.01 - 1e-14, 0.01, 0.01 + 1e-14])
def test_the_last_digit_of_a_stamp_chooses_no_window(interval: float) -> None:
    t = interval * np.arange(1000)
    _, rate, _ = smooth_derivatives(t, swing(t)[0][:, None], t[100:-100])
    _, at_once, _ = smooth_derivatives(T, swing(T)[0][:, None], T[100:-100])
    assert rate == pytest.approx(at_once, abs=1e-9)
