"""Impacts that recur at a multiple of the outer table axis' rotation, as from a damaged bearing."""

from itertools import product

import numpy as np
from scipy.optimize import minimize

from schemas.discrepancy import FoundParameter
from tasks.explain.channels import ACCELS, GYROS
from tasks.explain.events.event import AddedSignal, channel_names
from tasks.explain.events.orders import Comb, OrderSpectrum, find_comb, order_spectrum
from tasks.explain.events.residual import Residual
from tasks.explain.events.ringing import LIFETIME, Aligned, Ringing, log_bounds
from tasks.words import message

FALSE_ALARM = 1e-4
MIN_SPEED = 0.02  # rad/s; slower, an angle's noise may pass a place by itself
LONGEST = 0.06  # s of an impact
EARLY = -0.01  # s before an impact that are looked at, for it may come earlier
AGE_BINS = 10  # by which a place is judged without a shape
FREQUENCIES = np.geomspace(2.0, 40.0, 12)  # Hz
DECAYS = np.geomspace(0.003, 0.05, 6)  # s
HALVINGS = 4  # of the steps of per_turn and place


def find_impacts(residual: Residual) -> AddedSignal | None:
    """Impacts in the residual of the accelerometers."""
    axes, t = residual.motion.axes, residual.t
    if axes is None or len(t) < 2:
        return None
    residual = residual.without_channels(GYROS)
    angle, speed = axes.angles[:, 0], axes.speeds[:, 0]
    orders = order_spectrum(residual, angle, speed, ACCELS)
    comb = find_comb(orders) if orders is not None else None
    if orders is None or comb is None or comb.p_value > FALSE_ALARM:
        return None
    turns = np.where(np.abs(speed) > MIN_SPEED, angle / (2 * np.pi), np.nan)
    per_turn, place = _refined_comb(residual, turns, orders, comb)
    per_turn, fit = _fit(residual, turns, orders.middle, per_turn, place)
    u = 1 / (orders.range * per_turn * np.sqrt(comb.gain))
    return fit.event(
        FoundParameter(name="per_turn", value=per_turn, unit="1", u=u),
        float(1 / np.sqrt(fit.gain.sum())), comb.p_value,
        message("events-impacts", per_turn=f"{per_turn:.2f}", channels=channel_names(fit.channels)),
    )  # fmt: skip


def crossings(t: np.ndarray, turns: np.ndarray, per_turn: float, place: float) -> np.ndarray:
    """Times (m,) s at which an angle (n,) in turns, NaN: at rest, passes a place in its cycles."""
    cycle = turns * per_turn - place
    number = np.floor(cycle)
    before = np.flatnonzero(np.abs(np.diff(number)) > 0)
    edge = np.maximum(number[before], number[before + 1])
    share = (edge - cycle[before]) / (cycle[before + 1] - cycle[before])
    return np.asarray(t[before] + share * (t[before + 1] - t[before]))


def _refined_comb(
    residual: Residual, turns: np.ndarray, orders: OrderSpectrum, comb: Comb
) -> tuple[float, float]:
    """Impacts a turn and their place, from all rows in rotation, by a shrinking pattern search."""

    def gain(per_turn: float, place: float) -> float:
        starts = crossings(residual.t, turns, per_turn, place)
        part = Aligned.after(starts, residual, LONGEST)
        # Bins grow with the age: an impact is sharp at first.
        cell = (np.sqrt(part.age / LONGEST) * AGE_BINS).astype(int)
        total = 0.0
        for channel in ACCELS:
            squares = part.weight[:, channel] ** 2
            weighted = np.bincount(cell, part.values[:, channel] * squares, AGE_BINS)
            information = np.bincount(cell, squares, AGE_BINS)
            total += float((weighted**2 / np.maximum(information, 1e-30)).sum())
        return total

    best = (gain(comb.per_turn, comb.place), comb.per_turn, comb.place)
    steps = np.array([0.3 / orders.range, 0.02])
    for _ in range(HALVINGS):
        _, per_turn, place = best
        for more, later in product((-1, 0, 1), repeat=2):
            number = per_turn + more * steps[0]
            at = place + (number - per_turn) * orders.middle + later * steps[1]
            best = max(best, (gain(number, at), number, at))
        steps = steps / 2
    return best[1], best[2] % 1.0


def _fit(
    residual: Residual, turns: np.ndarray, middle: float, per_turn: float, place: float
) -> tuple[float, Ringing]:
    """Impacts a turn, and the oscillations, that together gain most."""
    t, starts = residual.t, crossings(residual.t, turns, per_turn, place)
    part = Aligned.after(starts + EARLY, residual, LONGEST - EARLY)
    age = part.age + EARLY
    at = np.searchsorted(t, starts) - 1
    cycles_a_second = per_turn * (turns[at + 1] - turns[at]) / (t[at + 1] - t[at])
    period = (1 / cycles_a_second)[part.start]
    lead = ((turns[at] - middle) / cycles_a_second)[part.start]

    def cost(tried: np.ndarray) -> float:
        # A place further on is passed later; more impacts a turn come the earlier, the further.
        later, more = tried[:2] * scale
        return part.aged(age - later * period + more * lead).cost(tried[2:])

    scale = np.array([0.01, 0.01 / max(float(np.ptp(turns[at])), 1.0)])
    shape = part.aged(age).shape(FREQUENCIES, DECAYS)
    first = np.concatenate([[0.0, 0.0], np.log(shape)])
    simplex = np.vstack([first, first + 0.3 * np.eye(4)])
    best = minimize(cost, first, method="Nelder-Mead",
                    bounds=[(-10.0, 10.0)] * 2 + log_bounds(FREQUENCIES, DECAYS),
                    options={"initial_simplex": simplex, "xatol": 1e-3, "fatol": 0.1,
                             "maxiter": 250}).x  # fmt: skip
    later, more = best[:2] * scale
    frequency, decay = map(float, np.exp(best[2:]))
    starts = crossings(t, turns, per_turn + more, (place + later + more * middle) % 1.0)
    gained = Aligned.after(starts, residual, LIFETIME * decay).amplitude(frequency, decay)
    return per_turn + more, Ringing(starts, *gained, frequency, decay)
