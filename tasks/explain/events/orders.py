"""Readings against the angle of a table's axis: what recurs so many times a turn.

While the axis turns evenly, each reading is counted where the axis then stands. A Fourier
transform over the angle tells its orders (cycles a turn), for each speed by itself: a click lasts
the same time, not the same angle, at every speed.
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len, rfft

PER_TURN = 512  # cells of the angle
SLOWEST = 0.3  # rad/s
EVEN = 0.01  # of the speed that it may be off its class
LEAST_TURNS = 4.0  # in which an order is told
MOST_TURNS = 1000.0  # that an angle is followed for
MOST_CLASSES = 8
LEVEL = 1024  # orders that tell the noise about them
INTEGER = 2.0  # cells of the order about a whole number: what the table itself does
BAND = (0.5, 0.45)  # Hz; of the sample rate


@dataclass(frozen=True)
class AtSpeed:
    """One speed. turns: of it a second, with sign. rows: how many. orders: (k, channels) complex
    sums of white readings times exp(−i·order·angle), one variance each row; 0 where not used.
    weight: (channels,) one over the noise."""

    turns: float
    rows: int
    orders: np.ndarray
    weight: np.ndarray


@dataclass(frozen=True)
class Orders:
    """step: orders from one row of `orders` to the next. range: turns that the angle covers.

    origin: the angle, in turns, that is counted from.
    """

    speeds: tuple[AtSpeed, ...]
    step: float
    range: float
    origin: float

    @property
    def middle(self) -> float:
        """About which clicks a turn and the place of a click do not depend on each other, turns."""
        return self.origin + self.range / 2


def orders_of(
    t: np.ndarray, angle: np.ndarray, speed: np.ndarray, white: np.ndarray, weight: np.ndarray
) -> Orders | None:
    """Orders of white readings (n, k), 0: not known, against angle (n,) rad at speed (n,) rad/s.

    None where the axis does not turn enough to tell.
    """
    turns = angle / (2 * np.pi)
    usable = np.isfinite(turns) & (np.abs(speed) > SLOWEST) & white.any(axis=1)
    if not usable.any():
        return None
    origin = float(turns[usable].min())
    turns = turns - origin
    usable &= turns < MOST_TURNS
    classes = _classes(speed, usable, float(np.median(np.diff(t))))
    if not classes:
        return None
    covered = float(turns[usable].max())
    size = next_fast_len(int(2 * covered * PER_TURN) + 2, real=True)
    cell = np.where(usable, turns * PER_TURN, 0).astype(int)
    rate = 1 / float(np.median(np.diff(t)))
    speeds = tuple(
        _at_speed(white[rows], weight[rows], cell[rows], mean / (2 * np.pi), size, covered, rate)
        for mean, rows in classes
    )
    return Orders(speeds, PER_TURN / size, covered, origin)


def _classes(
    speed: np.ndarray, usable: np.ndarray, interval: float
) -> list[tuple[float, np.ndarray]]:
    """Speeds with their sign that are held for some turns, most turns first, and their rows."""
    kind = np.round(np.log(np.where(usable, np.abs(speed), 1.0)) / (3 * EVEN)).astype(int)
    kind = np.where(speed > 0, 1, -1) * (kind - int(kind.min()) + 1)
    found = []
    for each in np.unique(kind[usable]):
        rows = np.flatnonzero(usable & (kind == each))
        mean = float(np.median(speed[rows]))
        rows = rows[np.abs(speed[rows] - mean) < EVEN * abs(mean)]
        if len(rows) * interval * abs(mean) / (2 * np.pi) >= LEAST_TURNS:
            found.append((mean, rows))
    found.sort(key=lambda pair: -abs(pair[0]) * len(pair[1]))
    return found[:MOST_CLASSES]


def _at_speed(
    white: np.ndarray, weight: np.ndarray, cell: np.ndarray, turns: float, size: int,
    covered: float, rate: float,
) -> AtSpeed:  # fmt: skip
    step = PER_TURN / size
    order = np.arange(size // 2 + 1) * step
    hertz = order * abs(turns)
    used = (hertz > BAND[0]) & (hertz < BAND[1] * rate)
    used &= np.abs(order - np.round(order)) > INTEGER / covered
    last = int(np.flatnonzero(used).max(initial=0)) + 1
    orders = np.zeros((last, white.shape[1]), complex)
    for k, channel in enumerate(white.T):
        counted = np.bincount(cell, channel - channel.mean(), size)
        heard = rfft(counted, size)[:last]
        level = _level(np.abs(heard) ** 2 / len(channel))
        orders[:, k] = np.where(used[:last], heard / np.sqrt(np.maximum(level, 1.0)), 0.0)
    return AtSpeed(turns, len(cell), orders, weight.mean(axis=0))


def _level(power: np.ndarray) -> np.ndarray:
    stretches = len(power) // LEVEL
    if stretches == 0:
        return np.ones(len(power))
    level = np.median(power[: stretches * LEVEL].reshape(stretches, LEVEL), axis=1)
    middle = (np.arange(stretches) + 0.5) * LEVEL
    return np.asarray(np.interp(np.arange(len(power)), middle, level) / np.log(2))
