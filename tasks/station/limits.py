"""Checks a whole procedure against the limits of a station, before anything moves."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf

from schemas.base import Unusable
from schemas.limits import MotionLimits
from schemas.procedure import Procedure
from schemas.station import StationFile
from tasks.station.plan import PlannedSegment, plan


@dataclass(frozen=True)
class Motion:
    """What a segment asks of one axis: rate (deg/s), and lowest and highest angle (deg)."""

    segment: str
    axis: int
    rate_deg_s: float
    low_deg: float
    high_deg: float


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
    start, by = segment.angles_deg[segment.spin_axis], segment.turn_by_deg
    low, high = (-inf, inf) if by is None else sorted((start, start + by))
    yield Motion(segment.name, segment.spin_axis, abs(segment.rate_deg_s), low, high)


def _broken(motion: Motion, limits: MotionLimits, acceleration: float) -> str | None:
    """What a motion needs beyond the limits, in words."""
    if limits.rate_deg_s is not None and motion.rate_deg_s > limits.rate_deg_s:
        return f"{motion.rate_deg_s:g} deg/s (limit {limits.rate_deg_s:g})"
    if limits.acceleration_deg_s2 is not None and acceleration > limits.acceleration_deg_s2:
        return f"{acceleration:g} deg/s2 (limit {limits.acceleration_deg_s2:g})"
    low, high = limits.angle_deg or (-inf, inf)
    if motion.low_deg >= low and motion.high_deg <= high:
        return None
    if motion.high_deg == inf:
        return f"turns without end (limit {low:g} to {high:g} deg)"
    beyond = motion.low_deg if motion.low_deg < low else motion.high_deg
    return f"{beyond:g} deg (limit {low:g} to {high:g} deg)"
