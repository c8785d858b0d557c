"""Outside the catalogue: what sensors, wiring and room do that the catalogue does not list."""

from typing import ClassVar

import numpy as np

from tests.proof.plant.effects.base import Effect, Parameters, unit_vector
from tests.proof.plant.effects.environment import both
from tests.proof.plant.effects.gyro import STANDARD_G
from tests.proof.plant.effects.outside_motion import lagged
from tests.proof.plant.world import Setting, World, on_accelerometers, on_gyros


class HumidityDrift(Effect):
    """Biases follow the room's humidity, counted from 45 %RH."""

    name = "x_humidity_drift"
    units: ClassVar = {"gyro": "(rad/s)/%RH", "accel": "(m/s^2)/%RH"}
    sized = ("gyro", "accel")

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "gyro": (3e-5 * unit_vector(rng)).tolist(),
            "accel": (3e-4 * unit_vector(rng)).tolist(),
        }

    def sense(self, world: World) -> np.ndarray:
        return both(self.column("gyro"), self.column("accel"), world.weather.humidity - 45.0)


class PressureSensitivity(Effect):
    """Biases follow the air pressure, counted from 1013 hPa."""

    name = "x_pressure_sensitivity"
    units: ClassVar = {"gyro": "(rad/s)/hPa", "accel": "(m/s^2)/hPa"}
    sized = ("gyro", "accel")

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "gyro": (4e-4 * unit_vector(rng)).tolist(),
            "accel": (4e-3 * unit_vector(rng)).tolist(),
        }

    def sense(self, world: World) -> np.ndarray:
        return both(self.column("gyro"), self.column("accel"), world.weather.pressure - 1013.0)


class RateProduct(Effect):
    """Gyros: reads the product of the rates about the two other axes (ω_y·ω_z in x, …).

    Shows only where the unit turns about two of its axes at once.
    """

    name = "x_rate_product"
    units: ClassVar = {"c": "s"}
    sized = ("c",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"c": (3e-4 * rng.choice([-1.0, 1.0], 3)).tolist()}

    def sense(self, world: World) -> np.ndarray:
        x, y, z = world.motion.rates
        return on_gyros(self.column("c") * np.stack([y * z, z * x, x * y]))


class AccelCrossQuadratic(Effect):
    """Accelerometers: reads the product of the specific forces on the two other axes, over g."""

    name = "x_accel_cross_quadratic"
    units: ClassVar = {"c": "1"}
    sized = ("c",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"c": (1e-3 * rng.choice([-1.0, 1.0], 3)).tolist()}

    def sense(self, world: World) -> np.ndarray:
        x, y, z = world.motion.force
        products = np.stack([y * z, z * x, x * y]) / STANDARD_G
        return on_accelerometers(self.column("c") * products)


class BeatLine(Effect):
    """A line at a frequency that has nothing to do with the mains: a pump, a fan, a beat."""

    name = "x_beat_line"
    units: ClassVar = {"gyro": "rad/s", "accel": "m/s^2", "phases": "rad", "frequency": "Hz"}
    sized = ("gyro", "accel")

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "gyro": (1.5e-4 * unit_vector(rng)).tolist(),
            "accel": (1.2e-3 * unit_vector(rng)).tolist(),
            "phases": rng.uniform(0.0, 2.0 * np.pi, 6).tolist(),
            "frequency": float(rng.uniform(2.0, 20.0)),
        }

    def pick_up(self, t: np.ndarray) -> np.ndarray:
        turns = 2.0 * np.pi * self.parameters["frequency"] * t
        wave = np.sin(turns + self.value("phases")[:, None])
        return np.concatenate([self.value("gyro"), self.value("accel")])[:, None] * wave


class ChargeBuildUp(Effect):
    """Accelerometers: charge gathers while the axis points up and leaks otherwise, with τ."""

    name = "x_charge_build_up"
    units: ClassVar = {"accel": "m/s^2", "tau": "s"}
    sized = ("accel",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"accel": (1e-2 * unit_vector(rng)).tolist(), "tau": float(rng.uniform(80, 200))}

    def sense(self, world: World) -> np.ndarray:
        pace = world.motion.step / self.parameters["tau"]
        up = (world.motion.force > STANDARD_G / 2.0).astype(float)
        return on_accelerometers(self.column("accel") * np.stack([lagged(one, pace) for one in up]))


class Telegraph(Effect):
    """One gyro's and one accelerometer's bias jump between two levels at random times.

    The levels' difference and the times are parameters: the path is part of the truth.
    """

    name = "x_telegraph"
    units: ClassVar = {"gyro": "rad/s", "accel": "m/s^2", "times": "s"}
    sized = ("gyro", "accel")

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        times = np.cumsum(rng.exponential(45.0, 400))
        axes = np.eye(3)
        return {
            "gyro": (1.5e-4 * axes[rng.integers(3)]).tolist(),
            "accel": (1.5e-3 * axes[rng.integers(3)]).tolist(),
            "times": times[times < setting.plan.duration].tolist(),
        }

    def sense(self, world: World) -> np.ndarray:
        level = np.searchsorted(self.value("times"), world.t) % 2 - 0.5
        return both(self.column("gyro"), self.column("accel"), level)


class TwoMovesAgo(Effect):
    """Accelerometers: reads a share of the specific force of the rest before the last one.

    The memory of a rest is the force in the middle of it; turning does not count as a rest.
    """

    name = "x_two_moves_ago"
    units: ClassVar = {"share": "1"}
    sized = ("share",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"share": (1.5e-4 * rng.choice([-1.0, 1.0], 3)).tolist()}

    def sense(self, world: World) -> np.ndarray:
        plan = self.setting.plan
        rests = [n for n, segment in enumerate(plan.segments) if segment.kind == "static"]
        middle = (plan.bounds[rests] + plan.bounds[np.array(rests) + 1]) / 2.0
        felt = world.motion.force[:, np.searchsorted(world.t, middle)]
        felt = np.concatenate([np.zeros((3, 2)), felt], axis=1)
        begun = np.searchsorted(plan.bounds[rests], world.t, side="right")
        # at rest number n (from one) the rest two before it; column n − 2, shifted by the zeros
        return on_accelerometers(self.column("share") * felt[:, np.maximum(begun - 1, 0)])


class AirConditioning(Effect):
    """Gyros: a bias that comes and goes with a cycle of minutes that nothing records."""

    name = "x_air_conditioning"
    units: ClassVar = {"gyro": "rad/s", "period": "s", "phase": "rad"}
    sized = ("gyro",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "gyro": (1.5e-4 * unit_vector(rng)).tolist(),
            "period": float(rng.uniform(70.0, 200.0)),
            "phase": float(rng.uniform(0.0, 2.0 * np.pi)),
        }

    def sense(self, world: World) -> np.ndarray:
        turns = 2.0 * np.pi * world.t / self.parameters["period"]
        return on_gyros(self.column("gyro") * np.sin(turns + self.parameters["phase"]))


class BurstNoise(Effect):
    """Gyros: short bursts of a damped swing at random times, as a loose contact makes."""

    name = "x_bursts"
    units: ClassVar = {"gyro": "rad/s", "times": "s", "decay": "s", "frequency": "Hz"}
    sized = ("gyro",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        times = np.sort(rng.uniform(0.05, 0.95, 12)) * setting.plan.duration
        return {
            "gyro": (2e-3 * unit_vector(rng)).tolist(),
            "times": times.tolist(),
            "decay": 1.5,
            "frequency": float(rng.uniform(0.5, 3.0)),
        }

    def sense(self, world: World) -> np.ndarray:
        wave = np.zeros(len(world.t))
        for time in self.parameters["times"]:
            since = np.maximum(world.t - time, 0.0)
            swing = np.sin(2.0 * np.pi * self.parameters["frequency"] * since)
            wave += swing * np.exp(-since / self.parameters["decay"])
        return on_gyros(self.column("gyro") * wave)
