"""Comb search: which impact, so many times a turn, the order spectrum holds.

First the power at all multiples of a number of impacts a turn, over all speeds; then, for the most
promising, what is in phase: the mean reading at each age of an impact, for each place of it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from tasks.explain.events.order_spectrum import OrderSpectrum

MIN_PER_TURN, MAX_PER_TURN = 1.5, 40.0  # impacts
MAX_CANDIDATES = 300
PLACES = 128  # of the impact within its own cycle
AGES = np.array([0.0, 0.01, 0.02, 0.04])  # s, of an impact
INDEPENDENT_PLACES = 32


@dataclass(frozen=True)
class Comb:
    """per_turn: impacts. place: where in its cycle, counted from zero angle. gain: chi-squared.
    p_value: corrected."""

    per_turn: float
    place: float
    gain: float
    p_value: float


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
