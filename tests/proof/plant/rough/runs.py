"""The runs that are not a standard's: a motor shaft to and fro, a body moved by hand."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from tests.proof.plant.motion import MARGIN
from tests.proof.plant.plan import Plan, TableShape
from tests.proof.plant.procedures import plan_of
from tests.proof.plant.rotations import about, inverse, product, rates, turned
from tests.proof.plant.rough.case import RoughCase
from tests.proof.plant.seeds import generator
from tests.proof.plant.segments import Segment
from tests.proof.plant.world import Motion, Setting

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
