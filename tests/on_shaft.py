"""A run on a shaft with one encoder."""

import numpy as np
from scipy.signal import lfilter

from schemas.recording import ACCEL, GYRO, Manifest, Recording, Stream
from tests.manifests import manifest_of

T = np.arange(0.0, 60.0, 0.01)
ANGLE = 0.3 * np.sin(2.0 * np.pi * 0.25 * T) ** 3 * (T > 20.0)


def shaft_manifest(*direction: float) -> Manifest:
    """Of a shaft along a direction; its encoder is `a`."""
    return manifest_of("shaft", {"gravity_m_s2": 9.8}, {"a": direction})


def swinging(encoder_noise: float, low_pass: float = np.inf) -> Recording:
    """At rest, then to and fro. The encoder errs by so many rad; rates pass a filter of so many
    Hz.
    """
    rng = np.random.default_rng(6)
    gyro = 1e-4 * rng.standard_normal((3, len(T)))
    kept = np.exp(-2.0 * np.pi * low_pass * (T[1] - T[0]))
    gyro[2] += lfilter([1.0 - kept], [1.0, -kept], np.gradient(ANGLE, T))
    accel = 1e-3 * rng.standard_normal((3, len(T))) + np.array([[0.0], [0.0], [9.8]])
    imu = Stream(T, dict(zip(GYRO + ACCEL, [*gyro, *accel], strict=True)))
    read = ANGLE + encoder_noise * rng.standard_normal(len(T))
    return Recording(shaft_manifest(0, 0, 1), imu, table=Stream(T, {"a_angle": read}))
