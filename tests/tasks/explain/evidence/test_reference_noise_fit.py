"""A low-pass that only quietens the encoder is told from one that the unit has."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import uniform_filter1d

from schemas.recording import ACCEL, GYRO, Manifest, Recording, Stream
from tasks.explain.evidence.left_over import LeftOver
from tasks.explain.evidence.reference_noise_fit import fitted_to_reference_noise
from tasks.explain.inputs.full_rate import full_rate
from tasks.motion.whole import Motion

T = np.arange(0.0, 60.0, 0.01)
ANGLE = 0.3 * np.sin(2.0 * np.pi * 0.25 * T) ** 3 * (T > 20.0)
KEYS = [{("bandwidth", 0)}]


@dataclass(frozen=True)
class Smoothed:
    """Predicts the motion's rates as means over so many samples."""

    samples: int

    def prediction(self, motion: Motion) -> np.ndarray:
        rate = uniform_filter1d(motion.rate, self.samples, axis=0)
        return np.column_stack([rate, motion.force])

    def without(self, _: Any) -> "Smoothed":
        return Smoothed(1)


def findings(encoder_noise: float, own_samples: int) -> set[int]:
    """Which are put down to the encoder, where the unit's rates are means of so many samples."""
    rng = np.random.default_rng(6)
    manifest = Manifest.model_validate({
        "format": "mimu-recording/1", "recording_id": "shaft",
        "unit": {"manufacturer": "", "model": "", "serial": ""},
        "station": {
            "id": "s", "gravity_m_s2": 9.8, "table_axes": [{"name": "a", "direction": [0, 0, 1]}],
        },
    })  # fmt: skip
    gyro = 1e-4 * rng.standard_normal((3, len(T)))
    gyro[2] += uniform_filter1d(np.gradient(ANGLE, T), own_samples)
    accel = 1e-3 * rng.standard_normal((3, len(T))) + np.array([[0.0], [0.0], [9.8]])
    imu = Stream(T, dict(zip(GYRO + ACCEL, [*gyro, *accel], strict=True)))
    read = ANGLE + encoder_noise * rng.standard_normal(len(T))
    recording = Recording(manifest, imu, table=Stream(T, {"a_angle": read}))
    full = full_rate(recording)
    standard: Any = Smoothed(1)
    found: Any = Smoothed(max(own_samples, 9))
    left = LeftOver.of(
        full, standard.prediction(full.motion), found.prediction(full.motion),
        np.zeros((len(T), 6), bool),
    )  # fmt: skip
    return fitted_to_reference_noise(recording, full, standard, found, KEYS, left)


def test_what_only_quietens_the_encoder_is_no_finding() -> None:
    assert findings(encoder_noise=5e-4, own_samples=1) == {0}


@pytest.mark.parametrize("encoder_noise", [0.0, 1e-5])
def test_a_low_pass_of_the_unit_stands(encoder_noise: float) -> None:
    assert findings(encoder_noise, own_samples=41) == set()
