"""A procedure file as a plan: how the plant's bench runs what somebody else wrote down."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import count
from typing import Any

import numpy as np

from schemas.procedure import Position, Procedure, RateRun, Sweep, Turns
from tests.proof.plant.plan import Plan, TableShape
from tests.proof.plant.segments import Segment

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
