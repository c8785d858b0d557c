"""The turntable: drives that follow profiles through a servo, encoders, safety."""

import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from scipy import signal

from tasks.station.virtual.config import STEP_S, TableDesign
from tasks.station.virtual.profile import STANDING, Profile, to_angle, to_rate
from tasks.station.virtual.protocol import AXIS_STATUS, MODES, TABLE_STATUS

DEGREE = np.pi / 180.0
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
