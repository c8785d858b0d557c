"""Kinematics: from shaft angles to what the unit feels, by composing and differencing."""

from collections.abc import Sequence
from functools import reduce
from itertools import pairwise

import numpy as np

from tests.proof.plant.effects.base import EARTH, Effect, Link
from tests.proof.plant.plan import Plan
from tests.proof.plant.rotations import about, from_vector, inverse, product, rates, turned
from tests.proof.plant.world import Motion

MARGIN = 2  # points on each side that differences use up
UP = np.array([0.0, 0.0, 1.0])


def move(
    plan: Plan,
    t: np.ndarray,
    shaft: np.ndarray,
    heading: float,
    gravity: float,
    effects: Sequence[Effect] = (),
) -> Motion:
    """The motion of the unit at all but two times at each end.

    shaft: (axes, n) rad at times t (n,). heading: rad. gravity: m/s². Each fixing is played for
    itself and the takes are put one behind the other, as a paused recording would.
    """
    takes = _takes(plan, t, effects)
    played = [
        _play(plan, fixing, t[low:high], shaft[:, low:high], heading, gravity, effects)
        for fixing, low, high in takes
    ]
    inner = slice(MARGIN, -MARGIN)
    attitude, rate, force = (np.concatenate(parts, axis=1) for parts in zip(*played, strict=True))
    return Motion(t[inner], shaft[:, inner], attitude, rate, force, seams(plan, effects))


def seams(plan: Plan, effects: Sequence[Effect]) -> np.ndarray:
    """Times in s at which one take ends and the next begins; none where nothing is re-fixed."""
    moved = any(effect.fixing_error(0) is not None for effect in effects)
    return plan.fixing_times()[1:] if moved or len(set(plan.mounts)) > 1 else np.empty(0)


def _takes(plan: Plan, t: np.ndarray, effects: Sequence[Effect]) -> list[tuple[int, int, int]]:
    """(fixing, first, past last) of each take, with the margin on both sides."""
    edges = [MARGIN, *np.searchsorted(t, seams(plan, effects)), len(t) - MARGIN]
    return [
        (fixing, int(low) - MARGIN, int(high) + MARGIN)
        for fixing, (low, high) in enumerate(pairwise(edges))
    ]


def _play(
    plan: Plan,
    fixing: int,
    t: np.ndarray,
    shaft: np.ndarray,
    heading: float,
    gravity: float,
    effects: Sequence[Effect],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Attitude (4, n − 4), rates and specific force (3, n − 4) of one take."""
    chain: list[Link] = [("heading", about(UP, -heading))]
    for name, direction, angle in zip(plan.table.names, plan.table.directions, shaft, strict=True):
        chain.append((name, about(np.array(direction), angle)))
    chain.append(("mount", np.array(plan.mounts[fixing]).reshape(4, 1)))
    for effect in effects:
        error = effect.fixing_error(fixing)
        if error is not None:
            chain.append(("misfit", from_vector(error)))
        chain = effect.links(chain, t, shaft)
    ground = [q for name, q in chain if name == EARTH]
    attitude = reduce(product, (q for name, q in chain if name != EARTH))
    if attitude.shape[1] == 1:
        attitude = np.repeat(attitude, len(t), axis=1)
    step = float(t[1] - t[0])
    attitude = _bent(attitude, step, effects)
    inertial = reduce(product, [*ground, attitude])
    return (
        attitude[:, MARGIN:-MARGIN],
        rates(inertial, step),
        _force(attitude, step, gravity, effects),
    )


def _bent(attitude: np.ndarray, step: float, effects: Sequence[Effect]) -> np.ndarray:
    """The attitude after the fixture gave way to the loads of the rigid motion."""
    rigid = None
    for effect in effects:
        if rigid is None and type(effect).bend is not Effect.bend:
            rigid = np.pad(rates(attitude, step), ((0, 0), (MARGIN, MARGIN)), mode="edge")
        bend = effect.bend(rigid) if rigid is not None else None
        if bend is not None:
            attitude = product(attitude, from_vector(bend))
    return attitude


def _force(
    attitude: np.ndarray, step: float, gravity: float, effects: Sequence[Effect]
) -> np.ndarray:
    """What each accelerometer feels along its axis, (3, n − 4) m/s²."""
    back = inverse(attitude[:, MARGIN:-MARGIN])
    force = turned(back, gravity * UP)
    arms = [arm for arm in (effect.arms() for effect in effects) if arm is not None]
    if not arms:
        return force
    places, share = np.unique(np.sum(arms, axis=0), axis=0, return_inverse=True)
    for number, place in enumerate(places):
        position = turned(attitude, place)
        acceleration = np.diff(position[:, 1:-1], 2, axis=1) / step**2
        felt = turned(back, acceleration)
        own = share.ravel() == number
        force[own] += felt[own]
    return force
