"""Order analysis: readings against the angle of a table's axis, in cycles a turn.

While the axis turns evenly, each reading is counted where the axis then stands. A Fourier
transform over the angle gives its orders (cycles a turn), for each speed by itself: an impact
lasts the same time, not the same angle, at every speed.
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len, rfft

from tasks.explain.events.residual import Residual
from tasks.explain.events.spectrum import noise_level

CELLS_PER_TURN = 512  # of the angle
MIN_SPEED = 0.3  # rad/s
EVEN = 0.01  # of the speed that it may be off its class
MIN_TURNS = 4.0  # in which an order is resolved
MAX_TURNS = 1000.0  # that an angle is followed for
MAX_SPEEDS = 8
INTEGER = 2.0  # bins of the order about a whole number: what the table itself does
BAND = (0.5, 0.45)  # Hz; of the sample rate


@dataclass(frozen=True)
class OrdersAtSpeed:
    """One speed. turns: of it a second, with sign. rows: how many. orders: (k, channels) complex
    sums of white readings times exp(−i·order·angle), one variance each row; 0 where not used.
    weight: (channels,) one over the noise."""

    turns: float
    rows: int
    orders: np.ndarray
    weight: np.ndarray


@dataclass(frozen=True)
class OrderSpectrum:
    """step: orders from one row of `orders` to the next. range: turns that the angle covers.

    origin: the angle, in turns, that is counted from.
    """

    speeds: tuple[OrdersAtSpeed, ...]
    step: float
    range: float
    origin: float

    @property
    def middle(self) -> float:
        """About which number a turn and place of an impact do not depend on each other, turns."""
        return self.origin + self.range / 2


def order_spectrum(
    residual: Residual, angle: np.ndarray, speed: np.ndarray, channels: tuple[int, ...]
) -> OrderSpectrum | None:
    """Orders of the whitened channels against an angle (n,) rad at a speed (n,) rad/s.

    None where the axis does not turn enough.
    """
    white, weight = (each[:, channels] for each in (residual.white, residual.weight))
    turns = angle / (2 * np.pi)
    usable = np.isfinite(turns) & (np.abs(speed) > MIN_SPEED) & white.any(axis=1)
    if not usable.any():
        return None
    origin = float(turns[usable].min())
    turns = turns - origin
    usable &= turns < MAX_TURNS
    classes = _speed_classes(speed, usable, residual.interval)
    if not classes:
        return None
    covered = float(turns[usable].max())
    size = next_fast_len(int(2 * covered * CELLS_PER_TURN) + 2, real=True)
    cell = np.where(usable, turns * CELLS_PER_TURN, 0).astype(int)
    order = np.arange(size // 2 + 1) * (CELLS_PER_TURN / size)
    fractional = np.abs(order - np.round(order)) > INTEGER / covered
    speeds = []
    for mean, rows in classes:
        hertz = order * abs(mean) / (2 * np.pi)
        used = (hertz > BAND[0]) & (hertz < BAND[1] / residual.interval) & fractional
        orders = _orders(white[rows], cell[rows], size, used)
        speeds.append(
            OrdersAtSpeed(mean / (2 * np.pi), len(rows), orders, weight[rows].mean(axis=0))
        )
    return OrderSpectrum(tuple(speeds), CELLS_PER_TURN / size, covered, origin)


def _speed_classes(
    speed: np.ndarray, usable: np.ndarray, interval: float
) -> list[tuple[float, np.ndarray]]:
    """Speeds with their sign that are held for some turns, most turns first, and their rows."""
    label = np.round(np.log(np.where(usable, np.abs(speed), 1.0)) / (3 * EVEN)).astype(int)
    label = np.where(speed > 0, 1, -1) * (label - int(label.min()) + 1)
    classes = []
    for number in np.unique(label[usable]):
        rows = np.flatnonzero(usable & (label == number))
        mean = float(np.median(speed[rows]))
        rows = rows[np.abs(speed[rows] - mean) < EVEN * abs(mean)]
        if len(rows) * interval * abs(mean) / (2 * np.pi) >= MIN_TURNS:
            classes.append((mean, rows))
    classes.sort(key=lambda pair: -abs(pair[0]) * len(pair[1]))
    return classes[:MAX_SPEEDS]


def _orders(white: np.ndarray, cell: np.ndarray, size: int, used: np.ndarray) -> np.ndarray:
    """Orders (k, channels) of white readings counted in cells of the angle, over their noise."""
    last = int(np.flatnonzero(used).max(initial=0)) + 1
    orders = np.zeros((last, white.shape[1]), complex)
    for k, channel in enumerate(white.T):
        transform = rfft(np.bincount(cell, channel - channel.mean(), size), size)[:last]
        level = np.maximum(noise_level(np.abs(transform) ** 2 / len(channel)), 1.0)
        orders[:, k] = np.where(used[:last], transform / np.sqrt(level), 0.0)
    return orders
