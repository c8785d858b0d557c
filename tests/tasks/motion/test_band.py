"""The band of poses, where their noise is not the same at all frequencies."""

import numpy as np

from tasks.motion.band import band_edge, seen_by_gyros

INTERVAL, SECONDS = 0.01, 120.0  # s
SWINGS = ((1.0, 0.3), (0.02, 3.0), (0.01, 6.0))  # rad, Hz: slow turns and a hand that shakes
TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def turns() -> tuple[np.ndarray, np.ndarray]:
    """Angles (n, 3) as a solver tells them, whose noise is white in the rate, and true rates."""
    rng = np.random.default_rng(4)
    t = np.arange(0.0, SECONDS, INTERVAL)
    phases = rng.uniform(0.0, 2 * np.pi, (len(SWINGS), 3))
    swings = [(a, 2 * np.pi * f, p) for (a, f), p in zip(SWINGS, phases, strict=True)]
    angle = sum(a * np.sin(w * t[:, None] + p) for a, w, p in swings)
    rate = sum(a * w * np.cos(w * t[:, None] + p) for a, w, p in swings)
    noise = np.cumsum(rng.normal(0.0, 5e-4, angle.shape), axis=0)
    return np.asarray(angle + noise), np.asarray(rate)


def test_gyros_show_that_poses_tell_a_motion_that_their_own_spectrum_hides() -> None:
    angle, rate = turns()
    assert band_edge([angle], INTERVAL) < 2.0
    assert 5.0 < seen_by_gyros([angle], [rate], INTERVAL) < 8.0


def test_neither_axes_nor_scale_factors_nor_a_delay_of_the_gyros_matter() -> None:
    angle, rate = turns()
    late = np.roll(1.2 * rate @ TURN, 7, axis=0)
    assert seen_by_gyros([angle], [late], INTERVAL) == seen_by_gyros([angle], [rate], INTERVAL)


def test_gyros_of_another_body_see_nothing() -> None:
    angle, rate = turns()
    other = np.random.default_rng(5).normal(0.0, 1.0, rate.shape)
    assert seen_by_gyros([angle], [other], INTERVAL) == 0.0


def test_a_stretch_shorter_than_the_window_tells_nothing() -> None:
    angle, rate = turns()
    assert seen_by_gyros([angle[:300]], [rate[:300]], INTERVAL) == 0.0
