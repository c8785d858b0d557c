"""Environment: temperature, its change, the supply, the Earth's magnetic field."""

from typing import ClassVar

import numpy as np

from tests.proof.plant.effects.base import Effect, Following, Parameters, unit_vector
from tests.proof.plant.world import REFERENCE, Setting, World, on_accelerometers, on_gyros

DIPOLE = 31.2e-6  # T, of the Earth's field at the magnetic equator


def both(gyro: np.ndarray, accel: np.ndarray, follows: np.ndarray) -> np.ndarray:
    """Six channels that follow one course of time, each with its own coefficient (3, 1)."""
    return on_gyros(gyro * follows) + on_accelerometers(accel * follows)


class TemperatureBias(Following):
    """Biases follow the unit's own temperature, counted from 25 °C."""

    name = "temperature_bias"
    units: ClassVar = {"gyro": "(rad/s)/K", "accel": "(m/s^2)/K"}
    sized = ("gyro", "accel")
    typical: ClassVar = {"gyro": 1.2e-4, "accel": 1.5e-3}

    def course(self, world: World) -> np.ndarray:
        return world.weather.temperature - REFERENCE


class TemperatureScale(Effect):
    """Scale factors follow the unit's own temperature, counted from 25 °C."""

    name = "temperature_scale"
    units: ClassVar = {"gyro": "1/K", "accel": "1/K"}
    sized = ("gyro", "accel")

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "gyro": (1e-4 * unit_vector(rng)).tolist(),
            "accel": (1e-4 * unit_vector(rng)).tolist(),
        }

    def sense(self, world: World) -> np.ndarray:
        warmer = world.weather.temperature - REFERENCE
        gyro = self.column("gyro") * world.sensed_rates() * warmer
        return np.concatenate([gyro, self.column("accel") * world.sensed_force() * warmer])


class ThermalTransient(Following):
    """Biases settle after power-on, e^(−t/τ), in another time than the temperature sensor's."""

    name = "thermal_transient"
    units: ClassVar = {"gyro": "rad/s", "accel": "m/s^2", "tau": "s"}
    sized = ("gyro", "accel")
    typical: ClassVar = {"gyro": 1e-3, "accel": 1e-2}

    @classmethod
    def beside(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"tau": float(rng.uniform(60.0, 180.0))}

    def course(self, world: World) -> np.ndarray:
        return np.asarray(np.exp(-np.maximum(world.t, 0.0) / self.parameters["tau"]))


class ThermalGradient(Following):
    """Biases follow the rate at which the unit's temperature changes (heat flows through it)."""

    name = "thermal_gradient"
    units: ClassVar = {"gyro": "(rad/s)/(K/s)", "accel": "(m/s^2)/(K/s)"}
    sized = ("gyro", "accel")
    typical: ClassVar = {"gyro": 4e-2, "accel": 4e-1}

    def course(self, world: World) -> np.ndarray:
        return world.weather.temperature_rate


class SupplySensitivity(Following):
    """Biases follow the supply voltage, counted from 5 V."""

    name = "supply_sensitivity"
    units: ClassVar = {"gyro": "(rad/s)/V", "accel": "(m/s^2)/V"}
    sized = ("gyro", "accel")
    typical: ClassVar = {"gyro": 6e-3, "accel": 6e-2}

    def course(self, world: World) -> np.ndarray:
        return world.weather.supply - 5.0


class MagneticSensitivity(Effect):
    """Gyro biases follow the Earth's field along the unit's axes: reads M · B.

    The field is the dipole's at the station's latitude, with a declination. What stands upright
    looks like gravity; the level part tells.
    """

    name = "magnetic_sensitivity"
    units: ClassVar = {"M": "(rad/s)/T", "field": "T"}
    sized = ("M",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        latitude = np.radians(setting.case.latitude_deg)
        level, down = DIPOLE * np.cos(latitude), 2.0 * DIPOLE * np.sin(latitude)
        east = np.radians(rng.uniform(-10.0, 10.0))
        field = [float(level * np.sin(east)), float(level * np.cos(east)), float(-down)]
        return {"M": (1.5 * rng.standard_normal((3, 3))).tolist(), "field": field}

    def sense(self, world: World) -> np.ndarray:
        return on_gyros(self.value("M") @ world.motion.into_unit(self.value("field")))
