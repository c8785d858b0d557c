"""What the unit goes through, on the fine grid: the ground on which effects act."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tests.proof.plant.case import Case
from tests.proof.plant.plan import Plan
from tests.proof.plant.rotations import inverse, slope, turned
from tests.proof.plant.unit import UnitErrors, draw_unit
from tests.proof.plant.weather import Weather, weather


@dataclass(frozen=True)
class Setting:
    """What is known before the run: enough to draw an effect's parameters."""

    case: Case
    plan: Plan

    @property
    def top_rate(self) -> float:
        """The largest rate of the run in rad/s; 1 where nothing turns."""
        turned = [abs(rate) for segment in self.plan.segments for rate in segment.ramp or ()]
        return max(turned, default=0.0) or 1.0

    @cached_property
    def unit(self) -> UnitErrors:
        own = self.case.unit_seed
        return draw_unit(self.case.seed if own is None else own)


@dataclass(frozen=True)
class Motion:
    """The unit's true motion. All (…, n) on the grid `t` (n,) s of the true time.

    shaft: (axes, n) rad. attitude: quaternion (4, n), unit to n. rates: (3, n) rad/s against
    inertial space. force: (3, n) m/s², what each accelerometer feels along its axis.
    seams: times in s at which the unit was re-fixed, between two takes.
    """

    t: np.ndarray
    shaft: np.ndarray
    attitude: np.ndarray
    rates: np.ndarray
    force: np.ndarray
    seams: np.ndarray

    @property
    def step(self) -> float:
        return float(self.t[1] - self.t[0])

    def angular_acceleration(self) -> np.ndarray:
        """(3, n) rad/s², from the rates' differences."""
        return slope(self.rates, self.step)

    def into_unit(self, vector: np.ndarray) -> np.ndarray:
        """A vector (3,) of n, East-North-Up, along the unit's axes: (3, n)."""
        return turned(inverse(self.attitude), vector)


@dataclass(frozen=True)
class World:
    """Everything at once: the motion, the room, the unit and what was planned."""

    setting: Setting
    motion: Motion

    @property
    def unit(self) -> UnitErrors:
        return self.setting.unit

    @cached_property
    def weather(self) -> Weather:
        return weather(self.setting.case, self.t)

    @property
    def t(self) -> np.ndarray:
        return self.motion.t

    def sensed_rates(self) -> np.ndarray:
        """(3, n) rad/s: what each gyro's element answers to, its own scale included."""
        return np.asarray(self.unit.Kg @ self.motion.rates)

    def sensed_force(self) -> np.ndarray:
        """(3, n) m/s²: what each accelerometer's element answers to."""
        return np.asarray(self.unit.Ka @ self.motion.force)


def on_gyros(signal: np.ndarray) -> np.ndarray:
    """(3, n) or (3, 1) rad/s as six channels."""
    return np.concatenate([signal, np.zeros_like(signal)])


def on_accelerometers(signal: np.ndarray) -> np.ndarray:
    """(3, n) or (3, 1) m/s² as six channels."""
    return np.concatenate([np.zeros_like(signal), signal])
