"""What determines a simulated recording, to the last bit."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, Literal
from zlib import crc32

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

Grade = Literal["consumer", "industrial", "tactical"]
Procedure = Literal[
    "three_axis", "single_axis", "six_orientations", "one_axis", "rests", "ahrs", "given"
]  # fmt: skip
Order = Literal["rising", "alternating", "shuffled"]
Climate = Literal["room", "cycling"]


class Data(BaseModel):
    """A model that does not change and refuses fields it does not know."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class EffectCall(Data):
    """One piece of hidden physics.

    strength: multiplies the typical size (1). parameters: replace drawn ones before that, in SI.
    """

    name: str
    strength: float = Field(default=1.0, ge=0, allow_inf_nan=False)
    parameters: Mapping[str, Any] = {}


class Case(Data):
    """Unit, station, procedure and hidden physics of one recording.

    rate_hz: samples per second of unit and table. rates_deg_s: magnitudes, each turned both ways.
    gravity_m_s2, latitude_deg, heading_deg: what the manifest tells; they are true unless an
    effect says otherwise. temperature_recorded: whether the unit gives its own temperature.
    site_known: whether the manifest tells latitude and heading. unit_seed: which unit, where it is
    not a new one in each run.
    """

    seed: int = Field(ge=0)
    unit_seed: int | None = Field(default=None, ge=0)
    grade: Grade = "industrial"
    procedure: Procedure = "three_axis"
    rate_hz: int = Field(default=100, ge=10, le=2000)
    rates_deg_s: tuple[float, ...] = (10.0, 50.0, 100.0, 200.0, 300.0)
    dwell_s: float = Field(default=30.0, ge=5.0)
    order: Order = "rising"
    climate: Climate = "room"
    latitude_deg: float = Field(default=39.9, ge=-90, le=90)
    heading_deg: float = 0.0
    gravity_m_s2: float = Field(default=9.8015, gt=9.7, lt=9.9)
    temperature_recorded: bool = True
    site_known: bool = True
    effects: tuple[EffectCall, ...] = ()
    given: Mapping[str, Any] | None = None

    def only(self, *names: str) -> "Case":
        """The same case with these effects alone."""
        kept = tuple(effect for effect in self.effects if effect.name in names)
        return self.model_copy(update={"effects": kept})

    def without(self, name: str) -> "Case":
        """The same case with one effect taken out."""
        return self.only(*(effect.name for effect in self.effects if effect.name != name))

    def with_strength(self, name: str, strength: float) -> "Case":
        """The same case with one effect at another strength."""
        changed = tuple(
            effect.model_copy(update={"strength": strength}) if effect.name == name else effect
            for effect in self.effects
        )
        return self.model_copy(update={"effects": changed})


# Random numbers that depend on the case's seed and on what they are for, and on nothing else.


def generator(seed: int, purpose: str) -> np.random.Generator:
    """A generator of its own for each purpose: a new effect does not shift the noise."""
    return np.random.default_rng([seed, crc32(purpose.encode())])


# A run of the table as segments: hold, move to angles, change the rate, keep the rate.


@dataclass(frozen=True)
class Segment:
    """One segment of the run.

    label: further fields of the manifest's segment. fixing: which mounting of the unit it
    belongs to. goto: angles in rad to move to, one for each table axis, or None.
    ramp: (rate before, rate after) of the first axis in rad/s, or None; equal rates keep turning.
    turn: angle in rad by which the first axis turns from rest to rest, or None. chamber: °C to
    which the chamber is set as it begins, or None.
    """

    name: str
    kind: str
    duration: float
    fixing: int
    label: dict[str, Any]
    goto: tuple[float, ...] | None = None
    ramp: tuple[float, float] | None = None
    turn: float | None = None
    chamber: float | None = None


def follow(segment: Segment, start: np.ndarray, since: np.ndarray) -> np.ndarray:
    """Angles (axes, n) in rad at times `since` the segment's start, from the angles `start`."""
    angles = np.repeat(start[:, None], len(since), axis=1)
    share = since / segment.duration
    # minimum jerk: at rest, without acceleration, at both ends
    progress = share**3 * (10.0 + share * (-15.0 + 6.0 * share))
    if segment.goto is not None:
        angles += (arrival(segment, start) - start)[:, None] * progress
    if segment.turn is not None:
        angles[0] += segment.turn * progress
    if segment.ramp is not None:
        before, after = segment.ramp
        # the acceleration is one arch of 1 − cos: the rate's change, integrated once more
        grown = share**2 / 2.0 + (np.cos(2.0 * np.pi * share) - 1.0) / (4.0 * np.pi**2)
        angles[0] += segment.duration * (before * share + (after - before) * grown)
    return angles


def arrival(segment: Segment, start: np.ndarray) -> np.ndarray:
    """Where a move ends: its target, by the shortest way round."""
    target = np.asarray(segment.goto)
    return target + 2.0 * np.pi * np.round((start - target) / (2.0 * np.pi))


# A whole run: segments in order, the table that runs them and how the unit is fixed on it.


@dataclass(frozen=True)
class TableShape:
    """Names and directions of the table's axes, from the base to the payload."""

    names: tuple[str, ...]
    directions: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class Plan:
    """segments: what is done. mounts: quaternion (w, x, y, z) of each fixing, by its number."""

    standard: str
    table: TableShape
    segments: tuple[Segment, ...]
    mounts: tuple[tuple[float, float, float, float], ...]

    @cached_property
    def bounds(self) -> np.ndarray:
        """Times in s between the segments, from 0 to the end of the run."""
        return np.round(
            np.concatenate([[0.0], np.cumsum([segment.duration for segment in self.segments])]), 6
        )

    @property
    def duration(self) -> float:
        return float(self.bounds[-1])

    @cached_property
    def fixings(self) -> np.ndarray:
        """The number of the fixing in each segment."""
        return np.array([segment.fixing for segment in self.segments])

    def fixing_times(self) -> np.ndarray:
        """When each fixing begins, s."""
        changes = np.flatnonzero(np.diff(self.fixings)) + 1
        return self.bounds[np.concatenate([[0], changes])]

    def ends_of_moves(self) -> np.ndarray:
        """When each move to another position ends, s; changes of rate are not moves."""
        moved = [segment.goto is not None for segment in self.segments]
        return self.bounds[1:][np.array(moved)]

    def angles(self, t: np.ndarray) -> np.ndarray:
        """Demanded angles (axes, n) in rad at rising times; at rest before and after the run."""
        demanded = np.empty((len(self.table.names), len(t)))
        here = np.zeros(len(self.table.names))
        edges = np.searchsorted(t, self.bounds)
        demanded[:, : edges[0]] = here[:, None]
        for segment, begin, low, high in zip(
            self.segments, self.bounds, edges, edges[1:], strict=False
        ):
            demanded[:, low:high] = follow(segment, here, t[low:high] - begin)
            here = follow(segment, here, np.array([segment.duration]))[:, 0]
        demanded[:, edges[-1] :] = here[:, None]
        return demanded


# Noise of the three grades of unit, and the step of their outputs.

DEGREE = float(np.pi / 180.0)
G = 9.80665


@dataclass(frozen=True)
class Noise:
    """White and flicker noise of one triad: one-sided density S(f) = white² + instability²/(2πf).

    white: rad/s/√Hz or m/s²/√Hz. instability: B in rad/s or m/s². step: of the output.
    """

    white: float
    instability: float
    step: float

    def density(self, frequency: np.ndarray) -> np.ndarray:
        """S(f) for f > 0 in Hz."""
        return self.white**2 + self.instability**2 / (2.0 * np.pi * frequency)


GYRO_NOISE: dict[Grade, Noise] = {
    "consumer": Noise(0.012 * DEGREE, 25.0 * DEGREE / 3600.0, 0.0076 * DEGREE),
    "industrial": Noise(0.006 * DEGREE, 6.0 * DEGREE / 3600.0, 0.001 * DEGREE),
    "tactical": Noise(0.002 * DEGREE, 1.0 * DEGREE / 3600.0, 0.00002 * DEGREE),
}
ACCEL_NOISE: dict[Grade, Noise] = {
    "consumer": Noise(150e-6 * G, 100e-6 * G, 600e-6 * G),
    "industrial": Noise(80e-6 * G, 40e-6 * G, 100e-6 * G),
    "tactical": Noise(30e-6 * G, 10e-6 * G, 20e-6 * G),
}


def channel_noise(grade: Grade) -> tuple[Noise, ...]:
    """The six channels, gyros first."""
    return (GYRO_NOISE[grade],) * 3 + (ACCEL_NOISE[grade],) * 3


# Attitudes as quaternions (w, x, y, z) in arrays (4, n); (4, 1) is constant.


def about(axis: np.ndarray, angle: np.ndarray | float) -> np.ndarray:
    """Rotation about a unit axis (3,) by an angle in rad: (4, n)."""
    half = np.atleast_1d(np.asarray(angle, dtype=float)) / 2.0
    sine = np.sin(half)
    return np.stack([np.cos(half), axis[0] * sine, axis[1] * sine, axis[2] * sine])


def from_vector(vector: np.ndarray) -> np.ndarray:
    """Rotation vectors (3, n) or (3,), in rad, as quaternions (4, n)."""
    columns = vector.reshape(3, -1)
    angle = np.sqrt((columns**2).sum(axis=0))
    share = np.sinc(angle / (2.0 * np.pi)) / 2.0
    return np.concatenate([np.cos(angle / 2.0)[None], columns * share])


def product(first: np.ndarray, then: np.ndarray) -> np.ndarray:
    """first · then: the frame of `then` is carried by `first`."""
    a, b, c, d = first
    w, x, y, z = then
    return np.stack([
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ])  # fmt: skip


def inverse(q: np.ndarray) -> np.ndarray:
    """The opposite rotation."""
    return q * np.array([[1.0], [-1.0], [-1.0], [-1.0]])


def turned(q: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """A vector (3,) or (3, n) of the carried frame, seen from outside: (3, n)."""
    v = vector.reshape(3, -1)
    u = q[1:]
    twice = 2.0 * np.stack([
        u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0],
    ])  # fmt: skip
    cross = np.stack([
        u[1] * twice[2] - u[2] * twice[1],
        u[2] * twice[0] - u[0] * twice[2],
        u[0] * twice[1] - u[1] * twice[0],
    ])  # fmt: skip
    return v + q[0] * twice + cross


def vector_of(q: np.ndarray) -> np.ndarray:
    """The rotation vectors (3, n), in rad, of rotations by less than half a turn."""
    length = np.sqrt((q[1:] ** 2).sum(axis=0))
    half = np.arctan2(length, q[0])
    share = np.where(length > 1e-12, 2.0 * half / np.where(length > 1e-12, length, 1.0), 2.0)
    return q[1:] * share


def rates(q: np.ndarray, step: float) -> np.ndarray:
    """Angular rates (3, n − 4), rad/s, in the carried frame, at all but two points at each end.

    From the turns between the neighbours one and two points away on both sides, combined so that
    what is left of the error goes with the fourth power of `step`, the time in s between points.
    """
    near = vector_of(product(inverse(q[:, 1:-3]), q[:, 3:-1]))
    far = vector_of(product(inverse(q[:, :-4]), q[:, 4:]))
    return (8.0 * near - far) / (12.0 * step)


def slope(series: np.ndarray, step: float) -> np.ndarray:
    """The derivative of courses (…, n) that rest at both ends, to the same order as `rates`."""
    changed = np.zeros_like(series)
    near = series[..., 3:-1] - series[..., 1:-3]
    changed[..., 2:-2] = (8.0 * near - (series[..., 4:] - series[..., :-4])) / (12.0 * step)
    return changed


# A unit of models (1) and (2) of JJF 2003-2022, drawn from a seed.


@dataclass(frozen=True)
class UnitErrors:
    """gyro = Kg·ω + Bg + G·f, accel = Ka·f + Ba + P·ω²; SI, the first index reads."""

    Kg: np.ndarray
    Bg: np.ndarray
    G: np.ndarray
    Ka: np.ndarray
    Ba: np.ndarray
    P: np.ndarray

    def parameters(self) -> dict[str, list[float] | list[list[float]]]:
        """All of them as plain lists."""
        return {name: value.tolist() for name, value in asdict(self).items()}

    def reads(self, rates: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Readings (6, n) at rates (3, n) rad/s and specific force (3, n) m/s²."""
        gyro = self.Kg @ rates + self.Bg[:, None] + self.G @ force
        accel = self.Ka @ force + self.Ba[:, None] + self.P @ rates**2
        return np.concatenate([gyro, accel])


def draw_unit(seed: int) -> UnitErrors:
    """Scale 0.5 %, cross coupling 0.2 %, biases 0.2 °/s and 4 mg, small g- and ω²-sensitivity."""
    rng = generator(seed, "unit")
    off = 1.0 - np.eye(3)

    def matrix(diagonal: float, beside: float) -> np.ndarray:
        drawn = rng.standard_normal((3, 3))
        return np.asarray(drawn * (diagonal * np.eye(3) + beside * off))

    return UnitErrors(
        Kg=np.eye(3) + matrix(5e-3, 2e-3),
        Bg=3.5e-3 * rng.standard_normal(3),
        G=matrix(1.5e-5, 1.5e-5),
        Ka=np.eye(3) + matrix(5e-3, 2e-3),
        Ba=0.04 * rng.standard_normal(3),
        P=matrix(0.0, 4e-4),
    )
