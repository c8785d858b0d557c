"""How much each candidate gains beside what was found.

A candidate's gain is the chi-squared it takes away; its price is two for each parameter and twice
the logarithm of how many of its name were tried.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from tasks.explain.search.candidates import WAVES, Candidate, Prior
from tasks.explain.search.empirical_terms import UNNAMED
from tasks.explain.search.pool import System
from tasks.model.regression import inverse

NEAR = 6.0  # of score: two that differ by less cannot be told apart
PER_PARAMETER = 2.0
SEEN = 1e-4  # of a column's power: less is left of it beside what was taken
SINGULAR = 1e-6  # of a column's power: keeps columns that are the same from dividing by nothing


@dataclass(frozen=True)
class Scored:
    """A candidate beside what was found: chi-squared gained, less its price, and its p value."""

    candidate: Candidate
    gain: float
    score: float
    p_value: float


def members_of(chosen: Sequence[Candidate]) -> list[int]:
    return sorted({p for one in chosen for p in one.members})


def rank(
    state: System, candidates: Sequence[Candidate], taken: Sequence[Candidate]
) -> list[Scored]:
    """The candidates by score, beside others that are taken."""
    normal, right = _projected(state, taken)
    own = {one.key for one in taken}
    # Beside a shape that no fit has adjusted yet, a neighbouring one only makes up for the grid.
    whole = {one.name for one in taken if one.known or (one.term.bent and not one.fitted)}
    asked = [
        one
        for one in candidates
        if one.key not in own and (one.name == UNNAMED or one.name not in whole)
    ]
    plain = [one for one in asked if one.prior is None]
    scored = _scored(normal, right, state, plain)
    scored += _courses(normal, right, state, [one for one in asked if one.prior is not None])
    return sorted(scored, key=lambda one: -one.score)


def _projected(state: System, taken: Sequence[Candidate]) -> tuple[np.ndarray, np.ndarray]:
    """Normal equations without what is taken: fitted parameters projected, known ones taken off."""
    normal, right = state.normal, state.right
    for one in taken:
        if one.known:
            p = one.members[0]
            if state.scale[p]:
                right = right - normal[:, p] / state.scale[p]
    free = members_of([one for one in taken if not one.known])
    if not free:
        return normal, right
    shared = normal[:, free]
    solved = inverse(normal[np.ix_(free, free)] + np.diag(precision_of(state, taken, free)))
    return normal - shared @ solved @ shared.T, right - shared @ (solved @ right[free])


def _scored(
    normal: np.ndarray, right: np.ndarray, state: System, candidates: Sequence[Candidate]
) -> list[Scored]:
    """Candidates of a few parameters, those of one size all at once."""
    found: list[Scored] = []
    for size in sorted({len(one.members) for one in candidates}):
        some = [one for one in candidates if len(one.members) == size]
        members = np.array([one.members for one in some])
        blocks = normal[members[:, :, None], members[:, None, :]]
        seen = (state.scale[members] > 0) & (normal[members, members] > SEEN)
        blocks = blocks * seen[:, :, None] * seen[:, None, :]
        diagonal = np.arange(size)
        blocks[:, diagonal, diagonal] += np.where(seen, SINGULAR, 1.0)
        heard = right[members] * seen
        gains = (heard * np.linalg.solve(blocks, heard[:, :, None])[:, :, 0]).sum(axis=1)
        ranks = seen.sum(axis=1)
        for one, gain, rank_ in zip(some, gains.tolist(), ranks.tolist(), strict=True):
            if rank_:
                found.append(_one(normal, right, state, one, gain, rank_))
    return found


def _one(
    normal: np.ndarray, right: np.ndarray, state: System, one: Candidate, gain: float, rank_: int
) -> Scored:
    one_sided = _one_sided(one)
    if one_sided and right[one.members[0]] < 0.0:
        gain = 0.0  # fitted below nothing, where no unit has it
    p_value = min(1.0, float(chdtrc(rank_, gain)) * one.looked)
    if one.known:  # no factor is fitted: it gains what it gains
        p, rank_ = one.members[0], 0
        size = 1.0 / state.scale[p]
        gain = float(2.0 * right[p] * size - normal[p, p] * size**2)
    price = PER_PARAMETER * rank_ + 2.0 * np.log(one.tried * one.looked) + one.term.rarity
    price -= 2.0 * np.log(2.0) if one_sided else 0.0  # half the room for a chance estimate
    return Scored(one, gain, gain - price, p_value)


def _one_sided(one: Candidate) -> bool:
    """Whether its one parameter cannot be negative, such as a time constant."""
    if len(one.members) != 1 or one.known:
        return False
    return one.term.parameters[one.own[0]].plausible[0] == 0.0


def precision_of(state: System, chosen: Sequence[Candidate], free: Sequence[int]) -> np.ndarray:
    """Prior precision (m,) of the free parameters at unit column size; zero for most."""
    precision = np.zeros(len(state.scale))
    for one in chosen:
        if one.prior is not None:
            members = np.array(one.members)
            precision[members] = one.prior.precision(_powers(state, members))
    return precision[list(free)]


def _courses(
    normal: np.ndarray, right: np.ndarray, state: System, candidates: Sequence[Candidate]
) -> list[Scored]:
    """Random courses: 2·ln of how much likelier the readings are with one than without.

    Channel by channel, which share columns between many candidates; what other findings couple
    between the channels is left out here.
    """
    if not candidates:
        return []
    keys: dict[tuple[Prior, tuple[int, ...]], int] = {}
    for one in candidates:
        for channel in _by_channel(one):
            keys.setdefault((_prior(one), channel), len(keys))
    members = np.array([channel for _, channel in keys])
    power = _powers(state, members)
    precision = np.array([
        prior.precision(row) for (prior, _), row in zip(keys, power, strict=True)
    ])  # fmt: skip
    root = 1.0 / np.sqrt(precision)
    blocks = normal[members[:, :, None], members[:, None, :]]
    blocks = np.eye(members.shape[1]) + root[:, :, None] * blocks * root[:, None, :]
    heard = root * right[members]
    gains = (heard * np.linalg.solve(blocks, heard[:, :, None])[:, :, 0]).sum(axis=1)
    gains -= np.linalg.slogdet(blocks)[1]
    found = []
    for one in candidates:
        gain = sum(float(gains[keys[_prior(one), channel]]) for channel in _by_channel(one))
        price = 2.0 * PER_PARAMETER + 2.0 * np.log(one.tried)
        price += NEAR if one.name != UNNAMED else 0.0  # no walk that may as well be another course
        found.append(Scored(one, gain, gain - price, float(np.exp(-0.5 * max(gain, 0.0)))))
    return found


def _prior(one: Candidate) -> Prior:
    assert one.prior is not None
    return one.prior


def _by_channel(one: Candidate) -> list[tuple[int, ...]]:
    return [one.members[n : n + WAVES] for n in range(0, len(one.members), WAVES)]


def _powers(state: System, members: np.ndarray) -> np.ndarray:
    scale = state.scale[members]
    return np.divide(1.0, scale**2, out=np.zeros_like(scale), where=scale > 0)
