"""A procedure as the list of segments to be measured one after another."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import Literal

import numpy as np

from schemas.base import Unusable
from schemas.laboratory import MotionLimits
from schemas.procedure import Oscillation, Position, Procedure, RateRun, Refix, Sweep, Turns
from schemas.recording import AXES, Axis, Mount, Segment, TableAxis, Up
from schemas.station import PythonDevice, StationFile
from tasks.station.ports import Ask, AxisState, TableState
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
                common, dwell_s=step.dwell_s, turn_deg=step.turn_deg, chamber_degc=step.chamber_degc
            )
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


# What a procedure requires of a station: axes, reachable attitudes, who turns the unit over.

ALIGNED = np.cos(np.radians(5.0))  # a wrong label is off by 90 degrees, a mount by far less


@dataclass(frozen=True)
class Motion:
    """What a segment asks of one axis: rate (deg/s), lowest and highest angle (deg), and the
    acceleration (deg/s²) where it is not the procedure's.
    """

    segment: str
    axis: int
    rate_deg_s: float
    low_deg: float
    high_deg: float
    acceleration_deg_s2: float | None = None


def check_procedure(procedure: Procedure, station: StationFile) -> None:
    """Raises Unusable, naming the step, where the station cannot do what a step says."""
    axes = station.station.table_axes
    if not axes:
        raise Unusable(
            f"the station file of {station.station.id} lists no station.table_axes, and procedure "
            f"{procedure.name} needs them: list name and direction of each, outer first"
        )
    planned = plan(procedure)
    name, times = Counter(segment.name for segment in planned).most_common(1)[0]
    if times > 1:
        raise Unusable(
            f"procedure {procedure.name} has {times} segments named {name}: name each once"
        )
    for step in procedure.steps:
        if isinstance(step, Refix):
            continue
        if len(step.angles_deg) != len(axes):
            raise Unusable(
                f"step {step.name} of procedure {procedure.name} gives {len(step.angles_deg)} "
                f"angles and station {station.station.id} has {len(axes)} axes: choose a "
                f"procedure made for this table"
            )
        _check_axes(procedure, step, len(axes))
        _check_commands(procedure, step, station)
    for segment in planned:
        _check_attitude(segment, axes, procedure, station)


def check_attended(procedure: Procedure, station: StationFile, ask: Ask | None) -> None:
    """Raises Unusable where a unit is to be turned over by a person and none is there."""
    refixes = sum(isinstance(step, Refix) for step in procedure.steps)
    if refixes and station.fixture == "by_hand" and ask is None:
        raise Unusable(
            f"procedure {procedure.name} has the unit turned over by hand {refixes} times, and "
            f"nobody is at a terminal to be asked: run it in a terminal and without --json, or on "
            f"a station whose fixture is commanded"
        )


def mount_in(fixture: Mount, inside: Mount) -> Mount:
    """Attitude of the unit on the table: that of the fixture, then that of the unit in it."""
    from scipy.spatial.transform import Rotation

    outer, inner = (
        Rotation.from_quat(mount.quaternion_wxyz, scalar_first=True) for mount in (fixture, inside)
    )
    return Mount(quaternion_wxyz=tuple((outer * inner).as_quat(scalar_first=True).tolist()))


def _check_commands(
    procedure: Procedure,
    step: Position | Sweep | RateRun | Turns | Oscillation,
    station: StationFile,
) -> None:
    """What a description of the table has no command for."""
    table = station.table
    if isinstance(table, PythonDevice):
        return
    lacks = None
    if isinstance(step, Oscillation) and "oscillate" not in table.commands:
        lacks = "an oscillation, and the table has no command oscillate"
    if isinstance(step, Turns) and table.asks_within_a_turn:
        lacks = "whole turns, and move_to of the table takes angles within a turn"
    if lacks:
        raise Unusable(
            f"step {step.name} of procedure {procedure.name} is {lacks}: choose a procedure "
            f"without it, or describe the command in the station file of {station.station.id}"
        )


def _check_axes(
    procedure: Procedure, step: Position | Sweep | RateRun | Turns | Oscillation, axes: int
) -> None:
    for field in ("spin_axis", "table_axis"):
        axis = getattr(step, field, 0)
        if axis >= axes:
            raise Unusable(
                f"step {step.name} of procedure {procedure.name} spins axis {axis} and the "
                f"table has axes 0 to {axes - 1}: correct {field}"
            )
    if isinstance(step, RateRun) and 0.0 in step.rates_deg_s:
        raise Unusable(
            f"step {step.name} of procedure {procedure.name} has a rate of 0 in rates_deg_s: "
            f"make the rest a position"
        )


def _check_attitude(
    segment: PlannedSegment, axes: tuple[TableAxis, ...], procedure: Procedure, station: StationFile
) -> None:
    from scipy.spatial.transform import Rotation

    attitude = Rotation.identity()
    spin = np.zeros(3)
    for number, (axis, angle) in enumerate(zip(axes, segment.angles_deg, strict=True)):
        direction = np.array(axis.direction) / np.linalg.norm(axis.direction)
        if number == segment.spin_axis:
            spin = attitude.apply(direction)
        attitude = attitude * Rotation.from_rotvec(np.radians(angle) * direction)
    mount = mount_in(segment.fixture, station.mount) if segment.fixture else station.mount
    body = attitude * Rotation.from_quat(mount.quaternion_wxyz, scalar_first=True)
    up = body.inv().apply([0.0, 0.0, 1.0])
    if segment.up is not None and up @ _unit(segment.up) < ALIGNED:
        raise Unusable(
            f"step {segment.name} of procedure {procedure.name} says {segment.up} up, and its "
            f"angles_deg bring {_largest(up)} up on station {station.station.id}: correct the "
            f"angles, station.table_axes or mount"
        )
    if segment.axis is None or segment.spin_axis is None:
        return
    spin_in_body = body.inv().apply(spin)
    if spin_in_body @ _unit(f"+{segment.axis}") < ALIGNED:
        raise Unusable(
            f"step {segment.name} of procedure {procedure.name} says it turns about "
            f"{segment.axis}, and table axis {segment.spin_axis} turns the unit about "
            f"{_largest(spin_in_body)} there: correct axis, spin_axis or angles_deg"
        )


def _unit(signed_axis: str) -> np.ndarray:
    unit = np.zeros(3)
    unit[AXES.index(signed_axis[1])] = -1.0 if signed_axis[0] == "-" else 1.0
    return unit


def _largest(vector: np.ndarray) -> str:
    place = int(np.argmax(np.abs(vector)))
    return f"{'-' if vector[place] < 0 else '+'}{AXES[place]}"


def check_limits(procedure: Procedure, station: StationFile) -> None:
    """Raises Unusable, naming segment, axis and limit, for the first motion that is too much."""
    names = [axis.name for axis in station.station.table_axes or ()]
    for name in station.limits.axes:
        if name not in names:
            raise Unusable(
                f"limits.axes of the station file of {station.station.id} names {name}, and the "
                f"table has the axes {', '.join(names)}: correct the name"
            )
    for segment in plan(procedure):
        _check_chamber(segment, procedure, station)
        for motion in motions(segment, procedure):
            for what, limits in station.limits.of(names[motion.axis]):
                if broken := _broken(motion, limits, procedure.acceleration_deg_s2):
                    raise Unusable(
                        f"segment {motion.segment} of procedure {procedure.name} needs {broken} "
                        f"about axis {names[motion.axis]}, and {what} of station "
                        f"{station.station.id} is limited to less: change the procedure, or the "
                        f"limits of the station file if they are wrong"
                    )


def _check_chamber(segment: PlannedSegment, procedure: Procedure, station: StationFile) -> None:
    if segment.chamber_degc is None:
        return
    wanted = (
        f"segment {segment.name} of procedure {procedure.name} sets the chamber to "
        f"{segment.chamber_degc:g} °C"
    )
    if station.limits.chamber is None:
        raise Unusable(
            f"{wanted}, and the station file of {station.station.id} has no limits.chamber: state "
            f"there what the chamber can do, or choose a procedure that leaves it as it is"
        )
    low, high = station.limits.chamber.temperature_degc
    if not low <= segment.chamber_degc <= high:
        raise Unusable(
            f"{wanted}, and limits.chamber of station {station.station.id} allows {low:g} to "
            f"{high:g} °C: change the procedure, or the station file if its limits are wrong"
        )


def motions(segment: PlannedSegment, procedure: Procedure) -> Iterator[Motion]:
    """What a segment asks of each axis on the way to its angles, and of the one that it turns."""
    for axis, angle in enumerate(segment.angles_deg):
        yield Motion(segment.name, axis, procedure.move_rate_deg_s, angle, angle)
    if segment.spin_axis is None:
        return
    start, by, swing = (
        segment.angles_deg[segment.spin_axis], segment.turn_by_deg, segment.oscillation
    )  # fmt: skip
    low, high = (-inf, inf) if by is None else sorted((start, start + by))
    rate, acceleration = abs(segment.rate_deg_s), None
    if swing is not None:
        low, high = start - swing.amplitude_deg, start + swing.amplitude_deg
        rate, acceleration = swing.rate_deg_s, swing.acceleration_deg_s2
    yield Motion(segment.name, segment.spin_axis, rate, low, high, acceleration)


def _broken(motion: Motion, limits: MotionLimits, acceleration: float) -> str | None:
    """What a motion needs beyond the limits, in words."""
    if limits.rate_deg_s is not None and motion.rate_deg_s > limits.rate_deg_s:
        return f"{motion.rate_deg_s:g} deg/s (limit {limits.rate_deg_s:g})"
    acceleration = motion.acceleration_deg_s2 or acceleration
    if limits.acceleration_deg_s2 is not None and acceleration > limits.acceleration_deg_s2:
        return f"{acceleration:g} deg/s2 (limit {limits.acceleration_deg_s2:g})"
    low, high = limits.angle_deg or (-inf, inf)
    if motion.low_deg >= low and motion.high_deg <= high:
        return None
    if motion.high_deg == inf:
        return f"turns without end (limit {low:g} to {high:g} deg)"
    beyond = motion.low_deg if motion.low_deg < low else motion.high_deg
    return f"{beyond:g} deg (limit {low:g} to {high:g} deg)"
