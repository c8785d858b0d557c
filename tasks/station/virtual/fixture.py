"""The fixture that turns the unit over on the payload, and the unit's supply."""

import numpy as np

from schemas.limits import ChamberLimits
from schemas.recording import Mount
from tasks.station.virtual import quaternions
from tasks.station.virtual.profile import STANDING, to_angle
from tasks.station.virtual.protocol import FIXTURE_STATUS

MINUTE_S = 60.0
SPEED = np.radians(60.0)
ACCELERATION = np.radians(60.0)


class VirtualChamber:
    """Starts at the temperature of the air and stays there until commanded otherwise."""

    def __init__(self, design: ChamberLimits, degc: float) -> None:
        self._rate = design.rate_k_min / MINUTE_S
        self.target = degc
        self._since_s, self._from = 0.0, degc

    def go_to(self, now_s: float, degc: float) -> None:
        """Sets out for a temperature from where the air is."""
        self._from, self._since_s = self.degc(now_s), now_s
        self.target = degc

    def degc(self, now_s: float) -> float:
        """Of the air at a station time (s)."""
        way = self._rate * (now_s - self._since_s)
        return self._from + min(max(self.target - self._from, -way), way)


class VirtualFixture:
    """Turns about one axis from an attitude to the wanted one; `seat`: the unit's place in it."""

    def __init__(self, seat: Mount) -> None:
        self.wanted = np.array([1.0, 0.0, 0.0, 0.0])
        self._seat = _unit(np.array(seat.quaternion_wxyz))
        self._from = self.wanted[:, None].copy()
        self._axis = np.array([0.0, 0.0, 1.0])
        self._profile = STANDING

    def turn(self, now: float) -> None:
        """Sets out for the wanted attitude from where it is."""
        self._from = self._attitude(np.array([now]))
        way = quaternions.product(quaternions.conjugate(self._from), _unit(self.wanted))
        vector = quaternions.rotation_vector(way if way[0, 0] >= 0 else -way)[:, 0]
        angle = float(np.linalg.norm(vector))
        self._axis = vector / angle if angle else self._axis
        self._profile = to_angle(now, 0.0, 0.0, angle, SPEED, ACCELERATION)

    def still_since(self) -> float:
        """Station time (s) since which it does not move."""
        return float(self._profile.t[-1])

    def status(self, now: float) -> int:
        """Bits of FIXTURE_STATUS."""
        return FIXTURE_STATUS["ready" if now >= self.still_since() else "turning"]

    def mount(self, t: np.ndarray) -> np.ndarray:
        """Attitude of the unit on the payload at the times (n,), as quaternions (4, n)."""
        return quaternions.product(self._attitude(t), self._seat)

    def _attitude(self, t: np.ndarray) -> np.ndarray:
        angle, _ = self._profile.at(t)
        return quaternions.product(self._from, quaternions.about(self._axis, angle))


def _unit(quaternion: np.ndarray) -> np.ndarray:
    return (quaternion / np.linalg.norm(quaternion))[:, None]
