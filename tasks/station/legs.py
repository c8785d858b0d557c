"""A procedure as the flat list of stretches that are run one after another."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from schemas.procedure import Position, Procedure, RateRun
from schemas.recording import Axis, Segment, Up
from tasks.station.ramps import move_s, rate_change_s

SERVO_S = 1.0  # what a servo takes to settle, for the estimate of duration only


@dataclass(frozen=True)
class Leg:
    """One labelled stretch: bring the table to angles (deg), perhaps spin an axis, then dwell."""

    name: str
    item: str
    up: Up
    angles_deg: tuple[float, ...]
    dwell_s: float
    planned_s: float
    turn_deg: float | None = None
    axis: Axis | None = None
    spin_axis: int | None = None
    rate_deg_s: float = 0.0

    @property
    def kind(self) -> Literal["static", "rate"]:
        return "static" if self.spin_axis is None else "rate"

    @property
    def text(self) -> str:
        """What happens, for the person at the bench: «rate x +200 deg/s»."""
        words = self.name.replace("_", " ")
        return words if self.spin_axis is None else f"{words} deg/s"

    def segment(self, t_start: float) -> Segment:
        """The label of this stretch, from a time (s) on."""
        return Segment(
            name=self.name,
            kind=self.kind,
            t_start=t_start,
            t_end=round(t_start + self.dwell_s, 6),
            item=self.item,
            up=self.up,
            turn_deg=self.turn_deg,
            axis=self.axis,
            rate_deg_s=None if self.spin_axis is None else self.rate_deg_s,
        )


def legs_of(procedure: Procedure) -> tuple[Leg, ...]:
    """The stretches of a procedure, with the time each is planned to take from the one before."""
    return tuple(_walk(procedure))


def _walk(procedure: Procedure) -> Iterator[Leg]:
    angles = (0.0,) * len(procedure.steps[0].angles_deg)
    rate = 0.0
    for step in procedure.steps:
        stop_s = rate_change_s(rate, procedure.acceleration_deg_s2)
        before_s = stop_s + _move_s(procedure, angles, step.angles_deg)
        angles, rate = step.angles_deg, 0.0
        if isinstance(step, Position):
            yield _position(procedure, step, before_s)
            continue
        for next_rate in step.rates_deg_s:
            change_s = rate_change_s(next_rate - rate, procedure.acceleration_deg_s2)
            yield _rate(procedure, step, next_rate, before_s + change_s)
            before_s, rate = 0.0, next_rate


def _position(procedure: Procedure, step: Position, before_s: float) -> Leg:
    return Leg(
        name=step.name,
        item=step.item,
        up=step.up,
        turn_deg=step.turn_deg,
        angles_deg=step.angles_deg,
        dwell_s=step.dwell_s,
        planned_s=before_s + SERVO_S + procedure.settle_s + step.dwell_s,
    )


def _rate(procedure: Procedure, step: RateRun, rate: float, before_s: float) -> Leg:
    return Leg(
        name=f"{step.name}_{rate:+g}",
        item=step.item,
        up=step.up,
        axis=step.axis,
        angles_deg=step.angles_deg,
        spin_axis=step.spin_axis,
        rate_deg_s=rate,
        dwell_s=step.dwell_s,
        planned_s=before_s + SERVO_S + procedure.settle_s + step.dwell_s,
    )


def _move_s(procedure: Procedure, start: tuple[float, ...], stop: tuple[float, ...]) -> float:
    distances = (abs(b - a) for a, b in zip(start, stop, strict=False))
    farthest = max((min(distance, abs(360 - distance)) for distance in distances), default=0.0)
    return move_s(farthest, procedure.move_rate_deg_s, procedure.acceleration_deg_s2)
