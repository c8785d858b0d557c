"""How the station is set up: Earth, gravity, the table's axes and encoders, the arm, the clocks."""

from typing import ClassVar

import numpy as np

from tests.proof.plant.case import about, from_vector, product
from tests.proof.plant.effects.base import (
    EARTH,
    Effect,
    Link,
    Parameters,
    insert_after,
    unit_vector,
)
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


class RateRipple(Effect):
    """The payload's rate varies N times a turn and the table's stream does not show it.

    Cogging winds up the shaft between the motor, whose encoder the servo holds smooth, and the
    payload: shaft = motor + depth / N · sin(N · motor + phase), so the rate varies by ± depth.
    """

    name = "rate_ripple"
    units: ClassVar = {"depth": "1", "per_turn": "1", "phase": "rad"}
    sized = ("depth",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        per_turn = int(rng.choice([3, 4, 6, 8, 12, 16]))
        return {"depth": 1e-4, "per_turn": per_turn, "phase": float(rng.uniform(0, 2 * np.pi))}

    def shaft(self, motor: np.ndarray) -> np.ndarray:
        number, phase = self.parameters["per_turn"], self.parameters["phase"]
        moved = motor.copy()
        # counted from the index mark, where the axis stands at the start
        wave = np.sin(number * motor[0] + phase) - np.sin(phase)
        moved[0] += self.parameters["depth"] / number * wave
        return moved


class EncoderEccentricity(Effect):
    """The first axis's disc sits off centre: its encoder errs once a turn, the shaft is right.

    Reported = true + amplitude · (sin(true + phase) − sin(phase)), zero at the index mark; the
    reported rate follows. The drive does not run on this encoder: the error shows in the table's
    stream, not in the unit.
    """

    name = "encoder_eccentricity"
    units: ClassVar = {"amplitude": "rad", "phase": "rad"}
    sized = ("amplitude",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"amplitude": 1e-4, "phase": float(rng.uniform(0, 2 * np.pi))}

    def encoder(self, motor: np.ndarray) -> np.ndarray:
        read = motor.copy()
        phase = self.parameters["phase"]
        wave = np.sin(motor[0] + phase) - np.sin(phase)
        read[0] += self.parameters["amplitude"] * wave
        return read


class TableScale(Effect):
    """Every encoder says more than was turned, by a share; the servo holds what it says.

    The stream therefore shows round angles and rates, and the shaft turned less:
    reported = (1 + scale) · shaft.
    """

    name = "table_scale"
    units: ClassVar = {"scale": "1"}
    sized = ("scale",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"scale": float(6e-5 * rng.choice([-1.0, 1.0]))}

    def shaft(self, motor: np.ndarray) -> np.ndarray:
        return np.asarray(motor / (1.0 + self.parameters["scale"]))


class TimeOffset(Effect):
    """The unit's stamps are late by `seconds`: what it stamps t happened at t − seconds."""

    name = "time_offset"
    units: ClassVar = {"seconds": "s"}
    sized = ("seconds",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"seconds": float(1e-3 * rng.choice([-1.0, 1.0]))}

    def true_time(self, stamp: np.ndarray) -> np.ndarray:
        return stamp - self.parameters["seconds"]


class ClockSkew(Effect):
    """The unit's clock runs fast by a share: what it stamps t happened at t / (1 + share)."""

    name = "clock_skew"
    units: ClassVar = {"share": "1"}
    sized = ("share",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"share": float(1e-6 * rng.choice([-1.0, 1.0]))}

    def true_time(self, stamp: np.ndarray) -> np.ndarray:
        return np.asarray(stamp / (1.0 + self.parameters["share"]))


class AccelAxisSkew(Effect):
    """One converter serves the accelerometers in turn: x on time, y and z one and two steps later.

    The stamp is that of the first.
    """

    name = "accel_axis_skew"
    units: ClassVar = {"step": "s"}
    sized = ("step",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"step": 1e-3}

    def delays(self) -> np.ndarray:
        return np.array([0.0, 0.0, 0.0, 0.0, 1.0, 2.0]) * self.parameters["step"]


class DroppedSamples(Effect):
    """Runs of samples are lost; stamps are counted up from what arrives, so later ones slip.

    times: when each run begins, true time. lost: samples in each run, 2 at strength 1, at least 1.
    """

    name = "dropped_samples"
    units: ClassVar = {"times": "s", "lost": "1"}
    sized = ("lost",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        events = int(rng.integers(1, 4))
        times = np.sort(rng.uniform(0.1, 0.6, events)) * setting.plan.duration
        return {"times": times.tolist(), "lost": [2] * events}

    @classmethod
    def at(cls, typical: Parameters, strength: float) -> Parameters:
        lost = [max(1, round(number * strength)) for number in typical["lost"]]
        return {"times": typical["times"], "lost": lost}

    def kept(self, count: int) -> np.ndarray:
        kept = np.ones(count, dtype=bool)
        starts = self.value("times") * self.setting.case.rate_hz
        for start, lost in zip(starts.astype(int), self.parameters["lost"], strict=True):
            kept[start : start + lost] = False
        return kept
