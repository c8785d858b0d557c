"""Simulated units and equipment, drawn from what the uncertainty budgets claim."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from schemas.recording import Manifest, Recording, Standard, Stream
from tasks.station.virtual import table as quaternion
from tasks.station.virtual.config import EARTH_RATE_RAD_S, THREE_AXES, UnitTruth, draw_unit
from tasks.station.virtual.sensors import SensorNoise
from tasks.uncertainty.equipment import ErrorLimit
from tasks.uncertainty.type_a import draw

# The calibration of a simulated unit: what the table reports, and what is true.
#
# The kinematics of the virtual station (quaternions, Earth, gravity, sensors at their own places)
# at the recording's own sampling, without servo, filters and counts on a wire, so that thousands
# of runs can be made. It shares no code with the items or the models that explain its data.

MOVE_S = 2.0  # from one place or rate to the next
SETTLE_S = 0.5
X, UP = np.eye(3)[0], np.eye(3)[2]


@dataclass(frozen=True)
class Site:
    """Where it is, truly: gravity m/s², latitude rad."""

    gravity: float
    latitude: float


@dataclass(frozen=True)
class TableErrors:
    """Errors of the table relative to what it reports.

    rate: true over reported rate of a whole turn, minus one. ripple, phase: the same within a turn,
    ripple·cos(angle + phase). level: (2,) rad, the outer axis off the vertical. joints: (2,) rad,
    middle axis off square to the outer one, inner axis to the middle one.
    """

    rate: float = 0.0
    ripple: float = 0.0
    phase: float = 0.0
    level: tuple[float, float] = (0.0, 0.0)
    joints: tuple[float, float] = (0.0, 0.0)


@dataclass
class Journey:
    """Table angles and their errors, appended piece by piece at half the interval of the rows.

    A piece is (9, n), rad: outer, middle and inner angle as the table says them, by how much each
    truly differs, and a small turn vector of the body in its fixture.
    """

    rate_hz: float
    segments: list[dict[str, Any]] = field(default_factory=list)
    _pieces: list[np.ndarray] = field(default_factory=list)
    _state: np.ndarray = field(default_factory=lambda: np.zeros(9))
    _rate: float = 0.0
    _half_steps: int = 0

    def place(
        self, outer: float, middle: float, inner: float, mounted: np.ndarray,
        errors: np.ndarray | None = None,
    ) -> None:  # fmt: skip
        """Moves to table angles (rad), where each is off by `errors` (3,) rad, and rests.

        mounted: (3,) rad, how the body is turned in its fixture.
        """
        goal = np.array(
            [outer, middle, inner, *(np.zeros(3) if errors is None else errors), *mounted]
        )
        goal[0] = self._state[0] + (outer - self._state[0] + np.pi) % (2.0 * np.pi) - np.pi
        part = 0.5 - 0.5 * np.cos(np.pi * self._times(MOVE_S) / MOVE_S)
        self._append(self._state[:, None] + (goal - self._state)[:, None] * part, goal)

    def change_rate(self, rate: float) -> None:
        """Ramps the outer axis to a rate, rad/s."""
        before, self._rate = self._rate, rate
        t = self._times(MOVE_S)
        self._turn(before * t + 0.5 * (rate - before) / MOVE_S * t**2,
                   0.5 * (before + rate) * MOVE_S)  # fmt: skip

    def stay(
        self, seconds: float, label: Mapping[str, Any], creep: np.ndarray | None = None
    ) -> None:
        """Continues at the present rate; a segment of the recording, shortly after the move.

        creep: (3,) rad, small angles by which the body turns meanwhile.
        """
        self._turn(self._rate * self._times(SETTLE_S), self._rate * SETTLE_S)
        start = self._half_steps / (2.0 * self.rate_hz)
        self._turn(self._rate * self._times(seconds), self._rate * seconds)
        if creep is not None:
            self._pieces[-1][6:] += creep[:, None] * self._times(seconds) / seconds
            self._state[6:] += creep
        end = self._half_steps / (2.0 * self.rate_hz)
        self._turn(self._rate * self._times(SETTLE_S), self._rate * SETTLE_S)
        self.segments.append({**label, "t_start": start, "t_end": end})

    def track(self) -> np.ndarray:
        """(9, n) at half steps from time 0."""
        return np.hstack(self._pieces)

    def _times(self, seconds: float) -> np.ndarray:
        return np.arange(round(seconds * self.rate_hz) * 2) / (2.0 * self.rate_hz)

    def _turn(self, turned: np.ndarray, whole: float) -> None:
        piece = np.tile(self._state[:, None], len(turned))
        piece[0] += turned
        goal = self._state.copy()
        goal[0] += whole
        self._append(piece, goal)

    def _append(self, piece: np.ndarray, goal: np.ndarray) -> None:
        self._pieces.append(piece)
        self._state = goal
        self._half_steps += piece.shape[1]


def attitudes(track: np.ndarray, errors: TableErrors) -> np.ndarray:
    """True attitude R_n_body (4, n) along a track (9, n)."""
    outer, middle, inner = track[:3] + track[3:6]
    truly = outer * (1.0 + errors.rate) + errors.ripple * np.sin(outer + errors.phase)
    level = np.array([[*errors.level, 0.0]]).T
    across = [_small(np.array([[0.0, joint, 0.0]]).T) for joint in errors.joints]
    q = quaternion.product(_small(level), quaternion.about(UP, truly))
    q = quaternion.product(quaternion.product(q, across[0]), quaternion.about(X, middle))
    q = quaternion.product(quaternion.product(q, across[1]), quaternion.about(UP, inner))
    return quaternion.product(q, _small(track[6:]))


def _small(turn: np.ndarray) -> np.ndarray:
    """Small turn vectors (3, n) rad as quaternions; their squares do not count."""
    return np.vstack([np.ones(turn.shape[1]), 0.5 * turn])


def turned(q: np.ndarray, later: np.ndarray, seconds: float, latitude: float) -> np.ndarray:
    """Turn vectors (3, n) in inertial space from attitudes (4, n) to later ones."""
    earth_axis = np.array([0.0, np.cos(latitude), np.sin(latitude)])
    earth = quaternion.about(earth_axis, np.array([EARTH_RATE_RAD_S * seconds]))
    back = quaternion.conjugate(q)
    return quaternion.rotation_vector(quaternion.product(quaternion.product(back, earth), later))


def accumulated_angles(
    track: np.ndarray, errors: TableErrors, site: Site, unit: UnitTruth, noise: SensorNoise | None
) -> np.ndarray:
    """Angles that the gyros of the unit have accumulated at each whole step, (3, n) rad."""
    q = attitudes(track, errors)[:, ::2]
    step = 1.0 / unit.rate_hz
    turn = turned(q[:, :-1], q[:, 1:], step, site.latitude)
    gravity = quaternion.up_in_body(q) * site.gravity
    gravity = 0.5 * (gravity[:, 1:] + gravity[:, :-1])
    slow = np.array(unit.g_sensitivity) @ gravity + np.array([unit.gyro.bias]).T
    if noise is not None:
        slow += noise.draw(turn.shape[1])[:, :3].T
    gained = np.array(unit.gyro.scale) @ turn + slow * step
    return np.hstack([np.zeros((3, 1)), np.cumsum(gained, axis=1)])


def sensed_rates(
    track: np.ndarray, errors: TableErrors, site: Site, unit: UnitTruth, noise: SensorNoise | None
) -> np.ndarray:
    """What the unit puts out at each whole step, (6, n): rad/s and m/s².

    The rate at a step is the mean from half a step before to half a step after it.
    """
    q = attitudes(track, errors)
    step = 1.0 / unit.rate_hz
    halves = q[:, 1::2]
    before = np.hstack([q[:, :1], halves[:, :-1]])
    rate = turned(before, halves, step, site.latitude) / step
    rate[:, 0] = rate[:, 1]  # the first has half a step only
    angular = np.gradient(rate, step, axis=1)
    gravity = quaternion.up_in_body(q[:, ::2]) * site.gravity
    gyro = np.array(unit.gyro.scale) @ rate + np.array(unit.g_sensitivity) @ gravity
    accel = np.empty_like(gyro)
    for k, (row, place) in enumerate(zip(unit.accel.scale, unit.places_m, strict=True)):
        accel[k] = np.array(row) @ _force_at(np.array(place), rate, angular, gravity)
    read = np.vstack([gyro, accel]) + np.array([[*unit.gyro.bias, *unit.accel.bias]]).T
    if noise is not None:
        read += noise.draw(read.shape[1]).T
        steps = np.repeat([unit.gyro.lsb, unit.accel.lsb], 3)[:, None]
        read = np.rint(read / steps) * steps
    return read


def _force_at(
    place: np.ndarray, rate: np.ndarray, angular: np.ndarray, gravity: np.ndarray
) -> np.ndarray:
    """Specific force (3, n) at a place (3,) m of the turning body: f + α×r + ω(ω·r) − r·ω²."""
    tangential = np.cross(angular, place, axisa=0, axisc=0)
    square = (rate**2).sum(axis=0)
    return gravity + tangential + rate * (place @ rate) - place[:, None] * square


GRAVITY, LATITUDE = 9.8015, float(np.radians(39.9))  # what the manifest says
NO_FLICKER = 0.25  # share of the units that have white noise alone
FLICKER_GRADES = (0.1, 10.0)  # times the unit's usual flicker, evenly in its logarithm


@dataclass(frozen=True)
class SimulatedUnit:
    """One simulated unit, its random numbers, and whether noise and equipment are ideal."""

    unit: UnitTruth
    random: np.random.Generator
    ideal: bool = False

    def error(self, *limits: ErrorLimit | None) -> float:
        """Sum of errors drawn from the limits' distributions, in their unit; 0 when ideal."""
        if self.ideal:
            return 0.0
        drawn = (limit.u * draw(limit.distribution, 1, self.random)[0] for limit in limits if limit)
        return float(sum(drawn))

    def errors(self, count: int, *limits: ErrorLimit | None) -> np.ndarray:
        """Independent errors (count,)."""
        return np.array([self.error(*limits) for _ in range(count)])

    def site(self, gravity: ErrorLimit, latitude: ErrorLimit) -> Site:
        """Where it truly is; the manifest says GRAVITY and LATITUDE."""
        return Site(GRAVITY + self.error(gravity), LATITUDE + self.error(latitude))

    def noise(self) -> SensorNoise | None:
        """The noise of the unit; None when ideal."""
        return None if self.ideal else SensorNoise(self.unit)


def draw_simulated_unit(seed: int, rate_hz: float, ideal: bool = False) -> SimulatedUnit:
    """A unit of the virtual station, with a grade of flicker of its own.

    A quarter of the units have white noise alone, as often as not in either triad.
    """
    unit = draw_unit(seed)
    random = np.random.default_rng(np.random.SeedSequence((seed, 2)))
    triads = {}
    for name in ("gyro", "accel"):
        triad = getattr(unit, name)
        low, high = np.log(FLICKER_GRADES)
        grade = float(np.exp(random.uniform(low, high))) * (random.random() >= NO_FLICKER)
        triads[name] = triad.model_copy(update={"flicker": triad.flicker * grade})
    return SimulatedUnit(unit.model_copy(update={**triads, "rate_hz": rate_hz}), random, ideal)


def recording_of(
    standard: Standard,
    number: int,
    journey: Journey,
    imu: Mapping[str, np.ndarray],
    table_angles: np.ndarray | None = None,
) -> Recording:
    """A journey as a recording: columns (n,) of the unit, and table angles (3, n) where recorded.

    The air is within the conditions, one row in ten seconds.
    """
    name = "AHRS" if standard == "JJF 1536-2015" else "MIMU"
    axes = {} if table_angles is None else {"table_axes": THREE_AXES}
    manifest = Manifest.model_validate({
        "format": "mimu-recording/1", "recording_id": f"simulated-{standard[4:8]}-{number}",
        "standard": standard,
        "unit": {"manufacturer": "Virtual", "model": f"V-{name}", "serial": f"S{number}"},
        "station": {"id": "simulated", "gravity_m_s2": GRAVITY, "heading_deg": 0.0,
                    "latitude_deg": float(np.degrees(LATITUDE)), **axes},
        "segments": journey.segments,
    })  # fmt: skip
    t = np.arange(len(next(iter(imu.values())))) / journey.rate_hz
    seconds = np.arange(0.0, t[-1], 10.0)
    air = {"temperature": np.full(len(seconds), 20.0), "humidity": np.full(len(seconds), 45.0)}
    table = None
    if table_angles is not None:
        names = (f"{axis.name}_angle" for axis in THREE_AXES)
        table = Stream(t, dict(zip(names, table_angles, strict=True)))
    return Recording(
        manifest, Stream(t, imu), table=table, environment=Stream(seconds, air), digest="0" * 64
    )
