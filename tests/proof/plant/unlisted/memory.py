"""Hysteresis: what a reading owes to a motion that is over, sample by sample."""

from collections.abc import Callable

import numpy as np

from tests.proof.plant.unlisted.law import (
    ACCELEROMETERS,
    GYROS,
    Law,
    shares_of_force,
    shares_of_rate,
)
from tests.proof.plant.world import World

FAST = 0.6  # of the largest rate
STILL = 1e-4  # of the largest rate: slower is no motion
EVERY = 5  # of the fine grid's points one is computed, where a law has to go through them all


def _step_by_step(inputs: np.ndarray, begins: float, step: Callable[..., float]) -> np.ndarray:
    """States (3, n) that each go through their inputs (3, n): step(state, input, change)."""
    found = np.empty_like(inputs)
    for axis, course in enumerate(inputs):
        coarse = course[::EVERY].tolist()
        state, before = begins, coarse[0]
        states = []
        for now in coarse:
            state = step(state, now, now - before)
            before = now
            states.append(state)
        found[axis] = np.repeat(states, EVERY)[: len(course)]
    return found


def _last_fast_spin(world: World) -> np.ndarray:
    """The sign of the last spin that was fast, whatever came after it."""
    return _step_by_step(
        shares_of_rate(world), 0.0,
        lambda state, rate, _: float(np.sign(rate)) if abs(rate) > FAST else state,
    )  # fmt: skip


def _angle(world: World) -> np.ndarray:
    return np.asarray(np.cumsum(world.motion.rates, axis=1) * world.motion.step)


def _dead_band(world: World) -> np.ndarray:
    """−1 or 1 at either side of a gap of 0.5 rad, 0 within it: a contact that a turn carries."""
    gap, flank = 0.25, 0.02

    def carried(state: float, _: float, change: float) -> float:
        return float(min(max(state + change, -gap - flank), gap + flank))

    place = _step_by_step(_angle(world), 0.0, carried)
    return np.where(np.abs(place) > gap, np.sign(place), 0.0)


def _relays_of_force(world: World) -> np.ndarray:
    """Nine relays of the own specific force, their thresholds not about its middle."""
    force, total = shares_of_force(world), np.zeros((3, len(world.t)))
    for k in range(9):
        up, down = 0.05 + 0.09 * k, -0.75 + 0.07 * k

        def relay(state: float, now: float, _: float, up: float = up, down: float = down) -> float:
            return 1.0 if now > up else -1.0 if now < down else state

        total += _step_by_step(force, -1.0, relay) / 9.0
    return total


def _bouc_wen(world: World) -> np.ndarray:
    """ż = u̇·(1 − |z|ⁿ·(β·sign(u̇·z) + γ)), u: angle turned in 0.4 rad."""
    n, beta, gamma = 1.6, 0.7, 0.3

    def step(state: float, _: float, change: float) -> float:
        u = change / 0.4
        held = abs(state) ** n * (beta * np.sign(u * state) + gamma)
        return float(np.clip(state + u * (1.0 - held), -1.0, 1.0))

    return _step_by_step(_angle(world), 0.0, step)


def _creeping_backlash(world: World) -> np.ndarray:
    """What is left of a spring with friction (0.15 of the largest rate) that creeps back: 90 s."""
    pace = EVERY * world.motion.step / 90.0

    def step(state: float, _: float, change: float) -> float:
        return float(np.clip(state * (1.0 - pace) + change, -0.15, 0.15))

    return _step_by_step(shares_of_rate(world), 0.0, step)


def _jiles_atherton(world: World) -> np.ndarray:
    """dM/dH = (M_an − M)/k in the way of H, M_an = coth(H/a) − a/H, H: own specific force."""
    a, k = 0.3, 0.35

    def step(state: float, now: float, change: float) -> float:
        x = now / a
        goal = x / 3.0 if abs(x) < 1e-3 else 1.0 / np.tanh(x) - 1.0 / x
        away = goal - state
        return float(state + (abs(change) / k * away if away * change > 0.0 else 0.0))

    return _step_by_step(shares_of_force(world), 0.0, step)


def _remanence(world: World) -> np.ndarray:
    """What the fastest of the last spin leaves of itself at rest: its root, with its sign."""

    def step(state: float, rate: float, change: float) -> float:
        if abs(rate) < STILL:
            return state
        new = float(np.sign(rate) * np.sqrt(abs(rate)))
        return new if new * state <= 0.0 or abs(new) > abs(state) else state

    return _step_by_step(shares_of_rate(world), 0.0, step)


LAWS = (
    Law("last_fast_spin", "hysteresis", GYROS, _last_fast_spin),
    Law("dead_band", "hysteresis", GYROS, _dead_band),
    Law("relays_of_force", "hysteresis", ACCELEROMETERS, _relays_of_force),
    Law("bouc_wen", "hysteresis", GYROS, _bouc_wen),
    Law("creeping_backlash", "hysteresis", GYROS, _creeping_backlash),
    Law("jiles_atherton", "hysteresis", ACCELEROMETERS, _jiles_atherton),
    Law("remanence", "hysteresis", GYROS, _remanence),
)
