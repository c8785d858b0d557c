"""Clicks that recur so many times a turn of the table's outer axis, as a damaged bearing's do."""

from itertools import product

import numpy as np
from scipy.optimize import minimize

from schemas.discrepancy import FoundParameter
from tasks.explain.channels import ACCELS, GYROS
from tasks.explain.events.comb import Comb, find_comb
from tasks.explain.events.event import UNITS, named
from tasks.explain.events.orders import Orders, orders_of
from tasks.explain.events.ringing import OVER, Ringing, bounds_of, fitted_waves, shape_of
from tasks.model.term import Text
from tasks.motion.whole import Motion

FALSE_ALARM = 1e-4
TURNS = 0.02  # rad/s; slower, an angle's noise may pass a place by itself
LONGEST = 0.06  # s of a click
EARLY = -0.01  # s before a click that are looked at, for it may come earlier
BINS = 10  # of its age, that tell the best place without a shape
FREQUENCIES = np.geomspace(2.0, 40.0, 12)  # Hz
DECAYS = np.geomspace(0.003, 0.05, 6)  # s
SHRINKS = 4  # times that the steps of per_turn and place are halved
SEEN = 4.0  # standard uncertainties from which a channel has the clicks


def find_clicks(
    t: np.ndarray, residual: np.ndarray, noise: np.ndarray, motion: Motion
) -> Ringing | None:
    """Clicks in what a fit leaves of the accelerometers (n, 6), NaN: not known.

    noise: (n, 6), its level at each row.
    """
    if motion.axes is None or len(t) < 2:
        return None
    known = np.isfinite(residual) & (noise > 0)
    weight = np.divide(1.0, noise, out=np.zeros(noise.shape), where=known)
    left = np.where(known, residual, 0.0)
    angle, speed = motion.axes.angles[:, 0], motion.axes.speeds[:, 0]
    white = (left * weight)[:, ACCELS]
    orders = orders_of(t, angle, speed, white, weight[:, ACCELS])
    comb = find_comb(orders) if orders is not None else None
    if orders is None or comb is None or comb.p_value > FALSE_ALARM:
        return None
    turns = np.where(np.abs(speed) > TURNS, angle / (2 * np.pi), np.nan)
    weight[:, GYROS] = 0.0
    per_turn, place = _placed(t, turns, left, weight, orders, comb)
    per_turn, place, frequency, decay = _sharpened(
        t, turns, left, weight, orders.middle, per_turn, place
    )
    starts = passed(t, turns, per_turn, place)
    rows, age = _young(t, starts, OVER * decay)
    wave, gain = fitted_waves(age, left[rows], weight[rows], frequency, decay)
    channels = tuple(int(c) for c in np.flatnonzero(gain > SEEN**2)) or (int(gain.argmax()),)
    wave = np.where(np.isin(np.arange(6), channels), wave, 0.0)
    u = 1 / (orders.range * per_turn * np.sqrt(comb.gain))
    parameters = _parameters(per_turn, u, frequency, decay, wave, gain, channels)
    return Ringing(
        "unnamed", channels, parameters, comb.p_value, _said(per_turn, channels), None,
        starts, np.tile(wave, (len(starts), 1)), frequency, decay,
    )  # fmt: skip


def passed(t: np.ndarray, turns: np.ndarray, per_turn: float, place: float) -> np.ndarray:
    """Times (m,) s at which an angle (n,) in turns, NaN: at rest, passes a place in its cycles."""
    cycle = turns * per_turn - place
    number = np.floor(cycle)
    before = np.flatnonzero(np.abs(np.diff(number)) > 0)
    edge = np.maximum(number[before], number[before + 1])
    share = (edge - cycle[before]) / (cycle[before + 1] - cycle[before])
    return np.asarray(t[before] + share * (t[before + 1] - t[before]))


def _young(t: np.ndarray, starts: np.ndarray, longest: float) -> tuple[np.ndarray, np.ndarray]:
    """Rows within so long (s) after a start, and their age in s."""
    last = np.searchsorted(starts, t, side="right") - 1
    age = np.where(last >= 0, t - starts[np.maximum(last, 0)], np.inf)
    rows = np.flatnonzero(age < longest)
    return rows, age[rows]


def _placed(
    t: np.ndarray,
    turns: np.ndarray,
    left: np.ndarray,
    weight: np.ndarray,
    orders: Orders,
    comb: Comb,
) -> tuple[float, float]:
    """Clicks a turn and their place, closely, from all rows that turn."""

    def gain(per_turn: float, place: float) -> float:
        rows, age = _young(t, passed(t, turns, per_turn, place), LONGEST)
        # Cells grow with the age: a click is sharp at first.
        cell = (np.sqrt(age / LONGEST) * BINS).astype(int)
        total = 0.0
        for channel in ACCELS:
            squares = weight[rows, channel] ** 2
            told = np.bincount(cell, left[rows, channel] * squares, BINS)
            information = np.bincount(cell, squares, BINS)
            total += float((told**2 / np.maximum(information, 1e-30)).sum())
        return total

    best = (gain(comb.per_turn, comb.place), comb.per_turn, comb.place)
    steps = np.array([0.3 / orders.range, 0.02])
    for _ in range(SHRINKS):
        _, per_turn, place = best
        for more, later in product((-1, 0, 1), repeat=2):
            one = per_turn + more * steps[0]
            at = place + (one - per_turn) * orders.middle + later * steps[1]
            best = max(best, (gain(one, at), one, at))
        steps = steps / 2
    return best[1], best[2] % 1.0


def _sharpened(
    t: np.ndarray,
    turns: np.ndarray,
    left: np.ndarray,
    weight: np.ndarray,
    middle: float,
    per_turn: float,
    place: float,
) -> tuple[float, float, float, float]:
    """Clicks a turn, place, frequency (Hz) and decay (s) that together gain most."""
    starts = passed(t, turns, per_turn, place)
    rows, age = _young(t, starts + EARLY, LONGEST - EARLY)
    age = age + EARLY
    left, weight = left[rows], weight[rows]
    which = np.searchsorted(starts + EARLY, t[rows], side="right") - 1
    at = np.searchsorted(t, starts) - 1
    cycles_a_second = per_turn * (turns[at + 1] - turns[at]) / (t[at + 1] - t[at])
    one, more = (1 / cycles_a_second)[which], ((turns[at] - middle) / cycles_a_second)[which]

    def aged(moved: np.ndarray) -> np.ndarray:
        # A place further on is passed later; more clicks a turn come the earlier, the further.
        return np.asarray(age - moved[0] * one + moved[1] * more)

    def cost(tried: np.ndarray) -> float:
        older = aged(tried[:2] * scale)
        ripe = older >= 0
        frequency, decay = np.exp(tried[2:])
        waves = fitted_waves(older[ripe], left[ripe], weight[ripe], frequency, decay)
        return -float(waves[1].sum())

    scale = np.array([0.01, 0.01 / max(float(np.ptp(turns[at])), 1.0)])
    young = age >= 0
    shape = shape_of(age[young], left[young], weight[young], FREQUENCIES, DECAYS)
    first = np.concatenate([[0.0, 0.0], np.log(shape)])
    simplex = np.vstack([first, first + 0.3 * np.eye(4)])
    best = minimize(cost, first, method="Nelder-Mead",
                    bounds=[(-10.0, 10.0)] * 2 + bounds_of(FREQUENCIES, DECAYS),
                    options={"initial_simplex": simplex, "xatol": 1e-3, "fatol": 0.1,
                             "maxiter": 250}).x  # fmt: skip
    later, more_clicks = best[:2] * scale
    moved = place + later + more_clicks * middle
    return per_turn + more_clicks, float(moved % 1.0), *map(float, np.exp(best[2:]))


def _parameters(
    per_turn: float, u: float, frequency: float, decay: float, wave: np.ndarray,
    gain: np.ndarray, channels: tuple[int, ...],
) -> tuple[FoundParameter, ...]:  # fmt: skip
    wide = decay * float(1 / np.sqrt(gain.sum()))
    found = [
        FoundParameter(name="per_turn", value=per_turn, unit="1", u=u),
        FoundParameter(name="frequency", value=frequency, unit="Hz",
                       u=wide / decay**2 / (2 * np.pi)),
        FoundParameter(name="decay", value=decay, unit="s", u=wide),
    ]  # fmt: skip
    for channel in channels:
        size = float(np.abs(wave[channel]))
        found.append(
            FoundParameter(name=f"accel_{'xyz'[channel - 3]}", value=size, unit=UNITS[1],
                           u=size / float(np.sqrt(gain[channel])))
        )  # fmt: skip
    return tuple(found)


def _said(per_turn: float, channels: tuple[int, ...]) -> Text:
    english, chinese = named(channels)
    return (
        f"clicks {per_turn:.2f} times a turn of the outer axis, in the {english}",
        f"外轴每转 {per_turn:.2f} 次的撞击，通道：{chinese}",
    )
