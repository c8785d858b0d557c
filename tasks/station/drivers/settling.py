"""Whether an axis has settled, for a table that does not say so itself."""

from dataclasses import dataclass, field
from typing import Literal

from schemas.devices import ModbusTable, TextTable


@dataclass
class Settling:
    """One axis and where it was sent: settled once it has stayed within the table's tolerance."""

    described: ModbusTable | TextTable
    kind: Literal["angle", "rate", "off"] = "off"
    target: float = 0.0
    _near_since_s: float | None = field(default=None)

    def send(self, kind: Literal["angle", "rate", "off"], target: float = 0.0) -> None:
        """The axis is sent to an angle (deg) or a rate (deg/s), or to no place."""
        self.kind, self.target, self._near_since_s = kind, target, None

    def is_settled(self, station_s: float, angle_deg: float, rate_deg_s: float) -> bool:
        """By a reading at a station time."""
        if not self._is_near(angle_deg, rate_deg_s):
            self._near_since_s = None
            return False
        if self._near_since_s is None:
            self._near_since_s = station_s
        return station_s - self._near_since_s >= self.described.settled_s

    def _is_near(self, angle_deg: float, rate_deg_s: float) -> bool:
        rate = self.described.settled_rate
        if self.kind == "angle":
            is_still = abs(rate_deg_s) <= rate
            return is_still and abs(angle_deg - self.target) <= self.described.settled_deg
        off = abs(rate_deg_s - self.target)
        return self.kind == "rate" and off <= rate * max(abs(self.target), 1.0)
