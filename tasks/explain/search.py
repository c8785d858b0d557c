"""Effects are added one at a time until what is left is noise; then the list is put right.

A candidate's gain is the chi-squared it takes away beyond all that was found; its price is two
for each parameter and twice the logarithm of how many of its name were tried.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from tasks.explain.candidates import Candidate
from tasks.explain.pool import Pool, System, inverse, noises_of, residuals, system
from tasks.explain.spectrum import Noise

FALSE_ALARMS = 0.005  # of clean recordings, at most
MOST = 8  # findings
NEAR = 6.0  # of score: two that differ by less cannot be told apart
PER_PARAMETER = 2.0


@dataclass(frozen=True)
class Scored:
    """A candidate beside what was found: chi-squared gained, less its price, and its p value."""

    candidate: Candidate
    gain: float
    score: float
    p_value: float


@dataclass(frozen=True)
class Chosen:
    """A candidate that was taken; rivals: other names that fit nearly as well, best first."""

    candidate: Candidate
    gain: float
    score: float
    rivals: tuple[Scored, ...]


@dataclass(frozen=True)
class Found:
    """What the search found. p_value: of the strongest candidate at first, Bonferroni-corrected."""

    chosen: tuple[Chosen, ...]
    noises: tuple[Noise, ...]
    p_value: float
    state: System


def search(
    pool: Pool,
    candidates: Sequence[Candidate],
    start: Sequence[Candidate] = (),
    noises: tuple[Noise, ...] | None = None,
) -> Found:
    """The list of candidates that explains the pool's readings.

    start, noises: what an earlier search found.
    """
    chosen = list(start)
    if noises is None:
        noises = first_noises(pool)
    p_value = 1.0
    while len(chosen) < MOST:
        state = system(pool, noises)
        ranked = rank(state, candidates, chosen)
        if not ranked:
            break
        corrected = min(1.0, ranked[0].p_value * len(candidates))
        if not chosen:
            p_value = corrected
        if corrected > FALSE_ALARMS:
            break
        chosen.append(ranked[0].candidate)
        noises = beside(pool, chosen, noises)
        chosen = _put_right(system(pool, noises), candidates, chosen)
        noises = beside(pool, chosen, noises)
    state = system(pool, noises)
    return Found(_with_rivals(state, candidates, chosen), noises, p_value, state)


def first_noises(pool: Pool) -> tuple[Noise, ...]:
    """The noise of what the standard's model alone leaves."""
    plain = noises_of(pool, residuals(pool, (), None))
    return noises_of(pool, residuals(pool, (), plain))


def beside(pool: Pool, chosen: Sequence[Candidate], noises: Sequence[Noise]) -> tuple[Noise, ...]:
    """The noise of what the chosen leave, fitted by earlier noises."""
    return noises_of(pool, residuals(pool, members_of(chosen), noises))


def members_of(chosen: Sequence[Candidate]) -> list[int]:
    return sorted({p for one in chosen for p in one.members})


def rank(
    state: System, candidates: Sequence[Candidate], taken: Sequence[Candidate]
) -> list[Scored]:
    """The candidates by score, beside others that are taken."""
    normal, right = _projected(state, taken)
    own = {id(one) for one in taken}
    known = {one.name for one in taken if one.known}
    scored = [
        _scored(normal, right, state, one)
        for one in candidates
        if id(one) not in own and one.name not in known
    ]
    return sorted((one for one in scored if one is not None), key=lambda one: -one.score)


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
    normal: np.ndarray, right: np.ndarray, state: System, one: Candidate
) -> Scored | None:
    members = [p for p in one.members if state.scale[p] and normal[p, p] > 1e-4]
    if not members:
        return None
    if one.prior is not None:
        return _evidence(normal, right, state, one)
    own = right[members]
    if len(members) == 1:
        gain, rank_ = float(own[0] ** 2 / normal[members[0], members[0]]), 1
    else:
        block = normal[np.ix_(members, members)]
        values, vectors = np.linalg.eigh(block)
        kept = values > 1e-6 * values[-1]
        gain = float((((vectors[:, kept].T @ own) ** 2) / values[kept]).sum())
        rank_ = int(kept.sum())
    p_value = float(chi2.sf(gain, rank_))
    if one.known:
        p = members[0]
        size = 1.0 / state.scale[p]
        gain, rank_ = 2.0 * own[0] * size - normal[p, p] * size**2, 0
    price = PER_PARAMETER * rank_ + 2.0 * np.log(one.tried * one.looked) + one.term.rarity
    return Scored(one, gain, gain - price, min(1.0, p_value * one.looked))


def _gain(state: System, chosen: Sequence[Candidate]) -> float:
    """Chi-squared that a list takes away from the standard's model."""
    right, fixed = state.right, 0.0
    for one in chosen:
        if one.known and state.scale[one.members[0]]:
            p, size = one.members[0], 1.0 / state.scale[one.members[0]]
            fixed += 2.0 * right[p] * size - state.normal[p, p] * size**2
            right = right - state.normal[:, p] * size
    free = members_of([one for one in chosen if not one.known])
    if not free:
        return float(fixed)
    own = right[free]
    block = state.normal[np.ix_(free, free)] + np.diag(precision_of(state, chosen, free))
    return float(fixed + own @ inverse(block) @ own)


def precision_of(state: System, chosen: Sequence[Candidate], free: Sequence[int]) -> np.ndarray:
    """Prior precision (m,) of the free parameters at unit column size; zero for most."""
    precision = np.zeros(len(state.scale))
    for one in chosen:
        if one.prior is not None:
            precision[list(one.members)] = one.prior.precision(_powers(state, one))
    return precision[list(free)]


def _powers(state: System, one: Candidate) -> np.ndarray:
    scale = state.scale[list(one.members)]
    return np.divide(1.0, scale**2, out=np.zeros_like(scale), where=scale > 0)


def _evidence(normal: np.ndarray, right: np.ndarray, state: System, one: Candidate) -> Scored:
    """Of a random course: 2·ln of how much likelier the readings are with it than without."""
    assert one.prior is not None
    members = list(one.members)
    precision = one.prior.precision(_powers(state, one))
    root = 1.0 / np.sqrt(precision)
    seen = root * right[members]
    block = np.eye(len(members)) + root[:, None] * normal[np.ix_(members, members)] * root
    sizes, vectors = np.linalg.eigh(block)
    sizes = np.maximum(sizes, 1.0)  # but for rounding they are
    gain = float((((vectors.T @ seen) ** 2) / sizes).sum() - np.log(sizes).sum())
    price = 2.0 * PER_PARAMETER + 2.0 * np.log(one.tried)
    return Scored(one, gain, gain - price, float(np.exp(-0.5 * max(gain, 0.0))))


def _put_right(
    state: System, candidates: Sequence[Candidate], chosen: list[Candidate]
) -> list[Candidate]:
    """Takes out what the others have made needless, and exchanges what another does better."""
    for _ in range(3):
        before = list(chosen)
        for one in before:
            if one not in chosen:
                continue
            rest = [other for other in chosen if other is not one]
            ranked = rank(state, candidates, rest)
            if not ranked or ranked[0].score <= 0:
                chosen = rest
                continue
            own = next((s for s in ranked if s.candidate is one), None)
            if own is None:
                chosen = rest
            elif ranked[0].score > own.score + 1e-9:
                chosen = [ranked[0].candidate if other is one else other for other in chosen]
        if chosen == before:
            break
    return chosen


def _with_rivals(
    state: System, candidates: Sequence[Candidate], chosen: Sequence[Candidate]
) -> tuple[Chosen, ...]:
    found = []
    for one in chosen:
        rest = [other for other in chosen if other is not one]
        ranked = rank(state, candidates, rest)
        own = next((s for s in ranked if s.candidate is one), None)
        if own is None:
            continue
        rivals: dict[str, Scored] = {}
        for other in ranked:
            if other.candidate.name not in (one.name, *rivals):
                rivals[other.candidate.name] = other
        found.append(Chosen(one, own.gain, own.score, tuple(list(rivals.values())[:6])))
    return tuple(sorted(found, key=lambda each: -each.gain))
