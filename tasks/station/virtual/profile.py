"""The motion commanded by a drive: pieces of constant acceleration."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Profile:
    """Pieces that begin at `t` (s) with angle (rad), rate (rad/s) and acceleration: (m,) each.

    The last piece continues indefinitely.
    """

    t: np.ndarray
    angle: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray

    def at(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Angle and rate at the times (n,), none before the first piece."""
        piece = np.searchsorted(self.t, t, side="right") - 1
        since = t - self.t[piece]
        rate, acceleration = self.rate[piece], self.acceleration[piece]
        angle = self.angle[piece] + since * (rate + 0.5 * since * acceleration)
        return angle, rate + since * acceleration


def _chain(
    t: float, angle: float, rate: float, pieces: tuple[tuple[float, float], ...], last_rate: float
) -> Profile:
    """Pieces (duration, acceleration) one after the other, then `last_rate` for ever."""
    rows = []
    for duration, acceleration in pieces:
        rows.append((t, angle, rate, acceleration))
        t += duration
        angle += duration * (rate + 0.5 * duration * acceleration)
        rate += duration * acceleration
    rows.append((t, angle, last_rate, 0.0))
    return Profile(*np.array(rows).T)


def to_rate(t: float, angle: float, rate: float, target: float, limit: float) -> Profile:
    """From angle and rate at t to the target rate (rad/s) with the acceleration limit."""
    ramp = (abs(target - rate) / limit, float(np.copysign(limit, target - rate)))
    return _chain(t, angle, rate, (ramp,), target)


STANDING = to_rate(0.0, 0.0, 0.0, 0.0, 1.0)


def to_angle(
    t: float, angle: float, rate: float, target: float, speed: float, limit: float
) -> Profile:
    """From angle and rate at t to rest at the target angle (rad), not faster than speed > 0."""
    would_stop_at = angle + rate * abs(rate) / (2.0 * limit)
    way = 1.0 if target >= would_stop_at else -1.0
    distance, start = way * (target - angle), way * rate
    peak = min(speed, float(np.sqrt(max(limit * distance + start**2 / 2.0, 0.0))))
    gain = 1.0 if peak >= start else -1.0
    ramps = (gain * (peak**2 - start**2) + peak**2) / (2.0 * limit)
    cruise = max(distance - ramps, 0.0)
    pieces = (
        (abs(peak - start) / limit, way * gain * limit),
        (cruise / speed, 0.0),
        (peak / limit, -way * limit),
    )
    return _chain(t, angle, rate, pieces, 0.0)
