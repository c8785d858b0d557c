"""Set-points of the table's axes: whether one is reached, and how long its motion takes."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Literal

from tasks.station.ports import AxisState, TableState

# How near a reading has to be before “settled” is believed: the report may still be that of the
# set-point before. Whether the rate is right to the specification is for the encoders to say.
NEAR_DEG = 0.1
NEAR_RATE = (0.05, 0.5)  # relative, deg/s
REST_DEG_S = 0.05


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

    def lateness(self, names: Sequence[str], state: TableState, limit_s: float) -> str:
        """The message about a table, by its axes' names, that has not arrived in time (s)."""
        axis = state.axes[self.axis]
        return (
            f"axis {names[self.axis]} of the table has not settled {self.text} within "
            f"{limit_s:.0f} s (angle {axis.angle_deg:.4f} deg, rate {axis.rate_deg_s:.4f} deg/s): "
            f"check its load, its balance and its servo"
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
