"""Memory: biases that know what happened before."""

from itertools import pairwise
from typing import ClassVar

import numpy as np

from tests.proof.plant.case import generator
from tests.proof.plant.effects.base import Effect, Parameters, unit_vector
from tests.proof.plant.effects.environment import both
from tests.proof.plant.world import Setting, World, on_gyros

AT_REST = 1e-3  # rad/s: slower is not a motion (the Earth turns at 7e-5)


class Hysteresis(Effect):
    """Each gyro's bias remembers the way it turned last: rate-independent (Duhem) hysteresis.

    Bias = amplitude · s, where s goes to the sign of the rate within `angle` of turning,
    whatever the speed, and stays while nothing turns.
    """

    name = "hysteresis"
    units: ClassVar = {"amplitude": "rad/s", "angle": "rad"}
    sized = ("amplitude",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"amplitude": (1.2e-4 * unit_vector(rng)).tolist(), "angle": 0.1}

    def sense(self, world: World) -> np.ndarray:
        states = [
            _remembered(rate * world.motion.step / self.parameters["angle"], rate)
            for rate in world.motion.rates
        ]
        return on_gyros(self.column("amplitude") * np.stack(states))


def in_one_direction(rate: np.ndarray) -> list[tuple[int, int, float]]:
    """(first, past last, sign of the rate or 0 at rest) of each stretch."""
    sign = np.where(np.abs(rate) > AT_REST, np.sign(rate), 0.0)
    edges = np.concatenate([[0], np.flatnonzero(np.diff(sign)) + 1, [len(sign)]])
    return [(int(low), int(high), float(sign[low])) for low, high in pairwise(edges)]


def _remembered(turned: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """State between −1 and 1 that relaxes to the sign of the motion as motion goes on."""
    state = np.zeros(len(rate))
    last = 0.0
    for low, high, sign in in_one_direction(rate):
        if sign != 0.0:
            travel = np.cumsum(np.abs(turned[low:high]))
            state[low:high] = sign + (last - sign) * np.exp(-travel)
        else:
            state[low:high] = last
        last = state[high - 1]
    return state


class BiasStep(Effect):
    """The biases of one triad jump once, as after a knock; any direction in the triad."""

    name = "bias_step"
    units: ClassVar = {"gyro": "rad/s", "accel": "m/s^2", "time": "s"}
    sized = ("gyro", "accel")

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        gyros = bool(rng.integers(2))
        direction = unit_vector(rng)
        return {
            "gyro": (6e-4 * gyros * direction).tolist(),
            "accel": (6e-3 * (not gyros) * direction).tolist(),
            "time": float(rng.uniform(0.2, 0.8) * setting.plan.duration),
        }

    def sense(self, world: World) -> np.ndarray:
        after = (world.t >= self.parameters["time"]).astype(float)
        return both(self.column("gyro"), self.column("accel"), after)


class BiasRandomWalk(Effect):
    """The gyros' and accelerometers' biases walk at random, beyond the noise of the grade.

    One path for each channel from the case's seed; the path is part of the truth.
    """

    name = "bias_random_walk"
    units: ClassVar = {"gyro": "(rad/s)/√s", "accel": "(m/s^2)/√s"}
    sized = ("gyro", "accel")

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"gyro": 6e-6, "accel": 8e-5}

    def sense(self, world: World) -> np.ndarray:
        rng = generator(self.setting.case.seed, "bias_random_walk path")
        seconds = np.arange(int(self.setting.plan.duration) + 3) - 1.0
        paths = np.cumsum(rng.standard_normal((6, len(seconds))), axis=1)
        paths *= np.repeat([self.parameters["gyro"], self.parameters["accel"]], 3)[:, None]
        return np.stack([np.interp(world.t, seconds, path) for path in paths])
