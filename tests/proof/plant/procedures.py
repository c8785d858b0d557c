"""The procedures: JJF 2003-2022 on three axes and on one, parts of it, and JJF 1536-2015."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import count
from typing import Any

import numpy as np

from schemas.procedure import Position, Procedure, RateRun, Sweep, Turns
from tests.proof.plant.case import Case, Plan, Segment, TableShape, about, generator, product

# A procedure file as a plan: how the plant's bench runs what somebody else wrote down.

BEGIN_S, SETTLE_S = 1.0, 1.0
JERK_RATE, JERK_ACCELERATION = 1.875, 5.774  # peaks of a minimum jerk move over one second
STRAIGHT = (1.0, 0.0, 0.0, 0.0)


class _Bench:
    """The segments so far, and where the table stands."""

    def __init__(self, procedure: Procedure, axes: int) -> None:
        self.rate = float(np.radians(procedure.move_rate_deg_s))
        self.acceleration = float(np.radians(procedure.acceleration_deg_s2))
        self.settle_s = SETTLE_S + procedure.settle_s
        self.here = np.zeros(axes)
        self.number = count(1)

    def move(self, angles_deg: tuple[float, ...]) -> Iterator[Segment]:
        goal = np.radians(angles_deg)
        way = float(np.abs((goal - self.here + np.pi) % (2 * np.pi) - np.pi).max())
        if way > 1e-9:
            yield self._between("move", self.move_s(way, self.rate), goto=tuple(goal.tolist()))
        self.here = goal
        yield self._between("settle", self.settle_s)

    def ramp(self, before: float, after: float) -> Iterator[Segment]:
        """With the limit of the acceleration at its peak, which is twice the mean."""
        if before != after:
            seconds = 2.0 * abs(after - before) / self.acceleration
            yield self._between("ramp", seconds, ramp=(before, after))

    def kept(self, speed: float) -> Iterator[Segment]:
        """A rate while it settles."""
        yield self._between("settle", self.settle_s, ramp=(speed, speed))

    def spun(self) -> None:
        """Nobody knows the angle of an axis that was spun: the next move counts as half a turn."""
        self.here = self.here + np.eye(len(self.here))[0] * np.pi

    def move_s(self, way: float, rate: float) -> float:
        """Seconds from rest to rest, rad and rad/s."""
        by_rate = JERK_RATE * way / rate
        return round(max(by_rate, np.sqrt(JERK_ACCELERATION * way / self.acceleration), 0.1), 3)

    def _between(self, name: str, seconds: float, **more: Any) -> Segment:
        kind = "settle" if name == "settle" else "transition"
        return Segment(f"{name}{next(self.number):04d}", kind, round(seconds, 3), 0, {}, **more)


def plan_of_procedure(procedure: Procedure, table: TableShape) -> Plan:
    """Its steps on a table. Raises ValueError for one that turns the unit over by hand."""
    bench = _Bench(procedure, len(table.names))
    segments = [Segment("warm", "settle", BEGIN_S + procedure.warm_up_s, 0, {})]
    for step in procedure.steps:
        match step:
            case Position():
                move, rest = _rest(bench, step, step.angles_deg, step.name, step.turn_deg)
                segments += [*move, replace(rest, chamber=step.chamber_degc)]
            case Sweep():
                for stop in step.stops_deg:
                    angles = list(step.angles_deg)
                    angles[step.table_axis] = stop
                    name = f"{step.name}_{stop:g}"
                    move, rest = _rest(bench, step, tuple(angles), name, stop)
                    segments += [*move, rest]
            case RateRun():
                segments += _rates(bench, step)
            case Turns():
                segments += _turns(bench, step)
            case _:
                raise ValueError(f"{step.name} turns the unit over by hand")
    return Plan("other", table, tuple(segments), (STRAIGHT,))


def _label(step: Position | Sweep | RateRun | Turns, **more: Any) -> dict[str, Any]:
    label = {"item": step.item, "up": step.up, "axis": step.axis} | more
    if step.axis is None and isinstance(step, RateRun):
        label["table_axis"] = step.spin_axis
    return {name: value for name, value in label.items() if value is not None}


def _rest(
    bench: _Bench, step: Position | Sweep, angles: tuple[float, ...], name: str, turn: float | None
) -> tuple[list[Segment], Segment]:
    move = list(bench.move(angles))
    return move, Segment(name, "static", step.dwell_s, 0, _label(step, turn_deg=turn))


def _rates(bench: _Bench, step: RateRun) -> Iterator[Segment]:
    """About the first axis, as the plant's segments turn it."""
    if step.spin_axis != 0:
        raise ValueError(f"{step.name} spins axis {step.spin_axis}")
    yield from bench.move(step.angles_deg)
    now = 0.0
    for rate in step.rates_deg_s:
        speed = float(np.radians(rate))
        yield from bench.ramp(now, speed)
        yield from bench.kept(speed)
        label = _label(step, rate_deg_s=rate)
        yield Segment(f"{step.name}_{rate:+g}", "rate", step.dwell_s, 0, label, ramp=(speed, speed))
        now = speed
    yield from bench.ramp(now, 0.0)
    bench.spun()


def _turns(bench: _Bench, step: Turns) -> Iterator[Segment]:
    """Forward and back."""
    yield from bench.move(step.angles_deg)
    for sign, mark in ((1, "+"), (-1, "-")):
        angle = sign * 2.0 * np.pi * step.turns
        label = _label(step, angle_deg=sign * 360.0 * step.turns)
        seconds = bench.move_s(abs(angle), float(np.radians(step.rate_deg_s)))
        yield Segment(f"{step.name}_{mark}", "rotation", seconds, 0, label, turn=angle)
        yield from bench.move(step.angles_deg)


ACCELERATION = 120.0  # of the table, °/s²
MOVE = 4.0  # s
TURNS = 45.0  # s for ten turns of JJF 1536
UPS = ("+x", "-x", "+y", "-y", "+z", "-z")
# middle and inner angle, in quarter turns, that bring a body axis up (outer z, middle x, inner z)
QUARTERS = {"+x": (1, 1), "-x": (1, 3), "+y": (1, 0), "-y": (1, 2), "+z": (0, 0), "-z": (2, 0)}
THREE = TableShape(("outer", "middle", "inner"), ((0, 0, 1), (1, 0, 0), (0, 0, 1)))
SINGLE = TableShape(("table",), ((0, 0, 1),))


def plan_of(case: Case) -> Plan:
    """The plan of a case's procedure."""
    match case.procedure:
        case "single_axis":
            return _single_axis(case)
        case "ahrs":
            return _ahrs(case)
        case "given":
            return plan_of_procedure(Procedure.model_validate(case.given), THREE)
        case "rests":
            blocks = [_positions(case)]
        case "one_axis":
            blocks = [_rate_block(case, "+x")]
        case "six_orientations":
            blocks = [_rate_block(case, up) for up in UPS]
        case _:
            blocks = [_positions(case), *(_rate_block(case, up) for up in ("+x", "+y", "+z"))]
    segments = [Segment("warm", "settle", 10.0, 0, {})]
    for fixing, block in enumerate(blocks):
        segments += [replace(segment, fixing=fixing) for segment in block]
    straight = (1.0, 0.0, 0.0, 0.0)
    return Plan("JJF 2003-2022", THREE, _numbered(segments), (straight,) * len(blocks))


def _numbered(segments: list[Segment]) -> tuple[Segment, ...]:
    """Moves and ramps get the number of their place, as a sequence program would name them."""
    return tuple(
        replace(segment, name=f"{segment.name}{number:03d}")
        if segment.name in ("move", "ramp")
        else segment
        for number, segment in enumerate(segments)
    )


def _attitude(up: str, turn_deg: float = 0.0) -> tuple[float, float, float]:
    middle, inner = QUARTERS[up]
    return float(np.radians(turn_deg)), middle * np.pi / 2, inner * np.pi / 2


def _positions(case: Case) -> Iterator[Segment]:
    for up in UPS:
        for turn in (0, 180):
            yield Segment("move", "transition", MOVE, 0, {}, goto=_attitude(up, turn))
            label = {"item": "twelve_position", "up": up, "turn_deg": turn}
            yield Segment(f"position_{up}_{turn:03d}", "static", case.dwell_s, 0, label)


def _rate_block(case: Case, up: str) -> Iterator[Segment]:
    yield Segment("move", "transition", MOVE, 0, {}, goto=_attitude(up))
    yield from _rates_about(case, up)


def _rates_about(case: Case, up: str) -> Iterator[Segment]:
    """A rest, each rate with its ramps from and to rest, and a rest again."""
    name = up[1] if up[0] == "+" else f"{up[1]}_down"
    rest = {"item": "rate_sensitivity", "up": up}
    yield Segment(f"rest_{name}", "static", case.dwell_s, 0, rest)
    for rate in _ordered(case, up):
        yield from _one_rate(case.dwell_s, rate, up, f"rate_{name}_{rate:+.0f}")
    yield Segment(f"rest2_{name}", "static", case.dwell_s, 0, rest)


def _one_rate(dwell: float, rate: float, up: str, name: str) -> Iterator[Segment]:
    """`rate` is what the body's axis turns at, in °/s; with the axis down the table turns back."""
    table_rate = float(np.radians(rate)) * (1.0 if up[0] == "+" else -1.0)
    ramp = abs(rate) / ACCELERATION
    yield Segment("ramp", "transition", ramp, 0, {}, ramp=(0.0, table_rate))
    label = {"item": "scale_factor", "axis": up[1], "up": up, "rate_deg_s": rate}
    yield Segment(name, "rate", dwell, 0, label, ramp=(table_rate, table_rate))
    yield Segment("ramp", "transition", ramp, 0, {}, ramp=(table_rate, 0.0))


def _ordered(case: Case, up: str) -> list[float]:
    magnitudes = sorted(case.rates_deg_s)
    if case.order == "alternating":
        return [sign * rate for rate in magnitudes for sign in (1.0, -1.0)]
    rising = [-rate for rate in reversed(magnitudes)] + magnitudes
    if case.order == "shuffled":
        generator(case.seed, f"order {up}").shuffle(rising)
    return rising


def _mount(up: str, turn_deg: float = 0.0) -> tuple[float, float, float, float]:
    """The mounting that brings a body axis up on a table with one vertical axis."""
    turn, middle, inner = _attitude(up, turn_deg)
    z, x = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    w, i, j, k = product(product(about(z, turn), about(x, middle)), about(z, inner))[:, 0]
    return float(w), float(i), float(j), float(k)


def _single_axis(case: Case) -> Plan:
    """Six mountings by hand; in each two positions half a turn apart, upright ones the rates."""
    segments: list[Segment] = []
    for fixing, up in enumerate(UPS):
        block = [Segment(f"fixed_{up}", "settle", 10.0, fixing, {})]
        for turn in (0, 180):
            heading = (float(np.radians(turn)),)
            block.append(Segment("move", "transition", MOVE, fixing, {}, goto=heading))
            label = {"item": "twelve_position", "up": up, "turn_deg": turn}
            block.append(
                Segment(f"position_{up}_{turn:03d}", "static", case.dwell_s, fixing, label)
            )
        block.append(Segment("move", "transition", MOVE, fixing, {}, goto=(0.0,)))
        if up[0] == "+":
            block += _rates_about(case, up)
        block.append(Segment(f"unfix_{up}", "settle", 5.0, fixing, {}))
        segments += [replace(segment, fixing=fixing) for segment in block]
    return Plan("JJF 2003-2022", SINGLE, _numbered(segments), tuple(_mount(up) for up in UPS))


def _ahrs(case: Case) -> Plan:
    """JJF 1536-2015 with rates instead of accumulated angles: scale factor, turns, zero offset.

    The dwells are those of the case, four times as long for the zero offset; the clause's half
    hours are only longer.
    """
    blocks, mounts = [], []
    for up in ("+x", "+y", "+z"):
        blocks.append([*_rates_about(case, up), *_turns_about(up)])
        mounts.append(_mount(up))
    for number, (up, turn) in enumerate((up, turn) for up in ("+z", "-z") for turn in (0, 180)):
        label = {"item": "four_position", "axis": "x", "up": up}
        blocks.append([Segment(f"zero_x_{number + 1}", "static", 4 * case.dwell_s, 0, label)])
        mounts.append(_mount(up, turn))
    segments = [
        replace(segment, fixing=number) for number, block in enumerate(blocks) for segment in block
    ]
    return Plan("JJF 1536-2015", SINGLE, _numbered(segments), tuple(mounts))


def _turns_about(up: str) -> Iterator[Segment]:
    """Ten turns each way."""
    for sign in (1, -1):
        label = {"item": "misalignment", "axis": up[1], "up": up, "angle_deg": sign * 3600.0}
        angle = sign * 20.0 * np.pi
        name = f"turns_{up[1]}_{sign * 10:+d}"
        yield Segment(name, "rotation", TURNS, 0, label, turn=angle)
        yield Segment(f"pause_{name}", "settle", 5.0, 0, {})
