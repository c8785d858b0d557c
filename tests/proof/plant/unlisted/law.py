"""What a law of an unlisted form is: a course of six readings, of which only the size is free."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tests.proof.plant.effects.gyro import signs
from tests.proof.plant.seeds import generator
from tests.proof.plant.world import World

Behaviour = Literal["hysteresis", "non-linearity", "rectification", "late temperature"]
Course = Callable[[World], np.ndarray]
GYROS, ACCELEROMETERS, BOTH = (1.0, 0.0), (0.0, 10.0), (1.0, 10.0)  # rad/s and m/s² beside another
BEHAVIOURS: tuple[Behaviour, ...] = (
    "hysteresis", "non-linearity", "rectification", "late temperature",
)  # fmt: skip


@dataclass(frozen=True)
class Law:
    """One law: each channel reads a factor of its own times the course of its axis.

    course: (3, n) or (n,) of what the unit goes through. triads: relative sizes of gyros and
    accelerometers. vibration: (n,) m/s², root mean square of the shaking that the accelerometers
    also read, as far as it lies within their band.
    """

    name: str
    behaviour: Behaviour
    triads: tuple[float, float]
    course: Course
    vibration: Course | None = None

    def sense(self, world: World) -> np.ndarray:
        """(6, n) at unit size."""
        course = np.broadcast_to(self.course(world), (3, len(world.t)))
        rng = generator(world.setting.case.seed, self.name)
        return np.concatenate([size * signs(rng)[:, None] * course for size in self.triads])


def shares_of_rate(world: World) -> np.ndarray:
    """(3, n) rates about the unit's axes, in shares of the run's largest."""
    return world.motion.rates / world.setting.top_rate


def shares_of_force(world: World) -> np.ndarray:
    """(3, n) specific force along the unit's axes, in shares of its largest."""
    force = world.motion.force
    return np.asarray(force / np.abs(force).max())


def speed(world: World) -> np.ndarray:
    """(n,) of turning, in shares of the run's largest rate."""
    return np.asarray(np.linalg.norm(shares_of_rate(world), axis=0))
