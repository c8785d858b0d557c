"""Which click, so many times a turn, the orders of the readings tell of.

First the power at all multiples of a number of clicks a turn, over all speeds; then, for the most
promising, what is in phase: the mean reading at each age of a click, for each place of it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from tasks.explain.events.orders import Orders

FEWEST, MOST = 1.5, 40.0  # clicks a turn
PROMISING = 300
PLACES = 128  # of the click within its own cycle
AGES = np.array([0.0, 0.01, 0.02, 0.04])  # s, of a click
TRIED = 32  # places that are told apart


@dataclass(frozen=True)
class Comb:
    """per_turn: clicks. place: where in its cycle, counted from zero angle. p_value: corrected."""

    per_turn: float
    place: float
    gain: float
    p_value: float


def find_comb(orders: Orders) -> Comb | None:
    """The comb of highest gain, sure or not; None where nothing can be told."""
    fastest = max(abs(each.turns) for each in orders.speeds)
    top = max(len(each.orders) * orders.step for each in orders.speeds
              if abs(each.turns) > 0.99 * fastest)  # fmt: skip
    if top < 2 * FEWEST:
        return None
    most = min(MOST, top)  # what comes oftener has no harmonic within the band
    count = int(np.ceil(2 * top * orders.range * np.log(most / FEWEST)))
    per_turn = np.geomspace(FEWEST, most, count)
    promise = _promise(orders, per_turn, top)
    best = np.argsort(promise)[::-1][:PROMISING]
    tried = count * TRIED
    combs = [_in_phase(orders, float(per_turn[k]), top, tried) for k in best]
    return max(combs, key=lambda comb: comb.gain)


def _promise(orders: Orders, per_turn: np.ndarray, top: float) -> np.ndarray:
    """Power (m,) at the multiples of each number of clicks, in its own standard deviations.

    Clicks are as many as turns: their power grows with the speed squared.
    """
    total, variance = np.zeros(len(per_turn)), np.full(len(per_turn), 1e-30)
    for each in orders.speeds:
        power = (np.abs(each.orders) ** 2).sum(axis=1) / each.rows
        used: np.ndarray = np.asarray(each.orders.any(axis=1))
        excess = np.where(used, power - each.orders.shape[1], 0.0)
        weight = each.rows * each.turns**2
        for k in range(1, int(top / FEWEST) + 1):
            reach = int(np.searchsorted(per_turn, top / k))
            cell = np.round(k * per_turn[:reach] / orders.step).astype(int)
            cell = cell[: np.searchsorted(cell, len(power))]
            total[: len(cell)] += weight * excess[cell]
            variance[: len(cell)] += weight**2 * used[cell] * each.orders.shape[1]
    return np.asarray(total / np.sqrt(variance))


def _in_phase(orders: Orders, per_turn: float, top: float, tried: int) -> Comb:
    """The best place of a click, by what the mean reading at each of its ages gains."""
    harmonics = np.arange(1, int(top / per_turn) + 1)
    cells = np.round(harmonics * per_turn / orders.step).astype(int)
    channels = orders.speeds[0].orders.shape[1]
    ages = len(AGES) - 1
    sums = np.zeros((ages, channels, len(harmonics)), complex)
    normal = np.zeros((channels, ages, ages))
    for each in orders.speeds:
        inside = cells < len(each.orders)
        heard = np.zeros((len(harmonics), channels), complex)
        heard[inside] = each.orders[cells[inside]]
        used = heard.any(axis=1)
        # Fourier coefficients of "at this age"; backwards the age runs against the angle.
        phase = 2j * np.pi * harmonics * per_turn * each.turns * AGES[:, None]
        course = np.diff(np.exp(-phase), axis=0) / (-2j * np.pi * harmonics)
        course *= np.sign(each.turns)
        course = np.where(used, course, 0.0)
        sums += course[:, None, :] * (heard.conj() * each.weight).T[None]
        gram = 2 * each.rows * (course @ course.conj().T).real
        normal += each.weight[:, None, None] ** 2 * gram
    place = np.arange(PLACES) / PLACES
    turned = np.exp(-2j * np.pi * harmonics[:, None] * place)
    told = 2 * (sums.reshape(-1, len(harmonics)) @ turned).real.reshape(ages, channels, PLACES)
    inverse = np.linalg.pinv(normal, hermitian=True)
    gain = np.einsum("acp,cab,bcp->p", told, inverse, told)
    best = int(gain.argmax())
    from_zero = float((place[best] + orders.origin * per_turn) % 1.0)
    p_value = min(1.0, tried * float(chi2.sf(gain[best], ages * channels)))
    return Comb(per_turn, from_zero, float(gain[best]), p_value)
