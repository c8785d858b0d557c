"""Electronics: the analogue path, the converter's step, the mains."""

from typing import ClassVar

import numpy as np

from tests.proof.plant.effects.base import Effect, Parameters, unit_vector
from tests.proof.plant.world import Setting


class Bandwidth(Effect):
    """The unit's low-pass: second order, Butterworth, on all channels; 60 Hz at strength 1.

    The corner falls as strength grows. Noise is given at the output and does not pass it.
    """

    name = "bandwidth"
    units: ClassVar = {"corner": "Hz", "order": "1"}
    sized = ("corner",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"corner": 60.0, "order": 2}

    @classmethod
    def at(cls, typical: Parameters, strength: float) -> Parameters:
        return typical | {"corner": float(typical["corner"]) / max(strength, 1e-9)}

    def response(self, frequency: np.ndarray) -> np.ndarray:
        order = int(self.parameters["order"])
        s = 1j * frequency / self.parameters["corner"]
        poles = np.exp(1j * np.pi * (2.0 * np.arange(order) + order + 1.0) / (2.0 * order))
        passed = np.ones(len(frequency), dtype=complex)
        for pole in poles:
            passed /= 1.0 - s / pole
        return passed


class CoarseQuantisation(Effect):
    """The converter has lost its lower bits: the step stands above the noise.

    Steps of gyros and accelerometers; at strength 1 about three times the industrial grade's
    noise at 100 Hz. The truth is the mean reading that noise and step give together.
    """

    name = "coarse_quantisation"
    units: ClassVar = {"gyro": "rad/s", "accel": "m/s^2"}
    sized = ("gyro", "accel")

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"gyro": 2e-3, "accel": 2e-2}

    def step(self, steps: np.ndarray) -> np.ndarray:
        coarse = np.repeat([self.parameters["gyro"], self.parameters["accel"]], 3)
        return np.maximum(steps, coarse)


class MainsPickup(Effect):
    """The mains and a weaker third harmonic in the wiring, folded down by sampling.

    The mains frequency is near 50 Hz, not at it. One amplitude and phase for each channel.
    """

    name = "mains_pickup"
    units: ClassVar = {
        "gyro": "rad/s",
        "accel": "m/s^2",
        "phases": "rad",
        "frequency": "Hz",
        "third": "1",
    }
    sized = ("gyro", "accel")

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "gyro": (2e-4 * unit_vector(rng)).tolist(),
            "accel": (1.5e-3 * unit_vector(rng)).tolist(),
            "phases": rng.uniform(0.0, 2.0 * np.pi, 6).tolist(),
            "frequency": float(50.0 + rng.choice([-1.0, 1.0]) * rng.uniform(0.01, 0.08)),
            "third": 0.3,
        }

    def pick_up(self, t: np.ndarray) -> np.ndarray:
        turns = 2.0 * np.pi * self.parameters["frequency"] * t
        wave = np.sin(turns + self.value("phases")[:, None])
        wave += self.parameters["third"] * np.sin(3.0 * (turns + self.value("phases")[:, None]))
        return np.concatenate([self.value("gyro"), self.value("accel")])[:, None] * wave
