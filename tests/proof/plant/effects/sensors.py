"""Gyros and accelerometers: what the sensing elements do beyond a straight line."""

from typing import ClassVar

import numpy as np

from tests.proof.plant.case import generator
from tests.proof.plant.effects.base import Effect, Parameters
from tests.proof.plant.world import Setting, World, on_accelerometers, on_gyros

STANDARD_G = 9.80665  # m/s²


def signs(rng: np.random.Generator) -> np.ndarray:
    """Three factors of either sign between a half and one and a half."""
    return np.asarray(rng.choice([-1.0, 1.0], 3) * rng.uniform(0.5, 1.5, 3))


class GyroScaleNonlinearity(Effect):
    """The scale factor depends on the rate: reads c · ω² / ω_top (even) or c · ω³ / ω_top² (odd).

    ω is what the element answers to, ω_top the run's largest rate; order 2 is even, 3 is odd.
    """

    name = "gyro_scale_nonlinearity"
    units: ClassVar = {"coefficient": "1", "order": "1", "top_rate": "rad/s"}
    sized = ("coefficient",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "coefficient": (1e-4 * signs(rng)).tolist(),
            "order": int(rng.integers(2, 4)),
            "top_rate": setting.top_rate,
        }

    def sense(self, world: World) -> np.ndarray:
        top, order = self.parameters["top_rate"], self.parameters["order"]
        return on_gyros(
            self.column("coefficient") * world.sensed_rates() ** order / top ** (order - 1)
        )


class GyroScaleAsymmetry(Effect):
    """The scale factor differs by sign: reads a · |ω| more, (K₊ − K₋) / 2 = a."""

    name = "gyro_scale_asymmetry"
    units: ClassVar = {"half_difference": "1"}
    sized = ("half_difference",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"half_difference": (5e-5 * signs(rng)).tolist()}

    def sense(self, world: World) -> np.ndarray:
        return on_gyros(self.column("half_difference") * np.abs(world.sensed_rates()))


class GyroSaturation(Effect):
    """The gyros' outputs stop at ± limit, noise included.

    The limit lies 0.1 % above the unit's largest reading at strength 0, as much below it at 1.
    """

    name = "gyro_saturation"
    units: ClassVar = {"limit": "rad/s"}
    sized = ("limit",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        unit = setting.unit
        largest = np.diag(unit.Kg) * setting.top_rate + np.abs(unit.Bg)
        return {"limit": 1.001 * float(largest.max())}

    @classmethod
    def at(cls, typical: Parameters, strength: float) -> Parameters:
        return {"limit": float(typical["limit"]) * (1.0 - min(0.002 * strength, 0.9))}

    def limits(self) -> np.ndarray:
        return np.repeat([self.parameters["limit"], np.inf], 3)


class GyroG2Sensitivity(Effect):
    """Bias follows acceleration squared: reads M · (f_x², f_y², f_z²)."""

    name = "gyro_g2_sensitivity"
    units: ClassVar = {"M": "(rad/s)/(m/s^2)^2"}
    sized = ("M",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"M": (1.5e-4 / STANDARD_G**2 * rng.standard_normal((3, 3))).tolist()}

    def sense(self, world: World) -> np.ndarray:
        return on_gyros(self.value("M") @ world.motion.force**2)


class GyroScaleGDependence(Effect):
    """The scale factor depends on acceleration: reads ω_i · Σ_j S_ij f_j.

    While the axis that turns stands upright, f along it is constant and the scale factor absorbs
    the effect; only moves about level axes, or rates in both orientations, show it.
    """

    name = "gyro_scale_g_dependence"
    units: ClassVar = {"S": "1/(m/s^2)"}
    sized = ("S",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"S": (2e-4 / STANDARD_G * rng.standard_normal((3, 3))).tolist()}

    def sense(self, world: World) -> np.ndarray:
        return on_gyros(world.sensed_rates() * (self.value("S") @ world.motion.force))


class GyroAngularAcceleration(Effect):
    """The output follows angular acceleration: reads A · dω/dt (A in s, any direction)."""

    name = "gyro_angular_acceleration"
    units: ClassVar = {"A": "s"}
    sized = ("A",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"A": (1e-4 * rng.standard_normal((3, 3))).tolist()}

    def sense(self, world: World) -> np.ndarray:
        return on_gyros(self.value("A") @ world.motion.angular_acceleration())


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
