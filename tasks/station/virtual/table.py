"""The turntable: drives that follow profiles through a servo, encoders, safety."""

import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from scipy import signal

from schemas.laboratory import ChamberLimits
from schemas.recording import Mount
from tasks.station.virtual.config import (
    AXIS_STATUS,
    DEGREE,
    FIXTURE_STATUS,
    MODES,
    STEP_S,
    TABLE_STATUS,
    TableDesign,
)

# The motion commanded by a drive: pieces of constant acceleration.


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
    """Goes from angle and rate at t to the target rate (rad/s) with the acceleration limit."""
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


SETTLED_AFTER_S = 0.5
ANGLE_TOLERANCE = 2.0 / 3600.0 * DEGREE
RATE_TOLERANCE = 1e-4  # of the rate, and of 1 °/s below it
MOVING = 0.001 * DEGREE
# A ramp that turns from +a to −a makes the servo overshoot by 2 × 4.6 % of a.
OVERSHOOT = 1.1
HUNTING_HZ = 3.0


Encoder = Callable[[np.ndarray], np.ndarray]  # from the axes' angles to those it shows, rad


def as_it_is(angles: np.ndarray) -> np.ndarray:
    return angles


@dataclass
class Drive:
    """One axis as its controller has it, SI."""

    profile: Profile
    mode: int = MODES["off"]
    target_angle: float = 0.0
    target_rate: float = 10.0 * DEGREE
    acceleration_limit: float = 100.0 * DEGREE
    setpoint: float = 0.0
    unsettled_s: float = 0.0  # station time when it was last out of tolerance


class VirtualTable:
    """The table's state at `steps` milliseconds after it was switched on."""

    def __init__(self, design: TableDesign) -> None:
        axes = len(design.axes)
        self.design = design
        self.drives = [Drive(STANDING) for _ in range(axes)]
        self.steps = 0
        self.angle = np.zeros(axes)
        self.rate = np.zeros(axes)
        self.trips: frozenset[str] = frozenset()
        self.rate_factor = 1.0
        self.hunting_rad = 0.0
        self.claims_settled = False
        self.encoder: Encoder = as_it_is
        self.capture_skips = 0
        self.captures_nothing = False
        self.captured = np.zeros((design.capture_kept, axes), dtype=np.int64)
        self.wanted: int | None = None  # the first captured sample that a client still wants
        omega = 2.0 * np.pi * design.servo_hz
        damping = 2.0 * design.servo_damping * omega
        # How far an axis lags behind its profile, from the mean rate asked in each step: exact
        # for the profile drawn straight between the steps.
        lag = ([1.0, damping], [1.0, damping, omega**2])
        b, a, _ = signal.cont2discrete(lag, STEP_S, method="zoh")
        self._lag = (b.ravel()[1:], a)
        self._lag_state = np.zeros((2, axes))

    @property
    def now(self) -> float:
        """Station time, s."""
        return self.steps * STEP_S

    def command(self, axis: int, mode: int) -> None:
        """Sets an axis going toward its targets; a tripped table only ramps to rest."""
        drive = self.drives[axis]
        drive.mode = MODES["stop"] if self.refuses else mode
        drive.unsettled_s = self.now
        (angle,), (rate,) = drive.profile.at(np.array([self.now]))
        state, limit = (self.now, float(angle), float(rate)), drive.acceleration_limit / OVERSHOOT
        speed = abs(drive.target_rate) * self.rate_factor
        if drive.mode == MODES["angle"] and speed > 0:
            drive.setpoint = drive.target_angle
            drive.profile = to_angle(*state, drive.setpoint, speed, limit)
        else:
            turning = drive.mode == MODES["rate"]
            drive.setpoint = drive.target_rate * self.rate_factor if turning else 0.0
            drive.profile = to_rate(*state, drive.setpoint, limit)

    def stop(self) -> None:
        """Ramps every axis to rest."""
        for axis in range(len(self.drives)):
            self.command(axis, MODES["stop"])

    def quick_stop(self) -> None:
        """Ramps every axis to rest with the deceleration that is kept for this."""
        for drive in self.drives:
            drive.acceleration_limit = self.design.quick_stop_deg_s2 * DEGREE
        self.stop()

    def trip(self, names: Iterable[str]) -> None:
        """Latches safety bits and stops; they stay until `reset`."""
        self.trips |= frozenset(names)
        self.stop()

    def reset(self) -> None:
        """Clears the safety bits."""
        self.trips = frozenset()

    @property
    def refuses(self) -> bool:
        """Whether a safety bit forbids motion; the watchdog stops it, but forbids nothing."""
        return bool(self.trips & AXIS_STATUS.keys())

    def advance(self, steps: int) -> np.ndarray:
        """Moves on and returns the axes' angles after each step, (steps, axes) rad."""
        t = (self.steps + np.arange(steps + 1)) * STEP_S
        asked = np.column_stack([drive.profile.at(t)[0] for drive in self.drives])
        mean_rates = np.diff(asked, axis=0) / STEP_S
        lag, self._lag_state = signal.lfilter(*self._lag, mean_rates, axis=0, zi=self._lag_state)
        t, angles = t[1:], asked[1:] - lag
        if self.hunting_rad:
            angles += self.hunting_rad * np.sin(2.0 * np.pi * HUNTING_HZ * t)[:, None]
        turned = np.diff(angles, axis=0, prepend=self.angle[None]) / STEP_S
        self._judge(t, angles, turned)
        self._capture(angles)
        self.steps += steps
        self.angle, self.rate = angles[-1], turned[-1]
        return angles

    def still_since(self) -> float:
        """Station time (s) since which no profile moves an axis, infinity while one does."""
        profiles = [drive.profile for drive in self.drives]
        if self.hunting_rad or any(profile.rate[-1] for profile in profiles):
            return float("inf")
        return max(float(profile.t[-1]) for profile in profiles)

    def rest(self, steps: int) -> None:
        """Moves on while it is still."""
        self._capture(np.broadcast_to(self.angle, (steps, len(self.angle))))
        self.steps += steps
        self.rate = np.zeros_like(self.angle)
        self._judge(np.array([self.now]), self.angle[None], self.rate[None])

    def _judge(self, t: np.ndarray, angles: np.ndarray, rates: np.ndarray) -> None:
        for drive, angle, rate in zip(self.drives, angles.T, rates.T, strict=True):
            if drive.mode == MODES["angle"]:
                wrong = np.abs(angle - drive.target_angle) >= ANGLE_TOLERANCE
            else:
                allowed = RATE_TOLERANCE * max(abs(drive.setpoint), DEGREE)
                wrong = np.abs(rate - drive.setpoint) >= allowed
            if wrong.any():
                drive.unsettled_s = float(t[wrong][-1])

    def _capture(self, angles: np.ndarray) -> None:
        numbers = np.arange(self.steps + 1, self.steps + 1 + len(angles))
        due = numbers % self.design.capture_ms == 0
        self.captured[numbers[due] // self.design.capture_ms % self.design.capture_kept] = (
            self.counts(angles[due])
        )

    def counts(self, angles: np.ndarray) -> np.ndarray:
        """The encoders' counts at the angles (rad), any shape, int64."""
        shown = self.encoder(angles)
        return np.rint(shown / (2.0 * np.pi) * self.design.counts_per_turn).astype(np.int64)

    def capture(self, first: int, count: int) -> tuple[int, np.ndarray]:
        """Up to `count` captured samples from number `first` on, or from the oldest kept.

        Returns the number of the first one and the counts (n, axes).
        """
        newest = self.steps // self.design.capture_ms
        oldest = newest - self.design.capture_kept + 1
        first = max(first + self.capture_skips, oldest)
        last = first if self.captures_nothing else min(first + count, newest + 1)
        numbers = np.arange(first, last)
        return first, self.captured[numbers % self.design.capture_kept]

    def want(self, first: int) -> None:
        """Keeps captured samples from number `first` on, or from the oldest that there is."""
        self.wanted = max(
            first, self.steps // self.design.capture_ms - self.design.capture_kept + 1
        )

    def room(self) -> int:
        """How many steps may pass until a sample that is wanted would be overwritten."""
        if self.wanted is None:
            return sys.maxsize
        last = (self.wanted + self.design.capture_kept) * self.design.capture_ms - 1
        return max(last - self.steps, 0)

    def axis_status(self, axis: int) -> int:
        """Bits of AXIS_STATUS."""
        drive = self.drives[axis]
        holds = drive.mode != MODES["off"] and self.now - drive.unsettled_s >= SETTLED_AFTER_S
        bits = {
            "ready": not self.refuses,
            "moving": abs(self.rate[axis]) > MOVING,
            "settled": holds or self.claims_settled,
            **dict.fromkeys(self.trips, True),
        }
        return sum(AXIS_STATUS.get(name, 0) for name, is_so in bits.items() if is_so)

    def status(self) -> int:
        """Bits of TABLE_STATUS."""
        ready = 0 if self.refuses else TABLE_STATUS["ready"]
        return ready | sum(TABLE_STATUS[name] for name in self.trips)


# Rotations as unit quaternions (w, x, y, z), many at once in arrays of shape (4, n).
#
# A rotation takes vectors of the inner frame to the outer one: v_outer = R(q)·v_inner.
#
# Written out because scipy's Rotation (1.17) takes thirteen times as long for the tracks of
# `tasks.validation.simulated_units`, which are made by the thousand; the tests hold it
# against scipy.


def about(direction: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rotations (4, n) about one unit direction (3,) by the angles (n,) in rad."""
    half = np.asarray(angle) / 2.0
    return np.vstack([np.cos(half), direction[:, None] * np.sin(half)])


def conjugate(q: np.ndarray) -> np.ndarray:
    """The rotations back, (4, n)."""
    return q * np.array([[1.0], [-1.0], [-1.0], [-1.0]])


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """R(p)·R(q), (4, n); either may have n = 1."""
    w, x, y, z = p
    a, b, c, d = q
    return np.stack(
        [
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        ]
    )


def up_in_body(q: np.ndarray) -> np.ndarray:
    """The outer frame's third axis in the inner frame, R(q)ᵀ·(0, 0, 1): (3, n)."""
    w, x, y, z = q
    return np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)])


def rotation_vector(q: np.ndarray) -> np.ndarray:
    """Rotation vectors (3, n) in rad of rotations by less than half a turn."""
    sine = np.sqrt(q[1] ** 2 + q[2] ** 2 + q[3] ** 2)
    turning = sine > 0
    factor = np.full_like(sine, 2.0)
    factor[turning] = 2.0 * np.arctan2(sine[turning], q[0][turning]) / sine[turning]
    return q[1:] * factor


# The fixture that turns the unit over on the payload, and the unit's supply.

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
        """The temperature of the air at a station time (s)."""
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
        way = product(conjugate(self._from), _unit(self.wanted))
        vector = rotation_vector(way if way[0, 0] >= 0 else -way)[:, 0]
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
        return product(self._attitude(t), self._seat)

    def _attitude(self, t: np.ndarray) -> np.ndarray:
        angle, _ = self._profile.at(t)
        return product(self._from, about(self._axis, angle))


def _unit(quaternion: np.ndarray) -> np.ndarray:
    return (quaternion / np.linalg.norm(quaternion))[:, None]
