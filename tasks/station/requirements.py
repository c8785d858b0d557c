"""What a procedure requires of a station: axes, reachable attitudes, who turns the unit over."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from math import inf

import numpy as np

from schemas.base import Unusable
from schemas.devices import PythonDevice
from schemas.limits import MotionLimits
from schemas.procedure import Oscillation, Position, Procedure, RateRun, Refix, Sweep, Turns
from schemas.recording import AXES, Mount, TableAxis
from schemas.station import StationFile
from tasks.station.plan import PlannedSegment, plan
from tasks.station.ports import Ask

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
    procedure: Procedure, step: Position | Sweep | RateRun | Turns | Oscillation,
    station: StationFile,
) -> None:  # fmt: skip
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
