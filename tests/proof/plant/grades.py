"""Noise of the three grades of unit, and the step of their outputs."""

from dataclasses import dataclass

import numpy as np

from tests.proof.plant.case import Grade

DEGREE = float(np.pi / 180.0)
G = 9.80665


@dataclass(frozen=True)
class Noise:
    """White and flicker noise of one triad: one-sided density S(f) = white² + instability²/(2πf).

    white: rad/s/√Hz or m/s²/√Hz. instability: B in rad/s or m/s². step: of the output.
    """

    white: float
    instability: float
    step: float

    def density(self, frequency: np.ndarray) -> np.ndarray:
        """S(f) for f > 0 in Hz."""
        return self.white**2 + self.instability**2 / (2.0 * np.pi * frequency)


GYRO: dict[Grade, Noise] = {
    "consumer": Noise(0.012 * DEGREE, 25.0 * DEGREE / 3600.0, 0.0076 * DEGREE),
    "industrial": Noise(0.006 * DEGREE, 6.0 * DEGREE / 3600.0, 0.001 * DEGREE),
    "tactical": Noise(0.002 * DEGREE, 1.0 * DEGREE / 3600.0, 0.00002 * DEGREE),
}
ACCEL: dict[Grade, Noise] = {
    "consumer": Noise(150e-6 * G, 100e-6 * G, 600e-6 * G),
    "industrial": Noise(80e-6 * G, 40e-6 * G, 100e-6 * G),
    "tactical": Noise(30e-6 * G, 10e-6 * G, 20e-6 * G),
}


def channel_noise(grade: Grade) -> tuple[Noise, ...]:
    """The six channels, gyros first."""
    return (GYRO[grade],) * 3 + (ACCEL[grade],) * 3
