"""The site: the Earth turns, and gravity is what it is."""

from typing import ClassVar

import numpy as np

from tests.proof.plant.case import from_vector
from tests.proof.plant.effects.base import EARTH, Effect, Link, Parameters
from tests.proof.plant.world import Setting

EARTH_RATE = 7.292115e-5  # rad/s


class EarthRotation(Effect):
    """The ground turns under the table: one more rotation at the foot of the chain.

    The Earth's rate is what it is: only strength 0 and 1 mean anything.
    """

    name = "earth_rotation"
    units: ClassVar = {"rate": "rad/s", "latitude_deg": "deg"}
    sized = ("rate",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"rate": EARTH_RATE, "latitude_deg": setting.case.latitude_deg}

    def links(self, chain: list[Link], t: np.ndarray, shaft: np.ndarray) -> list[Link]:
        latitude = np.radians(self.parameters["latitude_deg"])
        axis = np.array([0.0, np.cos(latitude), np.sin(latitude)])
        turn = from_vector(axis[:, None] * (self.parameters["rate"] * t))
        return [(EARTH, turn), *chain]


class GravityValue(Effect):
    """Local gravity differs from the value told; unit and table know only the true one.

    The accelerometers' scale factors absorb it whole unless they also feel motion.
    """

    name = "gravity_value"
    units: ClassVar = {"difference": "m/s^2"}
    sized = ("difference",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"difference": float(rng.choice([-1.0, 1.0]) * rng.uniform(5e-4, 2e-3))}

    def gravity(self, declared: float) -> float:
        return declared + float(self.parameters["difference"])
