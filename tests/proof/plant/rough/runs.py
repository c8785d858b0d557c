"""The runs that are not a standard's: a motor shaft to and fro, a body moved by hand."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from pydantic import Field

from schemas.recording import Stream
from tests.proof.plant.case import (
    Case,
    Data,
    EffectCall,
    Plan,
    Segment,
    TableShape,
    about,
    from_vector,
    generator,
    inverse,
    product,
    rates,
    turned,
    vector_of,
)
from tests.proof.plant.procedures import plan_of
from tests.proof.plant.simulate import MARGIN, at_times
from tests.proof.plant.world import Motion, Setting

# What determines a rough recording, to the last bit.

Run = Literal["table", "shaft", "hand"]
Vector = tuple[float, float, float]


class Encoder(Data):
    """How the table is read. step, noise: rad. jitter: s, of its stamps about the true instants.

    speeds: whether it reports rates, too, each over the interval
    around its reading.
    """

    rate_hz: float = Field(gt=0)
    step: float = Field(gt=0)
    noise: float = Field(ge=0)
    jitter: float = Field(default=0.0, ge=0)
    speeds: bool = False


class Tracking(Data):
    """How the poses of a tracked body are measured.

    position_noise: m, each axis. attitude_noise: rad, each axis. turn: rotation vector in rad
    that carries the unit's axes into the tracked body's. tilt: rotation vector in rad of the
    room's axes against the true ones. arm: m from the tracked origin to the accelerometers, along
    the unit's axes. delay: s by which poses come late: what is stamped t happened at t − delay.
    interpolated: given at the unit's rows, in straight lines between the frames.
    gaps: (start, end) s in which nothing was seen.
    """

    rate_hz: float = Field(gt=0)
    position_noise: float = Field(ge=0)
    attitude_noise: float = Field(ge=0)
    turn: Vector = (0.0, 0.0, 0.0)
    tilt: Vector = (0.0, 0.0, 0.0)
    arm: Vector = (0.0, 0.0, 0.0)
    delay: float = 0.0
    interpolated: bool = False
    gaps: tuple[tuple[float, float], ...] = ()


class RoughCase(Data):
    """A case with its reference.

    run: the case's procedure on a table; a motor shaft to and fro; a body moved by hand.
    duration_s: of the latter two. top_rate: rad/s at the most, of the latter two.
    stamp_jitter: s, of the unit's stamps. axis: direction of the shaft in n.
    """

    case: Case
    run: Run
    duration_s: float = Field(default=90.0, gt=10.0)
    top_rate: float = Field(default=4.0, gt=0)
    stamp_jitter: float = Field(default=0.0, ge=0)
    axis: Vector = (0.0, 0.0, 1.0)
    encoder: Encoder | None = None
    tracking: Tracking | None = None

    def with_effects(self, effects: tuple[EffectCall, ...]) -> "RoughCase":
        """The same with other hidden physics."""
        case = self.case.model_copy(update={"effects": effects})
        return self.model_copy(update={"case": case})

    def without(self, *names: str) -> "RoughCase":
        """The same with some effects taken out."""
        return self.with_effects(tuple(e for e in self.case.effects if e.name not in names))

    def with_strength(self, name: str, strength: float) -> "RoughCase":
        """The same with one effect at another strength."""
        return self.model_copy(update={"case": self.case.with_strength(name, strength)})


STRAIGHT = (1.0, 0.0, 0.0, 0.0)
PEAK = 1.875  # peak over mean rate of a turn from rest to rest
WAVES = 40  # sines that make up one course of a motion by hand
AT_REST = 3.0  # s at both ends of a motion by hand


@dataclass(frozen=True)
class RoughSetting(Setting):
    """A setting whose largest rate is told: its plan does not say it."""

    rough: RoughCase

    @property
    def top_rate(self) -> float:
        return super().top_rate if self.rough.run == "table" else self.rough.top_rate


def setting_of(rough: RoughCase) -> RoughSetting:
    """The plan of a rough case, and what its effects are drawn from."""
    match rough.run:
        case "table":
            plan = plan_of(rough.case)
        case "shaft":
            plan = _shaft(rough)
        case "hand":
            held = Segment("held", "transition", rough.duration_s, 0, {})
            plan = Plan("other", TableShape((), ()), (held,), (STRAIGHT,))
    return RoughSetting(rough.case, plan, rough)


def _shaft(rough: RoughCase) -> Plan:
    segments = [Segment("rest", "settle", 5.0, 0, {})]
    for segment in _to_and_fro(rough):
        if sum(each.duration for each in segments) > rough.duration_s:
            break
        segments.append(segment)
    shape = TableShape(("shaft",), (rough.axis,))
    return Plan("other", shape, (*segments, replace(segments[0])), (STRAIGHT,))


def _to_and_fro(rough: RoughCase) -> Iterator[Segment]:
    """Turns there and back, rests between them, and now and then a rate that is held."""
    rng = generator(rough.case.seed, "shaft")
    way = 1.0
    while True:
        angle, share = rng.uniform(0.4, 2.8), rng.uniform(0.2, 1.0)
        seconds = max(PEAK * angle / (share * rough.top_rate), 0.5)
        yield Segment("turn", "transition", seconds, 0, {}, turn=way * angle)
        if rng.uniform() < 0.7:
            yield Segment("rest", "settle", float(rng.uniform(0.3, 3.0)), 0, {})
        if rng.uniform() < 0.25:
            rate = float(rng.uniform(0.3, 1.0) * rough.top_rate * rng.choice([-1.0, 1.0]))
            ramp = abs(rate) / 6.0
            yield Segment("up", "transition", ramp, 0, {}, ramp=(0.0, rate))
            yield Segment(
                "held", "transition", float(rng.uniform(1.0, 4.0)), 0, {}, ramp=(rate, rate)
            )
            yield Segment("down", "transition", ramp, 0, {}, ramp=(rate, 0.0))
        way = -way


@dataclass(frozen=True)
class ByHand:
    """A body moved by hand. attitude: (4, n), unit to n. place: (3, n) m, of the tracked origin."""

    t: np.ndarray
    attitude: np.ndarray
    place: np.ndarray


def move_by_hand(rough: RoughCase, t: np.ndarray) -> ByHand:
    """Band-limited random turning and moving with pauses, at times t (n,) s.

    Three angles and three coordinates are sums of sines of the hand's own time, which stands still
    in the pauses and at both ends. The fastest turn reaches the case's top rate.
    """
    rng = generator(rough.case.seed, "hand")
    own = _own_time(rng, t, rough.duration_s)
    slow, fast = 0.15, float(rng.uniform(0.6, 1.3))  # Hz
    angles = [_series(rng, own, slow, fast) for _ in range(3)]
    size = 1.0
    for _ in range(3):  # the rate grows a little faster than the angles
        attitude = _attitude(size * np.array(angles))
        size *= rough.top_rate / np.abs(rates(attitude, t[1] - t[0])).max()
    reach = float(rng.uniform(0.1, 0.5))  # m
    place = np.stack([_series(rng, own, slow, 0.7 * fast) for _ in range(3)])
    return ByHand(t, _attitude(size * np.array(angles)), reach / 2.0 * place)


def _own_time(rng: np.random.Generator, t: np.ndarray, duration: float) -> np.ndarray:
    """Time of the hand: runs with t, stands in some seconds out of ten."""
    wave = _series(rng, t, 0.02, 0.12)
    pace = 1.0 / (1.0 + np.exp(-6.0 * (wave + 0.8)))
    for end in (t - AT_REST, duration - AT_REST - t):
        pace *= np.clip(end, 0.0, 1.0) ** 3 * (10.0 + np.clip(end, 0.0, 1.0) * (
            -15.0 + 6.0 * np.clip(end, 0.0, 1.0)))  # fmt: skip
    return np.asarray(np.cumsum(pace) * (t[1] - t[0]))


def _series(rng: np.random.Generator, t: np.ndarray, slow: float, fast: float) -> np.ndarray:
    """A random course (n,) of rms 1 with frequencies between two, in Hz."""
    total = np.zeros(len(t))
    for frequency in rng.uniform(slow, fast, WAVES):
        total += np.sin(2.0 * np.pi * frequency * t + rng.uniform(0.0, 2.0 * np.pi))
    return total * np.sqrt(2.0 / WAVES)


def _attitude(angles: np.ndarray) -> np.ndarray:
    """Quaternions (4, n) of turns about z, then y, then x by three angles (3, n)."""
    axes = np.eye(3)[::-1]
    z, y, x = (about(axis, angle) for axis, angle in zip(axes, angles, strict=True))
    return product(product(z, y), x)


def felt(hand: ByHand, gravity: float, arm: np.ndarray) -> Motion:
    """What accelerometers at `arm` (3,) m from the tracked origin and gyros go through."""
    step = float(hand.t[1] - hand.t[0])
    inner = slice(MARGIN, -MARGIN)
    place = hand.place + turned(hand.attitude, arm)
    pull = np.diff(place[:, 1:-1], 2, axis=1) / step**2 + np.array([[0.0], [0.0], [gravity]])
    attitude = hand.attitude[:, inner]
    return Motion(
        t=hand.t[inner],
        shaft=np.zeros((0, attitude.shape[1])),
        attitude=attitude,
        rates=rates(hand.attitude, step),
        force=turned(inverse(attitude), pull),
        seams=np.empty(0),
    )


# What the reference says of the motion: a coarse encoder, or poses of a tracked body.

UP = np.array([0.0, 0.0, 1.0])
BAND = 10.0  # Hz: what a reference's noise does above it, anyone smooths away
POSE = ("qw", "qx", "qy", "qz")
PLACE = ("px", "py", "pz")
LEAST = 1e-6  # s between two stamps


def scattered(rng: np.random.Generator, t: np.ndarray, jitter: float) -> np.ndarray:
    """Stamps (n,) s that scatter about true instants, still rising."""
    stamps = t + jitter * rng.standard_normal(len(t)) if jitter else t.copy()
    order = np.arange(len(t)) * LEAST
    return np.asarray(np.maximum.accumulate(stamps - order) + order)


def read_encoder(rough: RoughCase, encoder: Encoder, plan: Plan, reported: Motion) -> Stream:
    """The table's stream: angles in steps, at the encoder's own rate and stamps."""
    rng = generator(rough.case.seed, "rough encoder")
    t = np.arange(0.0, plan.duration, 1.0 / encoder.rate_hz)
    true = at_times(reported.shaft, float(reported.t[0]), reported.step, t)
    stamps = scattered(rng, t, encoder.jitter)
    columns = {}
    for name, angle in zip(plan.table.names, true, strict=True):
        noisy = angle + encoder.noise * rng.standard_normal(len(t))
        read = np.round(noisy / encoder.step) * encoder.step
        columns[f"{name}_angle"] = read
        if encoder.speeds:
            columns[f"{name}_rate"] = np.gradient(read) * encoder.rate_hz
    return Stream(stamps, columns)


def track(rough: RoughCase, tracking: Tracking, hand: ByHand, rows: np.ndarray) -> Stream:
    """The stream of poses, at the frames' own stamps or at the unit's `rows` (n,) s."""
    rng = generator(rough.case.seed, "tracking")
    t = np.arange(0.0, rough.duration_s, 1.0 / tracking.rate_hz)
    start, step = float(hand.t[0]), float(hand.t[1] - hand.t[0])
    attitude = at_times(hand.attitude, start, step, t - tracking.delay)
    place = at_times(hand.place, start, step, t - tracking.delay)
    error = tracking.attitude_noise * rng.standard_normal((3, len(t)))
    attitude = product(attitude / np.linalg.norm(attitude, axis=0), from_vector(error))
    attitude = product(attitude, inverse(from_vector(np.array(tracking.turn))))
    tilt = from_vector(np.array(tracking.tilt))
    attitude = product(tilt, attitude)
    place = turned(tilt, place + tracking.position_noise * rng.standard_normal(place.shape))
    poses = np.concatenate([attitude, place])
    observation = np.ones(len(t), dtype=bool)
    for begin, end in tracking.gaps:
        observation &= (t < begin) | (t > end)
    t, poses = t[observation], poses[:, observation]
    if tracking.interpolated:
        t, poses = _between(t, poses, rows, tracking)
    poses[:4] /= np.linalg.norm(poses[:4], axis=0)
    return Stream(t, dict(zip(POSE + PLACE, poses, strict=True)))


def _between(
    t: np.ndarray, poses: np.ndarray, rows: np.ndarray, tracking: Tracking
) -> tuple[np.ndarray, np.ndarray]:
    """Poses in straight lines between frames at the unit's rows; none where nothing was seen."""
    inside = (rows >= t[0]) & (rows <= t[-1])
    for begin, end in tracking.gaps:
        inside &= (rows < begin) | (rows > end)
    return rows[inside], np.stack([np.interp(rows[inside], t, series) for series in poses])


def misread(rough: RoughCase, plan: Plan, recorded: Stream, motion: Motion, t: np.ndarray,
            place: np.ndarray | None = None) -> np.ndarray:  # fmt: skip
    """What the reference's noise adds to predicted rates and specific force: (6, n) at t (n,) s.

    The error of attitude (and of position) up to 10 Hz, differentiated; what the case tells as
    turn, tilt and delay is no noise and counts nothing. place: true positions (3, n) m at t.
    """
    step = float(t[1] - t[0])
    true = _unit(at_times(motion.attitude, float(motion.t[0]), motion.step, t))
    force = at_times(motion.force, float(motion.t[0]), motion.step, t)
    if rough.tracking is None:
        response = _from_shaft(rough, plan, recorded, t)
        moved = np.zeros((3, len(t)))
    else:
        response, moved = _from_poses(rough.tracking, recorded, t, place)
        moved = _second(_smooth(moved, step), step)
    error = vector_of(_short(product(inverse(true), response)))
    error = _smooth(error - np.median(error, axis=1, keepdims=True), step)
    rates = np.gradient(error, step, axis=1)
    return np.concatenate([rates, np.cross(force, error, axis=0) + turned(inverse(true), moved)])


def _from_shaft(rough: RoughCase, plan: Plan, recorded: Stream, t: np.ndarray) -> np.ndarray:
    response = about(UP, -np.radians(rough.case.heading_deg))
    for name, direction in zip(plan.table.names, plan.table.directions, strict=True):
        angle = np.interp(t, recorded.t, recorded.columns[f"{name}_angle"])
        response = product(response, about(np.array(direction), angle))
    return product(response, np.array(plan.mounts[0]).reshape(4, 1))


def _from_poses(
    tracking: Tracking, recorded: Stream, t: np.ndarray, place: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Attitude (4, n) and error of position (3, n) m, freed of what is told of the tracking."""
    columns = [recorded.columns[name] for name in POSE + PLACE]
    late = t + tracking.delay
    poses = np.stack([np.interp(late, recorded.t, column) for column in columns])
    upright = inverse(from_vector(np.array(tracking.tilt)))
    response = product(product(upright, _unit(poses[:4])), from_vector(np.array(tracking.turn)))
    where = turned(upright, poses[4:])
    return response, where - (where if place is None else place)


def _unit(q: np.ndarray) -> np.ndarray:
    return np.asarray(q / np.linalg.norm(q, axis=0))


def _short(q: np.ndarray) -> np.ndarray:
    return np.asarray(np.where(q[0] < 0.0, -q, q))


def _smooth(series: np.ndarray, step: float) -> np.ndarray:
    """Courses (…, n) without what lies above the band, a soft edge."""
    ends = [(0, 0)] * (series.ndim - 1) + [(0, series.shape[-1])]
    spectrum = np.fft.rfft(np.pad(series, ends, mode="symmetric"))
    frequency = np.fft.rfftfreq(2 * series.shape[-1], step)
    passed = np.fft.irfft(spectrum / (1.0 + (frequency / BAND) ** 8), 2 * series.shape[-1])
    return np.asarray(passed[..., : series.shape[-1]])


def _second(series: np.ndarray, step: float) -> np.ndarray:
    return np.asarray(np.gradient(np.gradient(series, step, axis=-1), step, axis=-1))
