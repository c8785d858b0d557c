"""What a procedure requires of a station: axes, reachable attitudes, who turns the unit over."""

from collections import Counter

import numpy as np

from schemas.base import Unusable
from schemas.procedure import Position, Procedure, RateRun, Refix, Sweep, Turns
from schemas.recording import AXES, Mount, TableAxis
from schemas.station import StationFile
from tasks.station.plan import PlannedSegment, plan
from tasks.station.ports import Ask

ALIGNED = np.cos(np.radians(5.0))  # a wrong label is off by 90 degrees, a mount by far less


def check_procedure(procedure: Procedure, station: StationFile) -> None:
    """Raises Unusable, naming the step, where the station cannot do what a step says."""
    axes = station.station.table_axes
    if not axes:
        raise Unusable(
            f"the station file of {station.station.id} lists no station.table_axes, and procedure "
            f"{procedure.name} needs them: list name and direction of each, outer first"
        )
    planned = plan(procedure)
    _check_names(procedure, planned)
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


def _check_names(procedure: Procedure, planned: tuple[PlannedSegment, ...]) -> None:
    name, times = Counter(segment.name for segment in planned).most_common(1)[0]
    if times > 1:
        raise Unusable(
            f"procedure {procedure.name} has {times} segments named {name}: name each once"
        )


def _check_axes(procedure: Procedure, step: Position | Sweep | RateRun | Turns, axes: int) -> None:
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
    if up @ _unit(segment.up) < ALIGNED:
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
