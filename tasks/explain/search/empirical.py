"""An empirical basis for residuals that no catalogued physics fits.

Each is a term named `unnamed` whose title describes its regressors: relaxations after moves, lags,
harmonics of the table's angle, products and powers, sinusoids, and everything recorded.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from types import MappingProxyType

import numpy as np

from tasks.explain.channels import ACCELS, EVERY, GYROS
from tasks.explain.search.empirical_terms import (
    Regressors,
    leans,
    lost_motion,
    per,
    regression_term,
    sinusoid,
    tips,
)
from tasks.model.term import Inputs, Term
from tasks.motion.lag import first_order_lag
from tasks.motion.whole import Motion
from tasks.words import message

ONE_TURN = 2.0 * np.pi  # rad: an axis that turned further has harmonics
RELAXATIONS = (1.5, 4.0, 8.0, 16.0, 40.0)  # s
LAGS = (3.0, 7.0, 18.0, 45.0, 120.0)  # s
HARMONICS = range(1, 7)
SINUSOIDS = 2  # periods that are tried for each set of channels
RECORDED = {"humidity": "%", "pressure": "hPa", "air_temperature": "K"}  # with their units
RATE, RATE_2, TURNING, FORCE, FORCE_2 = "rad/s", "(rad/s)^2", "rad/s^2", "m/s2", "(m/s2)^2"
Signal = Callable[[Motion, Inputs, int], np.ndarray]
LeftOut = Mapping[str, tuple[int, ...]]
NOTHING: LeftOut = MappingProxyType({})
TURNING_UP = 0.02  # of a unit vector in a second: gravity's direction changes
AT_REST = 1e-3  # rad/s: slower is not a motion
MAX_MOVE = 20.0  # s; what turns longer is a run


def time_since(motion: Motion, events: np.ndarray) -> np.ndarray:
    """(n,) s since the last event (n,) bool was over; infinite before the first."""
    rows = np.flatnonzero(np.diff(events.astype(int)) == -1) + 1
    if not len(rows):
        return np.full(len(motion.t), np.inf)
    last = np.searchsorted(rows, np.arange(len(motion.t)), "right") - 1
    elapsed = motion.t - motion.t[rows[np.maximum(last, 0)]]
    return np.where(last >= 0, elapsed, np.inf)


def gravity_turns(motion: Motion) -> np.ndarray:
    """(n,) bool: gravity's direction in the unit changes. A turn about a level axis is one move."""
    up = np.nan_to_num(motion.up)
    speed = np.linalg.norm(np.gradient(up, motion.interval, axis=0), axis=1)
    return np.asarray(speed > TURNING_UP)


def turning(motion: Motion) -> np.ndarray:
    """(n,) bool: the unit turns, in whatever way."""
    return np.asarray(np.linalg.norm(np.nan_to_num(motion.rate), axis=1) > AT_REST)


def repositioning(motion: Motion) -> np.ndarray:
    """(n,) bool: the unit turns from one rest to another, without a steady turn between."""
    moving = turning(motion)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], moving.astype(int), [0]])))
    steady = motion.recorded.get("steady_turn", np.zeros(len(moving)))
    found = moving.copy()
    for start, stop in edges.reshape(-1, 2):
        if steady[start:stop].any() or motion.t[stop - 1] - motion.t[start] > MAX_MOVE:
            found[start:stop] = False
    return found


def lagged(signal: np.ndarray, t: np.ndarray, tau: float) -> np.ndarray:
    """First-order lag of a signal (n,), from rest."""
    return first_order_lag(np.nan_to_num(signal), float(np.median(np.diff(t))), tau)


EVENTS = {
    "each move to another position": ("reposition", repositioning),
    "each turn of gravity's direction": ("gravity-turn", gravity_turns),
    "each stop": ("stop", turning),
}


def empirical(motion: Motion, left_out: LeftOut = NOTHING) -> tuple[Term, ...]:
    """Every empirical term that a recording could need.

    left_out: what is followed by readings of some channels that are not to follow it.
    """
    return (
        *_relaxations(), *_lags(left_out), *_products(left_out), *_recorded(motion, left_out),
        *_sinusoids(), *_of_table(motion), *tips(),
    )  # fmt: skip


def _relaxations() -> Iterator[Term]:
    for event, (name, detect) in EVENTS.items():
        for tau in RELAXATIONS:
            title = message(
                "explain-relaxation", event=message(f"explain-event-{name}"), tau=f"{tau:g}"
            )
            decay = partial(_decay, detect, tau)
            yield regression_term(f"exp(−t/{tau:g} s) after {event}", title, EVERY, 1, decay, True)


def _decay(
    detect: Callable[[Motion], np.ndarray], tau: float, motion: Motion, inputs: Inputs, channel: int
) -> list[np.ndarray]:
    return [np.exp(-time_since(motion, detect(motion)) / tau)]


def _lags(left_out: LeftOut) -> Iterator[Term]:
    signals: list[tuple[str, str, str, tuple[int, ...], bool, Signal]] = [
        ("ω", "own-rate", RATE, GYROS, False, lambda m, u, c: u.rate[:, c]),
        ("ω²", "squared-rate", RATE_2, EVERY, True, lambda m, u, c: (u.rate**2).sum(axis=1)),
        ("|ω|", "rate-size", RATE, EVERY, True, lambda m, u, c: np.sqrt((u.rate**2).sum(axis=1))),
        ("f", "own-force", FORCE, EVERY, False, lambda m, u, c: u.force[:, c % 3]),
        ("|f|", "own-force-size", FORCE, ACCELS, False, lambda m, u, c: np.abs(u.force[:, c % 3])),
    ]
    for key, name, unit, every, shared, signal in signals:
        channels = _remaining(every, f"lag({key})", left_out)
        for tau in LAGS if channels else ():
            title = message("explain-lag", signal=message(f"explain-signal-{name}"), tau=f"{tau:g}")
            lag = partial(_lag, signal, tau)
            form = f"lag({key}, {tau:g} s)"
            yield regression_term(form, title, channels, 1, lag, shared, per(unit))


def _lag(
    signal: Signal, tau: float, motion: Motion, inputs: Inputs, channel: int
) -> list[np.ndarray]:
    return [lagged(signal(motion, inputs, channel), motion.t, tau)]


def _others(channel: int) -> tuple[int, int]:
    axis = channel % 3
    return (axis + 1) % 3, (axis + 2) % 3


def _products(left_out: LeftOut) -> Iterator[Term]:
    products: list[tuple[str, str, str, tuple[int, ...], int, Regressors]] = [
        ("ω_j·ω_k", "other-rates", RATE_2, EVERY, 1,
         lambda m, u, c: [u.rate[:, _others(c)[0]] * u.rate[:, _others(c)[1]]]),
        ("ω_i·ω_j", "own-rate", RATE_2, EVERY, 2,
         lambda m, u, c: [u.rate[:, c % 3] * u.rate[:, j] for j in _others(c)]),
        ("f_j·f_k", "other-forces", FORCE_2, EVERY, 1,
         lambda m, u, c: [u.force[:, _others(c)[0]] * u.force[:, _others(c)[1]]]),
        ("f_i·f_j", "own-force", FORCE_2, EVERY, 2,
         lambda m, u, c: [u.force[:, c % 3] * u.force[:, j] for j in _others(c)]),
        ("f_j²", "squared-other-forces", FORCE_2, ACCELS, 2,
         lambda m, u, c: [u.force[:, j] ** 2 for j in _others(c)]),
        ("ω_j²", "squared-other-rates", RATE_2, GYROS, 2,
         lambda m, u, c: [u.rate[:, j] ** 2 for j in _others(c)]),
        ("ω_i²", "squared-own-rate", RATE_2, ACCELS, 1,
         lambda m, u, c: [u.rate[:, c % 3] ** 2]),
        ("ω", "rates", RATE, ACCELS, 3, lambda m, u, c: list(u.rate.T)),
        ("|ω_j|", "other-rate-sizes", RATE, EVERY, 2,
         lambda m, u, c: [np.abs(u.rate[:, j]) for j in _others(c)]),
        ("ω⁴", "fourth-power", "(rad/s)^4", EVERY, 1,
         lambda m, u, c: [(u.rate**2).sum(axis=1) ** 2]),
        ("ω̇", "angular-acceleration", TURNING, ACCELS, 3,
         lambda m, u, c: list(m.acceleration.T)),
        ("|ω̇|", "angular-acceleration-size", TURNING, EVERY, 1,
         lambda m, u, c: [np.sqrt((m.acceleration**2).sum(axis=1))]),
    ]  # fmt: skip
    for key, name, unit, every, number, regressors in products:
        channels = _remaining(every, key, left_out)
        title = message(f"explain-product-{name}")
        if channels:
            yield regression_term(key, title, channels, number, regressors, units=per(unit))


def _remaining(every: tuple[int, ...], key: str, left_out: LeftOut) -> tuple[int, ...]:
    return tuple(c for c in every if c not in left_out.get(key, ()))


def _recorded(motion: Motion, left_out: LeftOut) -> Iterator[Term]:
    for key in RECORDED:
        signal = motion.recorded.get(key)
        if signal is None or np.nanstd(signal) < 1e-9:
            continue
        recorded = message(f"explain-recorded-{key.replace('_', '-')}")
        title = message("explain-follows", signal=recorded)
        follows = partial(_deviation, key)
        channels = _remaining(EVERY, key, left_out)
        if channels:
            yield regression_term(key, title, channels, 1, follows, True, per(RECORDED[key]))
        product = message("explain-recorded-times-input", signal=recorded)
        title = message("explain-follows", signal=product)
        scaled, unit = partial(_scaled_input, key), f"1/{RECORDED[key]}"
        yield regression_term(f"{key}·input", title, EVERY, 1, scaled, units=(unit, unit))


def _deviation(key: str, motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    return [motion.recorded[key] - np.nanmean(motion.recorded[key])]


def _scaled_input(key: str, motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    own = (inputs.rate if channel < 3 else inputs.force)[:, channel % 3]
    return [_deviation(key, motion, inputs, channel)[0] * own]


def _sinusoids() -> Iterator[Term]:
    for channels in (EVERY, GYROS, ACCELS):
        for _ in range(SINUSOIDS):
            yield sinusoid(channels)


def _of_table(motion: Motion) -> Iterator[Term]:
    if motion.axes is None:
        return
    for axis, (angle, speed) in enumerate(
        zip(motion.axes.angles.T, motion.axes.speeds.T, strict=True)
    ):
        if np.nanmin(speed, initial=0.0) < 0.0 < np.nanmax(speed, initial=0.0):
            yield lost_motion(axis)
        if np.isfinite(angle).any() and np.nanmax(angle) - np.nanmin(angle) >= ONE_TURN:
            yield from _harmonics(axis)
            yield from leans(axis)


def _harmonics(axis: int) -> Iterator[Term]:
    for order in HARMONICS:
        title = message("explain-harmonic", axis=axis + 1, order=order)
        harmonic = partial(_harmonic, axis, order)
        yield regression_term(f"cos {order}θ{axis + 1}", title, EVERY, 2, harmonic, True)


def _harmonic(
    axis: int, order: int, motion: Motion, inputs: Inputs, channel: int
) -> list[np.ndarray]:
    assert motion.axes is not None
    angle = order * motion.axes.angles[:, axis]
    return [np.sin(angle), np.cos(angle)]
