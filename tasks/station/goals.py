"""Where an axis is to settle, and whether a reading shows it there."""

from dataclasses import dataclass
from typing import Literal

from tasks.station.table import AxisState

# How near a reading has to be before «settled» is believed: the bit may still be that of the
# goal before. Whether the rate is right to the specification is for the encoders to say.
NEAR_DEG = 0.1
NEAR_RATE = (0.05, 0.5)  # relative, deg/s
REST_DEG_S = 0.05


@dataclass(frozen=True)
class Goal:
    """Where an axis is to settle: an angle (deg), a rate (deg/s), or rest."""

    axis: int
    kind: Literal["angle", "rate", "rest"]
    value: float = 0.0

    def is_reached(self, axis: AxisState) -> bool:
        if self.kind == "rest":
            return not axis.has("moving") and abs(axis.rate_deg_s) < REST_DEG_S
        if self.kind == "angle":
            return axis.has("settled") and abs(axis.angle_deg - self.value) < NEAR_DEG
        relative, absolute = NEAR_RATE
        near = relative * abs(self.value) + absolute
        return axis.has("settled") and abs(axis.rate_deg_s - self.value) < near

    def text(self) -> str:
        unit = {"angle": "deg", "rate": "deg/s"}.get(self.kind)
        return f"at {self.value:g} {unit}" if unit else "at rest"
