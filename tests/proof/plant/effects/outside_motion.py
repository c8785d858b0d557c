"""Outside the catalogue: what follows the table's angle, its rate or its moves."""

from typing import ClassVar

import numpy as np
from scipy.signal import lfilter

from tests.proof.plant.case import from_vector
from tests.proof.plant.effects.base import Effect, Link, Parameters, insert_after, unit_vector
from tests.proof.plant.effects.environment import both
from tests.proof.plant.world import Setting, World, on_accelerometers, on_gyros


def since_last(t: np.ndarray, events: np.ndarray) -> np.ndarray:
    """Time in s since the last of the rising events; infinite before the first."""
    number = np.searchsorted(events, t, side="right") - 1
    return np.where(number >= 0, t - events[np.maximum(number, 0)], np.inf)


class StressRelaxation(Effect):
    """Accelerometers: after each move to another position a strain relaxes, e^(−t/τ)."""

    name = "x_stress_relaxation"
    units: ClassVar = {"accel": "m/s^2", "tau": "s"}
    sized = ("accel",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"accel": (3e-3 * unit_vector(rng)).tolist(), "tau": float(rng.uniform(5.0, 12.0))}

    def sense(self, world: World) -> np.ndarray:
        since = since_last(world.t, self.setting.plan.ends_of_moves())
        return on_accelerometers(self.column("accel") * np.exp(-since / self.parameters["tau"]))


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


class BearingClicks(Effect):
    """Accelerometers: a damaged ball rings the table at a number of times a turn that is not whole.

    Each click is a decaying ring of 10 ms along one direction, the same at any speed.
    """

    name = "x_bearing_clicks"
    units: ClassVar = {"accel": "m/s^2", "per_turn": "1", "ring": "Hz", "decay": "s"}
    sized = ("accel",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "accel": (0.02 * unit_vector(rng)).tolist(),
            "per_turn": float(rng.uniform(3.2, 7.8)),
            "ring": float(rng.uniform(18.0, 35.0)),
            "decay": 0.01,
        }

    def sense(self, world: World) -> np.ndarray:
        count = np.floor(world.motion.shaft[0] * self.parameters["per_turn"] / (2.0 * np.pi))
        clicks = world.t[1:][np.diff(count) != 0.0]
        since = np.minimum(since_last(world.t, clicks), 1e3)
        ring = np.sin(2.0 * np.pi * self.parameters["ring"] * since)
        return on_accelerometers(
            self.column("accel") * (ring * np.exp(-since / self.parameters["decay"]))
        )


class ThirdHarmonic(Effect):
    """Gyros: a bias that goes round three times a turn of the first axis, whatever the rate."""

    name = "x_third_harmonic"
    units: ClassVar = {"gyro": "rad/s", "phase": "rad"}
    sized = ("gyro",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "gyro": (1e-4 * unit_vector(rng)).tolist(),
            "phase": float(rng.uniform(0, 2 * np.pi)),
        }

    def sense(self, world: World) -> np.ndarray:
        wave = np.cos(3.0 * world.motion.shaft[0] + self.parameters["phase"])
        return on_gyros(self.column("gyro") * wave)


class RateHeating(Effect):
    """Biases follow a heat that turning makes: τ · dh/dt = (ω/ω_top)² − h; no sensor sees it."""

    name = "x_rate_heating"
    units: ClassVar = {"gyro": "rad/s", "accel": "m/s^2", "tau": "s", "top_rate": "rad/s"}
    sized = ("gyro", "accel")

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "gyro": (3e-4 * unit_vector(rng)).tolist(),
            "accel": (3e-3 * unit_vector(rng)).tolist(),
            "tau": float(rng.uniform(25.0, 60.0)),
            "top_rate": setting.top_rate,
        }

    def sense(self, world: World) -> np.ndarray:
        load = (world.motion.rates**2).sum(axis=0) / self.parameters["top_rate"] ** 2
        heat = lagged(load, world.motion.step / self.parameters["tau"])
        return both(self.column("gyro"), self.column("accel"), heat)


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
