"""Memory in other forms than the plain plant's: play, Preisach, decay; steps of single axes."""

from itertools import pairwise
from typing import ClassVar

import numpy as np

from tests.proof.plant.effects.base import Effect, Parameters, unit_vector
from tests.proof.plant.effects.environment import both
from tests.proof.plant.effects.memory import in_one_direction
from tests.proof.plant.world import Setting, World, on_gyros


class HysteresisPlay(Effect):
    """A gyro's bias is the strain of a spring that slips: the play operator of the angle turned.

    Strain grows with the angle up to `width`, keeps there, and turns back with the motion
    (Prandtl's elastic-slip element); bias = amplitude · strain / width.
    """

    name, form = "hysteresis", "hysteresis_play"
    units: ClassVar = {"amplitude": "rad/s", "width": "rad"}
    sized = ("amplitude",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"amplitude": (1.2e-3 * unit_vector(rng)).tolist(),
                "width": float(rng.uniform(0.03, 0.5))}  # fmt: skip

    def sense(self, world: World) -> np.ndarray:
        strains = [_slipping(rate * world.motion.step / self.parameters["width"], rate)
                   for rate in world.motion.rates]  # fmt: skip
        return on_gyros(self.column("amplitude") * np.stack(strains))


def _slipping(turned: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """The strain between −1 and 1 that follows increments of its input and slips at ± 1."""
    strain = np.empty(len(turned))
    last = 0.0
    for low, high, _ in in_one_direction(rate):
        strain[low:high] = np.clip(last + np.cumsum(turned[low:high]), -1.0, 1.0)
        last = float(strain[high - 1])
    return strain


class HysteresisPreisach(Effect):
    """A gyro's bias is the mean of relays of its own rate (Preisach): what it went through stays.

    Relay k goes up above centre_k + half_k and down below centre_k − half_k, in shares of the
    run's top rate; all of them start down on the negative, up on the positive side of nothing.
    """

    name, form = "hysteresis", "hysteresis_preisach"
    units: ClassVar = {"amplitude": "rad/s", "centre": "1", "half": "1", "top_rate": "rad/s"}
    sized = ("amplitude",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "amplitude": (1.2e-3 * unit_vector(rng)).tolist(),
            "centre": rng.normal(0.0, 0.12, 16).tolist(),
            "half": rng.uniform(0.02, 0.5, 16).tolist(),
            "top_rate": setting.top_rate,
        }

    def sense(self, world: World) -> np.ndarray:
        shares = world.motion.rates / self.parameters["top_rate"]
        relays = zip(self.value("centre"), self.value("half"), strict=True)
        state = np.mean([_relay(shares, low - half, low + half) for low, half in relays], axis=0)
        return on_gyros(self.column("amplitude") * state)


def _relay(inputs: np.ndarray, down: float, up: float) -> np.ndarray:
    """±1 (3, n): +1 since an input last rose above `up`, −1 since it fell below `down`."""
    number = np.arange(inputs.shape[1])
    raised = np.maximum.accumulate(np.where(inputs >= up, number, -1), axis=1)
    fell = np.maximum.accumulate(np.where(inputs <= down, number, -1), axis=1)
    return np.sign(raised - fell).astype(float)


class HysteresisDecay(Effect):
    """A gyro's bias goes to ± amplitude with the way it turns and fades while it rests."""

    name, form = "hysteresis", "hysteresis_decay"
    units: ClassVar = {"amplitude": "rad/s", "angle": "rad", "tau": "s"}
    sized = ("amplitude",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"amplitude": (1.2e-3 * unit_vector(rng)).tolist(), "angle": 0.1,
                "tau": float(rng.uniform(8.0, 40.0))}  # fmt: skip

    def sense(self, world: World) -> np.ndarray:
        return on_gyros(self.column("amplitude") * np.stack([
            self._fading(rate, world.motion.step) for rate in world.motion.rates
        ]))  # fmt: skip

    def _fading(self, rate: np.ndarray, step: float) -> np.ndarray:
        state = np.empty(len(rate))
        last = 0.0
        for low, high, sign in in_one_direction(rate):
            pace = np.full(high - low, step / self.parameters["tau"])
            if sign:
                pace = np.abs(rate[low:high]) * step / self.parameters["angle"]
            state[low:high] = sign + (last - sign) * np.exp(-np.cumsum(pace))
            last = float(state[high - 1])
        return state


class _Step(Effect):
    """One or two channels jump at a time."""

    name = "bias_step"
    units: ClassVar = {"gyro": "rad/s", "accel": "m/s^2", "time": "s"}
    sized = ("gyro", "accel")

    @classmethod
    def stepping(cls, rng: np.random.Generator, time: float) -> Parameters:
        """Parameters with one channel, or one of each triad."""
        gyro, accel = np.zeros(3), np.zeros(3)
        which = int(rng.integers(3))
        if which != 1:
            gyro[rng.integers(3)] = 3e-3 * rng.choice([-1.0, 1.0])
        if which != 0:
            accel[rng.integers(3)] = 3e-2 * rng.choice([-1.0, 1.0])
        return {"gyro": gyro.tolist(), "accel": accel.tolist(), "time": time}

    def sense(self, world: World) -> np.ndarray:
        after = (world.t >= self.parameters["time"]).astype(float)
        return both(self.column("gyro"), self.column("accel"), after)


class BiasStepOfAxes(_Step):
    """One gyro, one accelerometer or one of each steps, at any time."""

    form = "bias_step_single"

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return cls.stepping(rng, float(rng.uniform(0.2, 0.8) * setting.plan.duration))


class BiasStepInMove(_Step):
    """The same, in the middle of a move that lies between a fifth and four fifths of the run."""

    form = "bias_step_moving"

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        middles = [
            (begin + end) / 2.0
            for segment, (begin, end) in zip(
                setting.plan.segments, pairwise(setting.plan.bounds), strict=True
            )
            if segment.goto is not None or segment.turn is not None or segment.name == "held"
        ]
        inner = [t for t in middles if 0.2 < t / setting.plan.duration < 0.8]
        return cls.stepping(rng, float(rng.choice(inner)))
