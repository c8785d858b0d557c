"""Geometry: where the accelerometers are, and axes that are not where they should be."""

from typing import ClassVar

import numpy as np

from tests.proof.plant.case import about, from_vector, product
from tests.proof.plant.effects.base import Effect, Link, Parameters, insert_after, unit_vector
from tests.proof.plant.world import Setting

EAST = np.array([1.0, 0.0, 0.0])
NORTH = np.array([0.0, 1.0, 0.0])


class LeverArm(Effect):
    """The accelerometers sit, together, off the point about which the table turns."""

    name = "lever_arm"
    units: ClassVar = {"r": "m"}
    sized = ("r",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"r": (0.002 * unit_vector(rng)).tolist()}

    def arms(self) -> np.ndarray:
        return np.tile(self.value("r"), (3, 1))


class SizeEffect(Effect):
    """Each accelerometer has its own place; their mean is the point about which the table turns.

    One row for each accelerometer. With the mean taken out there is no common lever arm.
    """

    name = "size_effect"
    units: ClassVar = {"r": "m"}
    sized = ("r",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        places = 0.002 * rng.standard_normal((3, 3))
        return {"r": (places - places.mean(axis=0)).tolist()}

    def arms(self) -> np.ndarray:
        return self.value("r")


class AxisTilt(Effect):
    """The base is not level: turned by the vector (east, north, 0); the encoders do not know."""

    name = "axis_tilt"
    units: ClassVar = {"east": "rad", "north": "rad"}
    sized = ("east", "north")

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        azimuth, size = rng.uniform(0.0, 2.0 * np.pi), 1e-4
        return {"east": size * float(np.cos(azimuth)), "north": size * float(np.sin(azimuth))}

    def links(self, chain: list[Link], t: np.ndarray, shaft: np.ndarray) -> list[Link]:
        tilt = from_vector(np.array([self.parameters["east"], self.parameters["north"], 0.0]))
        base = next(place for place, link in enumerate(chain) if link[0] == "heading")
        return [*chain[:base], ("base", tilt), *chain[base:]]


class AxisNonorthogonality(Effect):
    """Neighbouring axes of the table are not square: each joint is turned about its common normal.

    One angle for each pair of neighbours, about the direction square to both axes. Needs a table
    of several axes.
    """

    name = "axis_nonorthogonality"
    units: ClassVar = {"angles": "rad"}
    sized = ("angles",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        pairs = len(setting.plan.table.names) - 1
        if not pairs:
            raise ValueError("axis_nonorthogonality needs a table of several axes")
        signs = rng.choice([-1.0, 1.0], pairs)
        return {"angles": (3e-4 * signs * rng.uniform(0.5, 1.0, pairs)).tolist()}

    def links(self, chain: list[Link], t: np.ndarray, shaft: np.ndarray) -> list[Link]:
        table = self.setting.plan.table
        directions = np.array(table.directions, dtype=float)
        for joint, angle in enumerate(self.value("angles")):
            normal = np.cross(directions[joint], directions[joint + 1])
            link = (f"joint {joint}", about(normal / np.linalg.norm(normal), angle))
            chain = insert_after(chain, table.names[joint], link)
        return chain


class AxisWobble(Effect):
    """The first axis tips once or twice a turn, seen from the base: bearing races are not round.

    Tilt about East and North: amplitude · sin(order · angle + phase), each with its own phase.
    Once a turn, half of it is a cone that a fixed misalignment of the payload imitates.
    """

    name = "axis_wobble"
    units: ClassVar = {"amplitude": "rad", "order": "1", "phases": "rad"}
    sized = ("amplitude",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        phases = rng.uniform(0.0, 2.0 * np.pi, 2).tolist()
        return {"amplitude": 1e-4, "order": int(rng.integers(1, 3)), "phases": phases}

    def links(self, chain: list[Link], t: np.ndarray, shaft: np.ndarray) -> list[Link]:
        angle = self.parameters["order"] * shaft[0]
        east, north = (
            self.parameters["amplitude"] * np.sin(angle + phase)
            for phase in self.parameters["phases"]
        )
        return insert_after(
            chain, "heading", ("wobble", product(about(EAST, east), about(NORTH, north)))
        )


class StructuralCompliance(Effect):
    """The fixture bends under the centrifugal load: a rotation that grows with rate squared.

    Rotation vector in the unit's axes C · (ω_x², ω_y², ω_z²); no twist about the axis that turns
    (zero diagonal). The same plate carries the whole unit: gyros and accelerometers turn together.
    """

    name = "structural_compliance"
    units: ClassVar = {"C": "rad/(rad/s)^2"}
    sized = ("C",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        size = 3e-4 / setting.top_rate**2
        return {"C": (size * rng.standard_normal((3, 3)) * (1.0 - np.eye(3))).tolist()}

    def bend(self, rates: np.ndarray) -> np.ndarray:
        return np.asarray(self.value("C") @ rates**2)


class RemountMisalignment(Effect):
    """Each fixing of the unit is a little different; the manifest tells one and the same mounting.

    On a single axis, each re-fixing; on three axes, between the positions and each block of
    rates. One rotation vector for each fixing, in the unit's axes.
    """

    name = "remount_misalignment"
    units: ClassVar = {"vectors": "rad", "times": "s"}
    sized = ("vectors",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        fixings = len(setting.plan.mounts)
        if fixings < 2:
            raise ValueError("remount_misalignment needs a procedure with more than one fixing")
        vectors = 2e-4 * rng.standard_normal((fixings, 3))
        return {"vectors": vectors.tolist(), "times": setting.plan.fixing_times().tolist()}

    def fixing_error(self, fixing: int) -> np.ndarray:
        return np.asarray(self.value("vectors")[fixing])
