"""A procedure as the list of segments to be measured one after another."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import sqrt
from typing import Literal

from schemas.base import Unusable
from schemas.procedure import Oscillation, Position, Procedure, RateRun, Refix, Sweep, Turns
from schemas.recording import Axis, Mount, Segment, Up
from tasks.station.ports import AxisState, TableState
from tasks.words import message

# How near a reading has to be before “settled” is believed: the report may still be that of the
# set-point before. Whether the rate is right to the specification is for the encoders to say.
NEAR_DEG = 0.1
NEAR_RATE = (0.05, 0.5)  # relative, deg/s
REST_DEG_S = 0.05
# For the estimate of duration only: what a servo takes to settle, a fixture to be turned over.
SERVO_S = 1.0
REFIX_S = 60.0


@dataclass(frozen=True)
class SetPoint:
    """Where an axis is to settle: an angle (deg), a rate (deg/s), or rest."""

    axis: int
    kind: Literal["angle", "rate", "rest"]
    value: float = 0.0

    def is_reached(self, axis: AxisState) -> bool:
        if self.kind == "rest":
            return not axis.is_moving and abs(axis.rate_deg_s) < REST_DEG_S
        if self.kind == "angle":
            return axis.is_settled and abs(axis.angle_deg - self.value) < NEAR_DEG
        relative, absolute = NEAR_RATE
        tolerance = relative * abs(self.value) + absolute
        return axis.is_settled and abs(axis.rate_deg_s - self.value) < tolerance

    @property
    def text(self) -> str:
        unit = {"angle": "deg", "rate": "deg/s"}.get(self.kind)
        return f"at {self.value:g} {unit}" if unit else "at rest"

    def lateness(self, names: Sequence[str], state: TableState, limit_s: float) -> Unusable:
        """The fault of a table, by its axes' names, that has not arrived in time (s)."""
        axis = state.axes[self.axis]
        return Unusable(
            f"axis {names[self.axis]} of the table has not settled {self.text} within "
            f"{limit_s:.0f} s (angle {axis.angle_deg:.4f} deg, rate {axis.rate_deg_s:.4f} deg/s): "
            f"check its load, its balance and its servo",
            message("station-cause.not-settled", axis=names[self.axis], seconds=f"{limit_s:.0f}"),
        )


@dataclass(frozen=True)
class PlannedSegment:
    """Move the table to angles (deg), perhaps spin an axis, then dwell.

    planned_s: the expected duration of all of that, from the end of the previous segment. refix:
    the unit is turned over first. fixture: the attitude of the fixture, None as long as it is that
    of the station file. turn_by_deg: whole turns instead of a dwell, oscillation: to and fro.
    chamber_degc: the chamber's set-point from the beginning of the dwell.
    """

    name: str
    item: str
    up: Up | None
    angles_deg: tuple[float, ...]
    dwell_s: float
    planned_s: float
    turn_deg: float | None = None
    axis: Axis | None = None
    spin_axis: int | None = None
    rate_deg_s: float = 0.0
    turn_by_deg: float | None = None
    chamber_degc: float | None = None
    refix: Refix | None = None
    fixture: Mount | None = None
    oscillation: Oscillation | None = None

    @property
    def kind(self) -> Literal["static", "rate", "rotation", "transition"]:
        if self.oscillation is not None:
            return "transition"
        if self.turn_by_deg is not None:
            return "rotation"
        return "static" if self.spin_axis is None else "rate"

    @property
    def text(self) -> str:
        """What happens, for the person at the bench: “rate x +200 deg/s”."""
        words = self.name.replace("_", " ")
        return f"{words} deg/s" if self.kind == "rate" else words

    def segment(self, t_start: float, t_end: float) -> Segment:
        """The label of this segment between two times (s)."""
        return Segment(
            name=self.name,
            kind=self.kind,
            t_start=t_start,
            t_end=t_end,
            item=self.item,
            up=self.up,
            turn_deg=self.turn_deg,
            axis=self.axis,
            table_axis=self.spin_axis if self.axis is None else None,
            rate_deg_s=None if self.spin_axis is None else self.rate_deg_s,
            angle_deg=self.turn_by_deg,
        )


def plan(procedure: Procedure) -> tuple[PlannedSegment, ...]:
    """The segments of a procedure that are measured, with the time that each is to take."""
    timed = []
    first = next(step for step in procedure.steps if not isinstance(step, Refix))
    angles = (0.0,) * len(first.angles_deg)
    rate, refix, fixture = 0.0, None, None
    for step in procedure.steps:
        if isinstance(step, Refix):
            refix, fixture = step, step.mount
            continue
        before_s = rate_change_s(rate, procedure.acceleration_deg_s2)
        if refix is not None:
            before_s += REFIX_S + (procedure.warm_up_s if refix.power_off else 0.0)
        rate = 0.0
        for planned in _segments_of(procedure, step):
            distances = (abs(b - a) for a, b in zip(angles, planned.angles_deg, strict=False))
            farthest = max(
                (min(distance, abs(360 - distance)) for distance in distances), default=0.0
            )
            angles_s = move_s(farthest, procedure.move_rate_deg_s, procedure.acceleration_deg_s2)
            change_s = 0.0
            if planned.kind == "rate":
                change_s = rate_change_s(planned.rate_deg_s - rate, procedure.acceleration_deg_s2)
                rate = planned.rate_deg_s
            moving_s = before_s + angles_s + change_s + SERVO_S + procedure.settle_s
            planned_s = moving_s + planned.dwell_s
            timed.append(replace(planned, planned_s=planned_s, refix=refix, fixture=fixture))
            before_s, refix, angles = 0.0, None, planned.angles_deg
    return tuple(timed)


def _segments_of(
    procedure: Procedure, step: Position | Sweep | RateRun | Turns | Oscillation
) -> Iterator[PlannedSegment]:
    """The segments of one step, without what comes before each."""
    common = PlannedSegment(
        step.name, step.item, step.up, step.angles_deg, 0.0, 0.0, axis=step.axis
    )
    match step:
        case Position():
            yield replace(
                common, dwell_s=step.dwell_s, turn_deg=step.turn_deg,
                chamber_degc=step.chamber_degc,
            )  # fmt: skip
        case Sweep():
            for stop in step.stops_deg:
                angles = list(step.angles_deg)
                angles[step.table_axis] = stop
                yield replace(
                    common,
                    name=f"{step.name}_{stop:03g}",
                    angles_deg=tuple(angles),
                    turn_deg=stop,
                    dwell_s=step.dwell_s,
                )
        case RateRun():
            for rate in step.rates_deg_s:
                yield replace(
                    common,
                    name=f"{step.name}_{rate:+g}",
                    spin_axis=step.spin_axis,
                    rate_deg_s=rate,
                    dwell_s=step.dwell_s,
                )
        case Oscillation():
            yield replace(
                common, spin_axis=step.spin_axis, dwell_s=step.seconds + SERVO_S, oscillation=step
            )
        case Turns():
            turn, rate = 360.0 * step.turns, step.rate_deg_s
            turning_s = move_s(turn, rate, procedure.acceleration_deg_s2)
            for sign, mark in ((1.0, "+"), (-1.0, "-")):
                yield replace(
                    common,
                    name=f"{step.name}_{mark}",
                    spin_axis=step.spin_axis,
                    rate_deg_s=sign * rate,
                    turn_by_deg=sign * turn,
                    dwell_s=turning_s + SERVO_S,
                )


def move_s(distance_deg: float, rate_deg_s: float, acceleration_deg_s2: float) -> float:
    """Duration of a trapezoidal motion profile over a distance, s."""
    distance = abs(distance_deg)
    ramp = rate_deg_s**2 / acceleration_deg_s2
    if distance < ramp:
        return 2 * sqrt(distance / acceleration_deg_s2)
    return distance / rate_deg_s + rate_deg_s / acceleration_deg_s2


def rate_change_s(change_deg_s: float, acceleration_deg_s2: float) -> float:
    """Duration of a change of rate, s."""
    return abs(change_deg_s) / acceleration_deg_s2


def nearest_turn(angle_deg: float, target_deg: float) -> float:
    """The angle equal to the target but for whole turns that lies nearest, deg.

    Encoders run on past whole turns, and an axis that has spun need not unwind (the tables of
    JJF 2003 table 1 turn without limit).
    """
    return target_deg + 360.0 * round((angle_deg - target_deg) / 360.0)
