"""Order analysis: components that recur a whole number of times per turn of a table axis.

While the axis turns evenly, each reading is counted where the axis then stands. A Fourier
transform over the angle gives its orders (cycles a turn), for each speed by itself: an impact
lasts the same time, not the same angle, at every speed.

Impacts make a comb of orders. It is searched first by the power at all multiples of a number of
impacts a turn, over all speeds; then, for the most promising, by what is in phase: the mean
reading at each age of an impact, for each place of it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.stats import chi2

from tasks.explain.events.residual import Residual, noise_level

CELLS_PER_TURN = 512  # of the angle
MIN_SPEED = 0.3  # rad/s
EVEN = 0.01  # of the speed that it may be off its class
MIN_TURNS = 4.0  # in which an order is resolved
MAX_TURNS = 1000.0  # that an angle is followed for
MAX_SPEEDS = 8
INTEGER = 2.0  # bins of the order about a whole number: what the table itself does
BAND = (0.5, 0.45)  # Hz; of the sample rate

MIN_PER_TURN, MAX_PER_TURN = 1.5, 40.0  # impacts
MAX_CANDIDATES = 300
PLACES = 128  # of the impact within its own cycle
AGES = np.array([0.0, 0.01, 0.02, 0.04])  # s, of an impact
INDEPENDENT_PLACES = 32


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


@dataclass(frozen=True)
class Comb:
    """per_turn: impacts. place: where in its cycle, counted from zero angle. gain: chi-squared.
    p_value: corrected."""

    per_turn: float
    place: float
    gain: float
    p_value: float


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


def find_comb(orders: OrderSpectrum) -> Comb | None:
    """The comb of highest gain, significant or not; None where the orders do not reach."""
    fastest = max(abs(each.turns) for each in orders.speeds)
    top = max(len(each.orders) * orders.step for each in orders.speeds
              if abs(each.turns) > 0.99 * fastest)  # fmt: skip
    if top < 2 * MIN_PER_TURN:
        return None
    most = min(MAX_PER_TURN, top)  # what comes oftener has no harmonic within the band
    count = int(np.ceil(2 * top * orders.range * np.log(most / MIN_PER_TURN)))
    per_turn = np.geomspace(MIN_PER_TURN, most, count)
    best = np.argsort(_harmonic_power(orders, per_turn, top))[::-1][:MAX_CANDIDATES]
    tried = count * INDEPENDENT_PLACES
    combs = [_coherent_comb(orders, float(per_turn[k]), top, tried) for k in best]
    return max(combs, key=lambda comb: comb.gain)


def _harmonic_power(orders: OrderSpectrum, per_turn: np.ndarray, top: float) -> np.ndarray:
    """Power (m,) at the multiples of each number of impacts, in its own standard deviations.

    Impacts are as many as turns: their power grows with the speed squared.
    """
    total, variance = np.zeros(len(per_turn)), np.full(len(per_turn), 1e-30)
    for each in orders.speeds:
        channels = each.orders.shape[1]
        power = (np.abs(each.orders) ** 2).sum(axis=1) / each.rows
        used: np.ndarray = np.asarray(each.orders.any(axis=1))
        excess = np.where(used, power - channels, 0.0)
        weight = each.rows * each.turns**2
        for k in range(1, int(top / MIN_PER_TURN) + 1):
            reach = int(np.searchsorted(per_turn, top / k))
            cell = np.round(k * per_turn[:reach] / orders.step).astype(int)
            cell = cell[: np.searchsorted(cell, len(power))]
            total[: len(cell)] += weight * excess[cell]
            variance[: len(cell)] += weight**2 * used[cell] * channels
    return np.asarray(total / np.sqrt(variance))


def _coherent_comb(orders: OrderSpectrum, per_turn: float, top: float, tried: int) -> Comb:
    """The best place of an impact, by what the mean reading at each of its ages gains."""
    harmonics = np.arange(1, int(top / per_turn) + 1)
    cells = np.round(harmonics * per_turn / orders.step).astype(int)
    channels = orders.speeds[0].orders.shape[1]
    ages = len(AGES) - 1
    sums = np.zeros((ages, channels, len(harmonics)), complex)
    normal = np.zeros((channels, ages, ages))
    for each in orders.speeds:
        inside = cells < len(each.orders)
        measured = np.zeros((len(harmonics), channels), complex)
        measured[inside] = each.orders[cells[inside]]
        # Fourier coefficients of "at this age"; backwards the age runs against the angle.
        phase = 2j * np.pi * harmonics * per_turn * each.turns * AGES[:, None]
        expected = np.diff(np.exp(-phase), axis=0) / (-2j * np.pi * harmonics)
        expected *= np.sign(each.turns)
        expected = np.where(measured.any(axis=1), expected, 0.0)
        sums += expected[:, None, :] * (measured.conj() * each.weight).T[None]
        gram = 2 * each.rows * (expected @ expected.conj().T).real
        normal += each.weight[:, None, None] ** 2 * gram
    place = np.arange(PLACES) / PLACES
    shift = np.exp(-2j * np.pi * harmonics[:, None] * place)
    right = 2 * (sums.reshape(-1, len(harmonics)) @ shift).real.reshape(ages, channels, PLACES)
    inverse = np.linalg.pinv(normal, hermitian=True)
    gain = np.einsum("acp,cab,bcp->p", right, inverse, right)
    best = int(gain.argmax())
    from_zero = float((place[best] + orders.origin * per_turn) % 1.0)
    p_value = min(1.0, tried * float(chi2.sf(gain[best], ages * channels)))
    return Comb(per_turn, from_zero, float(gain[best]), p_value)
