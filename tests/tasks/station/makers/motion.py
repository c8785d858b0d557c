"""Axes that turn as the virtual table's do, by what a controller's language tells them."""

import math

import numpy as np

from tasks.station.virtual.config import AXIS_STATUS, MODES
from tasks.station.virtual.table import Profile, VirtualTable

PIECES = 200  # of a period


class Axes:
    """The drives of a table in the units of its controllers, deg and deg/s; `sin` turns to and fro.

    Angles run on past whole turns.
    """

    def __init__(self, table: VirtualTable) -> None:
        self.table = table
        self.count = len(table.drives)

    def angle(self, axis: int) -> float:
        """What the encoder shows."""
        counts = int(self.table.counts(self.table.angle)[axis])
        return 360.0 * counts / self.table.design.counts_per_turn

    def rate(self, axis: int) -> float:
        return math.degrees(self.table.rate[axis])

    def is_moving(self, axis: int) -> bool:
        return bool(self.table.axis_status(axis) & AXIS_STATUS["moving"])

    def go(self, axis: int, angle: float, rate: float, acceleration: float) -> None:
        self.table.drives[axis].target_angle = math.radians(angle)
        self._start(axis, "angle", rate, acceleration)

    def turn(self, axis: int, rate: float, acceleration: float) -> None:
        self._start(axis, "rate", rate, acceleration)

    def swing(self, axis: int, amplitude: float, frequency: float, cycles: int) -> None:
        """A sinusoid about where it stands, drawn as pieces of constant acceleration."""
        drive, now = self.table.drives[axis], self.table.now
        start = float(drive.profile.at(np.array([now]))[0][0])
        t = np.linspace(0.0, cycles / frequency, PIECES * cycles + 1)
        rate = math.radians(amplitude) * 2.0 * np.pi * frequency * np.cos(2 * np.pi * frequency * t)
        rate *= np.minimum(1.0, 4.0 * np.minimum(t, t[-1] - t) * frequency)  # in and out
        change = np.append(np.diff(rate) / np.diff(t), 0.0)
        turned = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(t))])
        drive.profile = Profile(now + t, start + turned, rate, change)
        drive.mode, drive.setpoint = MODES["rate"], 0.0

    def halt(self, axis: int) -> None:
        self.table.command(axis, MODES["stop"])

    def _start(self, axis: int, mode: str, rate: float, acceleration: float) -> None:
        drive = self.table.drives[axis]
        drive.target_rate = math.radians(rate)
        drive.acceleration_limit = math.radians(acceleration)
        self.table.command(axis, MODES[mode])
