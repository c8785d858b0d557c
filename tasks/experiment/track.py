"""A procedure as the encoders of an ideal table would record it."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from schemas.laboratory import ChamberLimits
from schemas.procedure import Oscillation, Procedure
from schemas.recording import ACCEL, GYRO, Manifest, Recording, Segment, Stream
from tasks.motion.samples import first_order_lag
from tasks.station.plan import SERVO_S, PlannedSegment, plan

# Predicts how a unit's temperature follows the set-points of a chamber.

MINUTE_S = 60.0
CELL_S = 5.0  # of a thermometer's means
LAGS = np.geomspace(30.0, 1500.0, 40)  # s, that are tried
USUAL_LAG = 300.0  # s, of a unit of which no warm-up tells it
LEAST_WARM_UP_K = 1.0  # a smaller one shows no time constant

SetPoint = tuple[float, float]  # s, °C


@dataclass(frozen=True)
class ThermalResponse:
    """usual_degc: of the unit when it is warm, and air_degc of the room, before anything is set.
    warm_up_k: by which it was colder when it was switched on. lag_s: time constant by which it
    warms up and follows the air.
    """

    usual_degc: float
    warm_up_k: float
    lag_s: float
    air_degc: float
    chamber: ChamberLimits

    @classmethod
    def of(cls, recording: Recording, chamber: ChamberLimits) -> "ThermalResponse | None":
        """By what the unit's own thermometer recorded; None where it has none."""
        degc = recording.imu.columns.get("temperature")
        if degc is None:
            return None
        room, median = recording.environment, float(np.nanmedian(degc))
        air = median if room is None else float(np.nanmedian(room.columns["temperature"]))
        return cls(*_warm_up(recording.imu.t, degc), air_degc=air, chamber=chamber)

    def temperatures(self, t: np.ndarray, set_points: Sequence[SetPoint]) -> np.ndarray:
        """(n,) °C of the unit at even times t (s) since it was switched on."""
        step = float(t[1] - t[0])
        most = self.chamber.rate_k_min / MINUTE_S
        air = np.full(len(t), self.air_degc)
        for at, target in set_points:
            later = t >= at
            from_degc = float(air[later][0])
            way = most * (t[later] - at)
            air[later] = from_degc + np.clip(target - from_degc, -way, way)
        heated = first_order_lag(air - self.air_degc, step, self.lag_s)
        return np.asarray(self.usual_degc - self.warm_up_k * np.exp(-t / self.lag_s) + heated)


def _warm_up(t: np.ndarray, degc: np.ndarray) -> tuple[float, float, float]:
    """°C in the end, K by which it was colder, and time constant (s): the exponential that fits
    best.
    """
    known = np.isfinite(degc)
    cell = ((t[known] - t[known][0]) / CELL_S).astype(int)
    counts = np.maximum(np.bincount(cell), 1)
    means = np.bincount(cell, degc[known]) / counts
    middles = np.arange(len(means)) * CELL_S
    if len(means) < 4 or np.ptp(means) < LEAST_WARM_UP_K:
        return float(np.median(means)), 0.0, USUAL_LAG
    tried = []
    for lag in LAGS:
        columns = np.column_stack([np.ones(len(means)), -np.exp(-middles / lag)])
        (end, colder), *_ = np.linalg.lstsq(columns, means, rcond=None)
        missed = float(((means - columns @ (end, colder)) ** 2).sum())
        tried.append((missed, float(end), float(colder), float(lag)))
    return min(tried)[1:]


TURN_DEG = 360.0
QUIET_NOISE = 1e-4  # rad/s, m/s²: what the unit reads, so that noise is told of something


@dataclass
class _Track:
    """Angles (deg) of each axis at even steps, piece by piece, and what is measured meanwhile.

    set_points: of the chamber.
    """

    step_s: float
    angles: np.ndarray
    speed: float = 0.0  # deg/s of the axis that spins
    spinning: tuple[int, tuple[float, ...]] | None = None  # this axis, at these angles of all
    count: int = 0
    pieces: list[np.ndarray] = field(default_factory=list)
    segments: list[Segment] = field(default_factory=list)
    set_points: list[SetPoint] = field(default_factory=list)

    @property
    def now(self) -> float:
        return self.count * self.step_s

    def stay(self, seconds: float, axis: int = 0, acceleration: float = 0.0) -> None:
        """On at the speed that the axis has, with an acceleration of it."""
        count = max(1, round(seconds / self.step_s))
        t = np.arange(1, count + 1) * self.step_s
        piece = np.tile(self.angles, (count, 1))
        piece[:, axis] += self.speed * t + 0.5 * acceleration * t**2
        self.speed += acceleration * count * self.step_s
        self._append(piece)

    def spins(self, axis: int, angles_deg: tuple[float, ...]) -> bool:
        """Whether an axis spins while the others are held at these angles."""
        return self.spinning == (axis, angles_deg)

    def spin(
        self, axis: int, angles_deg: tuple[float, ...], speed: float, acceleration: float
    ) -> None:
        """Ramps an axis to a speed, deg/s, with the others held at these angles."""
        self._to_speed(axis, speed, acceleration)
        self.spinning = (axis, angles_deg)

    def stop(self, acceleration: float) -> None:
        if self.spinning is not None:
            self._to_speed(self.spinning[0], 0.0, acceleration)
            self.spinning = None

    def _to_speed(self, axis: int, speed: float, acceleration: float) -> None:
        change = speed - self.speed
        count = max(1, round(abs(change) / acceleration / self.step_s))
        if change:
            self.stay(count * self.step_s, axis, change / (count * self.step_s))
        self.speed = speed

    def move(self, goal: np.ndarray, rate: float, acceleration: float) -> None:
        """All axes from rest to rest, each the shorter way."""
        way = (goal - self.angles + TURN_DEG / 2) % TURN_DEG - TURN_DEG / 2
        if np.abs(way).max() > 0.0:
            self._append(self.angles + way * _profile(np.abs(way).max(), rate, acceleration,
                                                      self.step_s)[:, None])  # fmt: skip

    def turn(self, axis: int, by: float, rate: float, acceleration: float) -> None:
        """One axis from rest to rest by an angle, however far."""
        way = np.zeros(len(self.angles))
        way[axis] = by
        self._append(
            self.angles + way * _profile(abs(by), rate, acceleration, self.step_s)[:, None]
        )

    def swing(self, step: Oscillation) -> None:
        """One axis to and fro, from rest to rest."""
        t = np.arange(1, round(step.seconds / self.step_s) + 1) * self.step_s
        piece = np.tile(self.angles, (len(t), 1))
        phase = 2.0 * np.pi * step.frequency_hz * t
        piece[:, step.spin_axis] += step.amplitude_deg * np.sin(phase)
        self._append(piece)

    def _append(self, piece: np.ndarray) -> None:
        self.pieces.append(piece)
        self.count += len(piece)
        self.angles = piece[-1].copy()


def _profile(distance: float, rate: float, acceleration: float, step_s: float) -> np.ndarray:
    """(n,) share of a distance behind it, by a trapezoid of the rate."""
    top = min(rate, float(np.sqrt(distance * acceleration)))
    ramp = top / acceleration
    whole = 2.0 * ramp + (distance - top * ramp) / top
    t = np.minimum(np.arange(1, int(np.ceil(whole / step_s)) + 1) * step_s, whole)
    up = 0.5 * acceleration * np.minimum(t, ramp) ** 2
    even = top * np.clip(t - ramp, 0.0, whole - 2.0 * ramp)
    last = np.clip(t - whole + ramp, 0.0, ramp)
    return np.asarray((up + even + top * last - 0.5 * acceleration * last**2) / distance)


def planned_recording(
    procedure: Procedure, like: Manifest, rate_hz: float, thermal: ThermalResponse | None = None
) -> Recording:
    """The table's stream and the labels of a procedure; the unit reads a little noise, and its
    temperature where the chamber is set.

    like: the manifest of a recording at that station. thermal: how the unit follows the chamber.
    Steps at `rate_hz` from time 0.
    Raises ValueError for a step that turns the unit over in its fixture: it was not planned for.
    """
    track = _Track(1.0 / rate_hz, np.zeros(len(like.station.table_axes or ())))
    track.stay(1.0)
    for segment in plan(procedure):
        if segment.refix is not None:
            raise ValueError(f"{segment.name} turns the unit over")
        _follow(track, segment, procedure)
    angles = np.vstack(track.pieces)
    t = np.arange(len(angles)) * track.step_s
    names = [f"{axis.name}_angle" for axis in like.station.table_axes or ()]
    columns = dict(zip(names, np.radians(angles).T, strict=True))
    fields = {
        "recording_id": procedure.name,
        "segments": tuple(track.segments),
        "standard": procedure.standard,
    }
    noise = np.random.default_rng(0).normal(scale=QUIET_NOISE, size=(6, len(t)))
    readings = dict(zip((*GYRO, *ACCEL), noise, strict=True))
    if thermal is not None and track.set_points:
        readings["temperature"] = thermal.temperatures(t, track.set_points)
    return Recording(like.model_copy(update=fields), Stream(t, readings), Stream(t, columns))


def _follow(track: _Track, segment: PlannedSegment, procedure: Procedure) -> None:
    rate, acceleration = procedure.move_rate_deg_s, procedure.acceleration_deg_s2
    goal, settle_s = np.array(segment.angles_deg), SERVO_S + procedure.settle_s
    axis = segment.spin_axis or 0
    if segment.kind != "rate" or not track.spins(axis, segment.angles_deg):
        track.stop(acceleration)
        track.move(goal, rate, acceleration)
    if segment.kind == "rate":
        track.spin(axis, segment.angles_deg, segment.rate_deg_s, acceleration)
    track.stay(settle_s, axis)
    start = track.now
    if segment.chamber_degc is not None:
        track.set_points.append((start, segment.chamber_degc))
    if segment.oscillation is not None:
        track.swing(segment.oscillation)
        track.stay(SERVO_S, axis)
    elif segment.turn_by_deg is not None:
        track.turn(axis, segment.turn_by_deg, abs(segment.rate_deg_s), acceleration)
        track.stay(SERVO_S, axis)
    else:
        track.stay(segment.dwell_s, axis)
    track.segments.append(segment.segment(start, track.now))
