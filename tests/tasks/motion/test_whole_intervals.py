"""Means over the intervals of a unit that puts out angles, against integrals by hand."""

import numpy as np
import pytest

from schemas.recording import Recording, Stream
from tasks.motion.reference_noise import reference_noise
from tasks.motion.whole import whole_motion
from tests.manifests import manifest_of

SPAN = 0.1
T = np.arange(0.0, 30.0, 0.005)
AT = np.arange(1.05, 29.0, SPAN)
FAST = 2.0 * np.pi * 2.0


def swinging(noise: float = 0.0) -> Recording:
    """About a level axis at 2 Hz, read ten times a second."""
    manifest = manifest_of(
        "swing", {"heading_deg": 0.0, "gravity_m_s2": 9.8}, {"a": (1.0, 0.0, 0.0)}
    )
    scatter = noise * np.random.default_rng(2).standard_normal(len(T))
    table = Stream(T, {"a_angle": angle(T) + scatter})
    return Recording(manifest, Stream(AT, {}, SPAN), table=table)


def angle(t: np.ndarray) -> np.ndarray:
    return np.asarray(0.3 * np.sin(FAST * t))


def test_a_rate_is_what_the_encoder_gained_between_the_readings() -> None:
    gained = (angle(AT + SPAN / 2) - angle(AT - SPAN / 2)) / SPAN
    motion = whole_motion(swinging())
    assert motion.rate[:, 0] == pytest.approx(gained, abs=1e-4)
    assert np.abs(0.3 * FAST * np.cos(FAST * AT) - gained).max() > 0.1


def test_the_vertical_is_the_mean_of_both_ends() -> None:
    ends = np.cos(angle(AT - SPAN / 2)), np.cos(angle(AT + SPAN / 2))
    assert whole_motion(swinging()).up[:, 2] == pytest.approx(sum(ends) / 2.0, abs=1e-4)


def test_the_noise_of_two_angles_is_that_of_the_rate_between_them() -> None:
    noisy, exact = swinging(1e-4), whole_motion(swinging())
    motion = whole_motion(noisy)
    error = (motion.rate - exact.rate)[:, 0]
    stated = np.sqrt(reference_noise(noisy, motion).variance(motion, SPAN)[:, 0])
    assert error.std() == pytest.approx(np.sqrt((stated**2).mean()), rel=0.4)
