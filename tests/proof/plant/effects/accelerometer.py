"""Accelerometers: what the sensing element does beyond a straight line."""

from typing import ClassVar

import numpy as np

from tests.proof.plant.case import generator
from tests.proof.plant.effects.base import Effect, Parameters
from tests.proof.plant.effects.gyro import STANDARD_G, signs
from tests.proof.plant.world import Setting, World, on_accelerometers


class AccelNonlinearity(Effect):
    """Reads k · f^order / g^(order−1) more, order 2 or 3, f along the accelerometer's own axis."""

    name = "accel_nonlinearity"
    units: ClassVar = {"coefficient": "1", "order": "1"}
    sized = ("coefficient",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"coefficient": (5e-4 * signs(rng)).tolist(), "order": int(rng.integers(2, 4))}

    def sense(self, world: World) -> np.ndarray:
        order = self.parameters["order"]
        bent = world.sensed_force() ** order / STANDARD_G ** (order - 1)
        return on_accelerometers(self.column("coefficient") * bent)


class AccelSaturation(Effect):
    """The accelerometers' outputs stop at ± limit, noise included.

    The limit lies 0.2 % above the unit's largest reading at strength 0, as much below it at 1.
    """

    name = "accel_saturation"
    units: ClassVar = {"limit": "m/s^2"}
    sized = ("limit",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        unit = setting.unit
        largest = np.diag(unit.Ka) * setting.case.gravity_m_s2 + np.abs(unit.Ba)
        return {"limit": 1.002 * float(largest.max())}

    @classmethod
    def at(cls, typical: Parameters, strength: float) -> Parameters:
        return {"limit": float(typical["limit"]) * (1.0 - min(0.004 * strength, 0.9))}

    def limits(self) -> np.ndarray:
        return np.repeat([np.inf, self.parameters["limit"]], 3)


class VibrationRectification(Effect):
    """The table shakes the more the faster it turns, and the accelerometers rectify it.

    Vibration of each axis: rms · (rate / top rate)^exponent, above the unit's band; bias is
    coefficient · its mean square. A share of it folds into the band as noise that grows with
    rate; that noise is no part of the truth. Strength sizes the coefficient alone.
    """

    name = "vibration_rectification"
    units: ClassVar = {
        "coefficient": "(m/s^2)/(m/s^2)^2",
        "rms": "m/s^2",
        "exponent": "1",
        "share": "1",
    }
    sized = ("coefficient",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "coefficient": (5e-3 * signs(rng)).tolist(),
            "rms": 1.0,
            "exponent": float(rng.uniform(0.7, 1.6)),
            "share": 0.015,
        }

    def _rms(self, world: World) -> np.ndarray:
        speed = np.sqrt((world.motion.rates**2).sum(axis=0)) / self.setting.top_rate
        return np.asarray(self.parameters["rms"] * speed ** self.parameters["exponent"])

    def sense(self, world: World) -> np.ndarray:
        return on_accelerometers(self.column("coefficient") * self._rms(world) ** 2)

    def shake(self, world: World) -> np.ndarray:
        rng = generator(self.setting.case.seed, "vibration")
        noise = rng.standard_normal((3, len(world.t)))
        return on_accelerometers(self.parameters["share"] * self._rms(world) * noise)
