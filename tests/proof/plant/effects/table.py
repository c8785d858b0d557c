"""The table: where the shaft is, and what the encoder says."""

from typing import ClassVar

import numpy as np

from tests.proof.plant.effects.base import Effect, Parameters
from tests.proof.plant.world import Setting


class RateRipple(Effect):
    """The payload's rate varies N times a turn and the table's stream does not show it.

    Cogging winds up the shaft between the motor, whose encoder the servo holds smooth, and the
    payload: shaft = motor + depth / N · sin(N · motor + phase), so the rate varies by ± depth.
    """

    name = "rate_ripple"
    units: ClassVar = {"depth": "1", "per_turn": "1", "phase": "rad"}
    sized = ("depth",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        per_turn = int(rng.choice([3, 4, 6, 8, 12, 16]))
        return {"depth": 1e-4, "per_turn": per_turn, "phase": float(rng.uniform(0, 2 * np.pi))}

    def shaft(self, motor: np.ndarray) -> np.ndarray:
        number, phase = self.parameters["per_turn"], self.parameters["phase"]
        moved = motor.copy()
        # counted from the index mark, where the axis stands at the start
        wave = np.sin(number * motor[0] + phase) - np.sin(phase)
        moved[0] += self.parameters["depth"] / number * wave
        return moved


class EncoderEccentricity(Effect):
    """The first axis's disc sits off centre: its encoder errs once a turn, the shaft is right.

    Reported = true + amplitude · (sin(true + phase) − sin(phase)), zero at the index mark; the
    reported rate follows. The drive does not run on this encoder: the error shows in the table's
    stream, not in the unit.
    """

    name = "encoder_eccentricity"
    units: ClassVar = {"amplitude": "rad", "phase": "rad"}
    sized = ("amplitude",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"amplitude": 1e-4, "phase": float(rng.uniform(0, 2 * np.pi))}

    def encoder(self, motor: np.ndarray) -> np.ndarray:
        read = motor.copy()
        phase = self.parameters["phase"]
        wave = np.sin(motor[0] + phase) - np.sin(phase)
        read[0] += self.parameters["amplitude"] * wave
        return read


class TableScale(Effect):
    """Every encoder says more than was turned, by a share; the servo holds what it says.

    The stream therefore shows round angles and rates, and the shaft turned less:
    reported = (1 + scale) · shaft.
    """

    name = "table_scale"
    units: ClassVar = {"scale": "1"}
    sized = ("scale",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"scale": float(6e-5 * rng.choice([-1.0, 1.0]))}

    def shaft(self, motor: np.ndarray) -> np.ndarray:
        return np.asarray(motor / (1.0 + self.parameters["scale"]))
