"""Outside the catalogue: what table, sensors, wiring and room do that it does not list."""

from typing import ClassVar

import numpy as np
from scipy.signal import lfilter

from tests.proof.plant.case import from_vector
from tests.proof.plant.effects.base import (
    Effect,
    Following,
    Link,
    Parameters,
    insert_after,
    unit_vector,
)
from tests.proof.plant.effects.environment import both
from tests.proof.plant.effects.sensors import STANDARD_G
from tests.proof.plant.world import Setting, World, on_accelerometers, on_gyros


def since_last(t: np.ndarray, events: np.ndarray) -> np.ndarray:
    """Time in s since the last of the rising events; infinite before the first."""
    number = np.searchsorted(events, t, side="right") - 1
    return np.where(number >= 0, t - events[np.maximum(number, 0)], np.inf)


class StressRelaxation(Following):
    """Accelerometers: after each move to another position a strain relaxes, e^(−t/τ)."""

    name = "x_stress_relaxation"
    units: ClassVar = {"accel": "m/s^2", "tau": "s"}
    sized = ("accel",)
    typical: ClassVar = {"accel": 3e-3}

    @classmethod
    def beside(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"tau": float(rng.uniform(5.0, 12.0))}

    def course(self, world: World) -> np.ndarray:
        since = since_last(world.t, self.setting.plan.ends_of_moves())
        return np.asarray(np.exp(-since / self.parameters["tau"]))


class CableDrag(Effect):
    """The cable pulls the fixture askew where it comes taut, at one angle of the first axis."""

    name = "x_cable_drag"
    units: ClassVar = {"vector": "rad", "angle": "rad", "width": "rad"}
    sized = ("vector",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "vector": (1e-4 * unit_vector(rng)).tolist(),
            "angle": float(rng.uniform(0.0, 2.0 * np.pi)),
            "width": float(rng.uniform(0.25, 0.5)),
        }

    def links(self, chain: list[Link], t: np.ndarray, shaft: np.ndarray) -> list[Link]:
        away = shaft[0] - self.parameters["angle"]
        taut = np.exp((np.cos(away) - 1.0) / self.parameters["width"] ** 2)
        payload = self.setting.plan.table.names[-1]
        pull = self.column("vector") * taut
        return insert_after(chain, payload, ("cable", from_vector(pull)))


class BearingClicks(Following):
    """Accelerometers: a damaged ball rings the table at a number of times a turn that is not whole.

    Each click is a decaying ring of 10 ms along one direction, the same at any speed.
    """

    name = "x_bearing_clicks"
    units: ClassVar = {"accel": "m/s^2", "per_turn": "1", "ring": "Hz", "decay": "s"}
    sized = ("accel",)
    typical: ClassVar = {"accel": 0.02}

    @classmethod
    def beside(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "per_turn": float(rng.uniform(3.2, 7.8)),
            "ring": float(rng.uniform(18.0, 35.0)),
            "decay": 0.01,
        }

    def course(self, world: World) -> np.ndarray:
        count = np.floor(world.motion.shaft[0] * self.parameters["per_turn"] / (2.0 * np.pi))
        clicks = world.t[1:][np.diff(count) != 0.0]
        since = np.minimum(since_last(world.t, clicks), 1e3)
        ring = np.sin(2.0 * np.pi * self.parameters["ring"] * since)
        return np.asarray(ring * np.exp(-since / self.parameters["decay"]))


class ThirdHarmonic(Following):
    """Gyros: a bias that goes round three times a turn of the first axis, whatever the rate."""

    name = "x_third_harmonic"
    units: ClassVar = {"gyro": "rad/s", "phase": "rad"}
    sized = ("gyro",)
    typical: ClassVar = {"gyro": 1e-4}

    @classmethod
    def beside(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"phase": float(rng.uniform(0, 2 * np.pi))}

    def course(self, world: World) -> np.ndarray:
        return np.asarray(np.cos(3.0 * world.motion.shaft[0] + self.parameters["phase"]))


class RateHeating(Following):
    """Biases follow a heat that turning makes: τ · dh/dt = (ω/ω_top)² − h; no sensor sees it."""

    name = "x_rate_heating"
    units: ClassVar = {"gyro": "rad/s", "accel": "m/s^2", "tau": "s", "top_rate": "rad/s"}
    sized = ("gyro", "accel")
    typical: ClassVar = {"gyro": 3e-4, "accel": 3e-3}

    @classmethod
    def beside(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"tau": float(rng.uniform(25.0, 60.0)), "top_rate": setting.top_rate}

    def course(self, world: World) -> np.ndarray:
        load = (world.motion.rates**2).sum(axis=0) / self.parameters["top_rate"] ** 2
        return lagged(load, world.motion.step / self.parameters["tau"])


class Afterglow(Effect):
    """Gyros: a bias grows towards a share of the rate while turning and fades after it, e^(−t/τ).

    What it adds while the rate is held, the scale factor absorbs.
    """

    name = "x_afterglow"
    units: ClassVar = {"share": "1", "tau": "s"}
    sized = ("share",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "share": (1e-4 * rng.choice([-1.0, 1.0], 3)).tolist(),
            "tau": float(rng.uniform(4, 9)),
        }

    def sense(self, world: World) -> np.ndarray:
        pace = world.motion.step / self.parameters["tau"]
        trail = np.stack([lagged(rate, pace) for rate in world.motion.rates])
        return on_gyros(self.column("share") * trail)


def lagged(follows: np.ndarray, pace: float) -> np.ndarray:
    """First-order lag of a course, starting from zero; `pace` is step / τ."""
    keep = np.exp(-pace)
    return np.asarray(lfilter([1.0 - keep], [1.0, -keep], follows))


class HumidityDrift(Following):
    """Biases follow the room's humidity, counted from 45 %RH."""

    name = "x_humidity_drift"
    units: ClassVar = {"gyro": "(rad/s)/%RH", "accel": "(m/s^2)/%RH"}
    sized = ("gyro", "accel")
    typical: ClassVar = {"gyro": 3e-5, "accel": 3e-4}

    def course(self, world: World) -> np.ndarray:
        return world.weather.humidity - 45.0


class PressureSensitivity(Following):
    """Biases follow the air pressure, counted from 1013 hPa."""

    name = "x_pressure_sensitivity"
    units: ClassVar = {"gyro": "(rad/s)/hPa", "accel": "(m/s^2)/hPa"}
    sized = ("gyro", "accel")
    typical: ClassVar = {"gyro": 4e-4, "accel": 4e-3}

    def course(self, world: World) -> np.ndarray:
        return world.weather.pressure - 1013.0


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


class ChargeBuildUp(Following):
    """Accelerometers: charge gathers while the axis points up and leaks otherwise, with τ."""

    name = "x_charge_build_up"
    units: ClassVar = {"accel": "m/s^2", "tau": "s"}
    sized = ("accel",)
    typical: ClassVar = {"accel": 1e-2}

    @classmethod
    def beside(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"tau": float(rng.uniform(80, 200))}

    def course(self, world: World) -> np.ndarray:
        pace = world.motion.step / self.parameters["tau"]
        up = (world.motion.force > STANDARD_G / 2.0).astype(float)
        return np.stack([lagged(one, pace) for one in up])


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


class AirConditioning(Following):
    """Gyros: a bias that comes and goes with a cycle of minutes that nothing records."""

    name = "x_air_conditioning"
    units: ClassVar = {"gyro": "rad/s", "period": "s", "phase": "rad"}
    sized = ("gyro",)
    typical: ClassVar = {"gyro": 1.5e-4}

    @classmethod
    def beside(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "period": float(rng.uniform(70.0, 200.0)),
            "phase": float(rng.uniform(0.0, 2.0 * np.pi)),
        }

    def course(self, world: World) -> np.ndarray:
        turns = 2.0 * np.pi * world.t / self.parameters["period"]
        return np.asarray(np.sin(turns + self.parameters["phase"]))


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
