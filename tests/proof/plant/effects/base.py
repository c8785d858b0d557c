"""What an effect is: parameters in SI, and the places in the plant where it may act.

Every place has a neutral answer here; an effect overrides only where its physics acts.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from tests.proof.plant.case import EffectCall, generator
from tests.proof.plant.world import Setting, World

Parameters = dict[str, Any]
Link = tuple[str, np.ndarray]
EARTH = "earth"  # the link that turns the ground itself, against inertial space


@dataclass(frozen=True)
class Effect:
    """One piece of physics with its true parameters.

    name: the catalogue's, or x_… outside it. units: of each parameter. sized: the parameters
    that strength multiplies.
    """

    parameters: Mapping[str, Any]
    setting: Setting

    name: ClassVar[str]
    units: ClassVar[Mapping[str, str]]
    sized: ClassVar[tuple[str, ...]]

    @classmethod
    def of(cls, call: EffectCall, setting: Setting) -> Self:
        """The effect of a case: drawn from its seed, replaced where told, then sized."""
        unknown = set(call.parameters) - set(cls.units)
        if unknown:
            raise ValueError(f"{cls.name} has no parameter {sorted(unknown)[0]}")
        drawn = cls.draw(generator(setting.case.seed, cls.name), setting)
        return cls(cls.at(drawn | dict(call.parameters), call.strength), setting)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        """Parameters of typical size."""
        raise NotImplementedError

    @classmethod
    def at(cls, typical: Parameters, strength: float) -> Parameters:
        """Parameters at a multiple of the typical size."""
        return {
            name: (np.asarray(value) * strength).tolist() if name in cls.sized else value
            for name, value in typical.items()
        }

    def value(self, name: str) -> np.ndarray:
        """A parameter as an array."""
        return np.asarray(self.parameters[name], dtype=float)

    def column(self, name: str) -> np.ndarray:
        """A parameter of three components as a column (3, 1)."""
        return self.value(name).reshape(3, 1)

    # the station and the table
    def gravity(self, declared: float) -> float:
        """True local gravity, m/s², from what the manifest tells."""
        return declared

    def shaft(self, motor: np.ndarray) -> np.ndarray:
        """True shaft angles (axes, n) rad, from where the drive holds them."""
        return motor

    def encoder(self, motor: np.ndarray) -> np.ndarray:
        """Reported angles (axes, n) rad, from where the drive holds them."""
        return motor

    # the geometry
    def links(self, chain: list[Link], t: np.ndarray, shaft: np.ndarray) -> list[Link]:
        """The chain of rotations from the ground (first) to the unit (last)."""
        return chain

    def fixing_error(self, fixing: int) -> np.ndarray | None:
        """Rotation vector (3,) rad by which the unit is fixed wrong, in its own axes."""
        return None

    def arms(self) -> np.ndarray | None:
        """Where each accelerometer sits: (3 accelerometers, 3) m in the unit's axes."""
        return None

    def bend(self, rates: np.ndarray) -> np.ndarray | None:
        """Rotation vector (3, n) rad by which the fixture gives way at rates (3, n) rad/s."""
        return None

    # the sensors
    def sense(self, world: World) -> np.ndarray | None:
        """What it adds to the six channels, (6, n), on the fine grid."""
        return None

    def shake(self, world: World) -> np.ndarray | None:
        """Random motion that the sensors follow, (6, n): in the readings, not in the truth."""
        return None

    def response(self, frequency: np.ndarray) -> np.ndarray | None:
        """The analogue path's transfer function at frequencies in Hz."""
        return None

    # the electronics and clocks
    def kept(self, count: int) -> np.ndarray | None:
        """Which samples arrive: (count,) of bool."""
        return None

    def true_time(self, stamp: np.ndarray) -> np.ndarray:
        """True time in s of samples that the unit's clock stamps so."""
        return stamp

    def delays(self) -> np.ndarray | None:
        """How much later than the first channel each is sampled: (6,) s."""
        return None

    def pick_up(self, t: np.ndarray) -> np.ndarray | None:
        """What the wiring adds to the six channels at the samples' true times: (6, n)."""
        return None

    def limits(self) -> np.ndarray | None:
        """What the six outputs can carry at most, either way: (6,)."""
        return None

    def step(self, steps: np.ndarray) -> np.ndarray:
        """The smallest step of each output, (6,)."""
        return steps


@dataclass(frozen=True)
class Following(Effect):
    """Biases that follow one course of time, each triad in a direction of its own.

    typical: the coefficients' size by triad, of gyros before accelerometers.
    """

    typical: ClassVar[Mapping[str, float]]

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        sizes = cls.typical.items()
        coefficients = {name: (size * unit_vector(rng)).tolist() for name, size in sizes}
        return coefficients | cls.beside(rng, setting)

    @classmethod
    def beside(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        """The other parameters."""
        return {}

    def course(self, world: World) -> np.ndarray:
        """What the biases follow, (n,) or (3, n)."""
        raise NotImplementedError

    def sense(self, world: World) -> np.ndarray | None:
        course, none = self.course(world), np.zeros((3, 1))
        gyro, accel = (
            (self.column(name) if name in self.typical else none) * course
            for name in ("gyro", "accel")
        )
        return np.concatenate([gyro, accel])


def unit_vector(rng: np.random.Generator) -> np.ndarray:
    """A direction in space, (3,), evenly drawn."""
    drawn = rng.standard_normal(3)
    return np.asarray(drawn / np.linalg.norm(drawn))


def insert_after(chain: list[Link], name: str, link: Link) -> list[Link]:
    """The chain with one more rotation behind a named one."""
    place = [present for present, _ in chain].index(name) + 1
    return [*chain[:place], link, *chain[place:]]
