"""Sensors in other forms than the plain plant's: rectification, non-linearity, thermal lag."""

from typing import ClassVar

import numpy as np

from tests.proof.plant.effects.accelerometer import VibrationRectification
from tests.proof.plant.effects.base import Effect, Parameters, unit_vector
from tests.proof.plant.effects.environment import both
from tests.proof.plant.effects.gyro import STANDARD_G, signs
from tests.proof.plant.effects.outside_motion import lagged
from tests.proof.plant.weather import REFERENCE
from tests.proof.plant.world import Setting, World, on_accelerometers, on_gyros


class RectificationBySpeed(VibrationRectification):
    """Vibration power follows the speed: so does the rectified bias."""

    form = "vibration_rectification_speed"
    EXPONENT: ClassVar = 0.5  # of the vibration's rms

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return super().draw(rng, setting) | {"exponent": cls.EXPONENT, "share": 0.01}


class RectificationBySquare(RectificationBySpeed):
    """Vibration power follows the square of the speed."""

    form = "vibration_rectification_square"
    EXPONENT: ClassVar = 1.0


class GyroQuadraticOdd(Effect):
    """The scale factor grows with the magnitude of the rate: reads c · ω·|ω| / ω_top."""

    name, form = "gyro_scale_nonlinearity", "gyro_scale_nonlinearity_odd_square"
    units: ClassVar = {"coefficient": "1", "top_rate": "rad/s"}
    sized = ("coefficient",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"coefficient": (1e-3 * signs(rng)).tolist(), "top_rate": setting.top_rate}

    def sense(self, world: World) -> np.ndarray:
        rate = world.sensed_rates()
        bent = rate * np.abs(rate) / self.parameters["top_rate"]
        return on_gyros(self.column("coefficient") * bent)


class GyroSoftLimit(GyroQuadraticOdd):
    """The output bends off softly: reads ω_top·(tanh(k·x)/k − x) more, x = ω/ω_top, k² = 3c."""

    form = "gyro_scale_nonlinearity_soft"

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        drawn = super().draw(rng, setting)
        return drawn | {"coefficient": np.abs(drawn["coefficient"]).tolist()}

    def sense(self, world: World) -> np.ndarray:
        top = self.parameters["top_rate"]
        share, k = world.sensed_rates() / top, np.sqrt(3.0 * self.column("coefficient")) + 1e-9
        return on_gyros(top * (np.tanh(k * share) / k - share))


class AccelOddSquare(Effect):
    """The scale factor differs with the magnitude: reads c · f·|f| / g."""

    name, form = "accel_nonlinearity", "accel_nonlinearity_odd_square"
    units: ClassVar = {"coefficient": "1"}
    sized = ("coefficient",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"coefficient": (2e-3 * signs(rng)).tolist()}

    def sense(self, world: World) -> np.ndarray:
        force = world.sensed_force()
        return on_accelerometers(self.column("coefficient") * force * np.abs(force) / STANDARD_G)


class AccelSines(AccelOddSquare):
    """An integral non-linearity of the converter: reads c·g · sin(2π f / g)."""

    form = "accel_nonlinearity_sine"

    def sense(self, world: World) -> np.ndarray:
        wave = np.sin(2.0 * np.pi * world.sensed_force() / STANDARD_G)
        return on_accelerometers(self.column("coefficient") * STANDARD_G * wave)


class LateTemperature(Effect):
    """Biases follow a temperature that lags behind the thermometer's by `tau`."""

    name, form = "temperature_bias", "temperature_bias_late"
    units: ClassVar = {"gyro": "(rad/s)/K", "accel": "(m/s^2)/K", "tau": "s"}
    sized = ("gyro", "accel")

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "gyro": (4e-4 * unit_vector(rng)).tolist(),
            "accel": (5e-3 * unit_vector(rng)).tolist(),
            "tau": float(rng.uniform(20.0, 120.0)),
        }

    def sense(self, world: World) -> np.ndarray:
        warmer = world.weather.temperature - REFERENCE
        late = warmer[0] + lagged(warmer - warmer[0], world.motion.step / self.parameters["tau"])
        return both(self.column("gyro"), self.column("accel"), late)
