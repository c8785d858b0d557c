"""Whether a procedure suits a station: its axes, and which way up they bring the unit."""

from collections import Counter

import numpy as np

from schemas.base import Unusable
from schemas.procedure import Position, Procedure, RateRun, Refix, Sweep, Turns
from schemas.recording import AXES, TableAxis
from schemas.station import StationFile
from tasks.station.fixture import mount_in
from tasks.station.legs import Leg, legs_of

ALIGNED = np.cos(np.radians(5.0))  # a wrong label is off by 90 degrees, a mount by far less


def check_suits(procedure: Procedure, station: StationFile) -> None:
    """Raises Unusable, naming the step, where the station cannot do what a step says."""
    axes = station.station.table_axes
    if not axes:
        raise Unusable(
            f"the station file of {station.station.id} lists no station.table_axes, and procedure "
            f"{procedure.name} needs them: list name and direction of each, outer first"
        )
    legs = legs_of(procedure)
    _check_names(procedure, legs)
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
    for leg in legs:
        _check_attitude(leg, axes, procedure, station)


def _check_names(procedure: Procedure, legs: tuple[Leg, ...]) -> None:
    name, times = Counter(leg.name for leg in legs).most_common(1)[0]
    if times > 1:
        raise Unusable(
            f"procedure {procedure.name} has {times} stretches named {name}: name each once"
        )


def _check_axes(procedure: Procedure, step: Position | Sweep | RateRun | Turns, axes: int) -> None:
    moved = {
        "spin_axis": getattr(step, "spin_axis", 0),
        "table_axis": getattr(step, "table_axis", 0),
    }
    for field, axis in moved.items():
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
    leg: Leg, axes: tuple[TableAxis, ...], procedure: Procedure, station: StationFile
) -> None:
    from scipy.spatial.transform import Rotation

    attitude = Rotation.identity()
    spin = np.zeros(3)
    for number, (axis, angle) in enumerate(zip(axes, leg.angles_deg, strict=True)):
        direction = np.array(axis.direction) / np.linalg.norm(axis.direction)
        if number == leg.spin_axis:
            spin = attitude.apply(direction)
        attitude = attitude * Rotation.from_rotvec(np.radians(angle) * direction)
    mount = mount_in(leg.fixture, station.mount) if leg.fixture else station.mount
    body = attitude * Rotation.from_quat(mount.quaternion_wxyz, scalar_first=True)
    up = body.inv().apply([0.0, 0.0, 1.0])
    if up @ _unit(leg.up) < ALIGNED:
        raise Unusable(
            f"step {leg.name} of procedure {procedure.name} says {leg.up} up, and its angles_deg "
            f"bring {_largest(up)} up on station {station.station.id}: correct the angles, "
            f"station.table_axes or mount"
        )
    turns = leg.axis is not None and leg.spin_axis is not None
    if turns and body.inv().apply(spin) @ _unit(f"+{leg.axis}") < ALIGNED:
        raise Unusable(
            f"step {leg.name} of procedure {procedure.name} says it turns about {leg.axis}, and "
            f"table axis {leg.spin_axis} turns the unit about {_largest(body.inv().apply(spin))} "
            f"there: correct axis, spin_axis or angles_deg"
        )


def _unit(signed_axis: str) -> np.ndarray:
    unit = np.zeros(3)
    unit[AXES.index(signed_axis[1])] = -1.0 if signed_axis[0] == "-" else 1.0
    return unit


def _largest(vector: np.ndarray) -> str:
    place = int(np.argmax(np.abs(vector)))
    return f"{'-' if vector[place] < 0 else '+'}{AXES[place]}"
