"""The gain of each candidate beside those already selected.

A candidate's gain is the chi-squared it takes away; its price is two for each parameter and twice
the logarithm of how many of its name were tried, and for an empirical form a share of the gain.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc

from tasks.explain.explanation import UNNAMED
from tasks.explain.odds import CERTAIN
from tasks.explain.search.candidates import Candidate, Prior, Weights, members_of
from tasks.explain.search.design import NormalEquations
from tasks.model.regression import inverse

PER_PARAMETER = 2.0
OBSERVABLE = 1e-4  # of a column's power: less is left of it beside what was selected
# Of its gain, a tenth of its size: as well as a published form holds for a unit.
OF_A_FORM = 0.01
FREE_FORM = 2e-3  # of its gain: free factors also fit what the reference errs by, in proportion
SINGULAR = 1e-6  # of a column's power: keeps columns that are the same from dividing by nothing


@dataclass(frozen=True)
class ScoredCandidate:
    """A candidate beside those selected.

    gain: chi-squared; fit: the gain less two for each parameter; score: the gain less its whole
    price.
    """

    candidate: Candidate
    gain: float
    fit: float
    score: float
    p_value: float


def rank(
    equations: NormalEquations, candidates: Sequence[Candidate], selected: Sequence[Candidate]
) -> list[ScoredCandidate]:
    """The candidates by score, beside others that are selected."""
    left = projected(equations, selected)
    own = {candidate.key for candidate in selected}
    # Beside a shape that no fit has adjusted yet, a neighbouring one only makes up for the grid.
    whole = {candidate.name for candidate in selected if candidate.known or candidate.on_grid}
    others = [
        candidate
        for candidate in candidates
        if candidate.key not in own
        and (candidate.name == UNNAMED or candidate.name not in whole)
        and not _same_behaviour(candidate, selected)
    ]
    fixed = [candidate for candidate in others if candidate.prior is None]
    random = [candidate for candidate in others if candidate.prior is not None]
    scored = [
        *_fixed_effects(left, fixed),
        *_random_effects(left, random),
    ]
    return sorted(scored, key=lambda entry: -entry.score)


def _same_behaviour(candidate: Candidate, selected: Sequence[Candidate]) -> bool:
    """Whether something selected is of the same kind in an unlisted form, or as a listed one beside
    an unlisted one: a form and what it lacks are one finding.
    """
    return any(
        set(candidate.members) & set(other.members)
        if candidate.unlisted and other.unlisted
        else candidate.unlisted != other.unlisted and candidate.name == other.name != UNNAMED
        for other in selected
    )


def projected(equations: NormalEquations, selected: Sequence[Candidate]) -> NormalEquations:
    """Normal equations without the selection: fitted members projected out, known ones
    subtracted.
    """
    normal, right = equations.normal, equations.right
    for candidate in selected:
        if candidate.known:
            p = candidate.members[0]
            if equations.scale[p]:
                right = right - normal[:, p] / equations.scale[p]
    free = members_of([candidate for candidate in selected if not candidate.known])
    if not free:
        return replace(equations, right=right)
    shared = normal[:, free]
    precision = np.diag(prior_precision(equations, selected, free))
    solved = inverse(normal[np.ix_(free, free)] + precision)
    return replace(
        equations,
        normal=normal - shared @ solved @ shared.T,
        right=right - shared @ (solved @ right[free]),
    )


def _fixed_effects(left: NormalEquations, candidates: Sequence[Candidate]) -> list[ScoredCandidate]:
    """Candidates of a few parameters, those of one size all at once."""
    normal, scored = left.normal, list[ScoredCandidate]()
    for size in sorted({len(candidate.members) for candidate in candidates}):
        some = [candidate for candidate in candidates if len(candidate.members) == size]
        members = np.array([candidate.members for candidate in some])
        blocks = normal[members[:, :, None], members[:, None, :]]
        observable = (left.scale[members] > 0) & (normal[members, members] > OBSERVABLE)
        blocks = blocks * observable[:, :, None] * observable[:, None, :]
        diagonal = np.arange(size)
        blocks[:, diagonal, diagonal] += np.where(observable, SINGULAR, 1.0)
        gains = _quadratic_forms(left.right[members] * observable, blocks)
        counts = observable.sum(axis=1)
        scored += [
            _fixed_effect(left, candidate, gain, count)
            for candidate, gain, count in zip(some, gains.tolist(), counts.tolist(), strict=True)
            if count
        ]
    return scored


def _quadratic_forms(vectors: np.ndarray, matrices: np.ndarray) -> np.ndarray:
    """(k,) vᵀM⁻¹v of vectors (k, m) and matrices (k, m, m)."""
    solved = np.linalg.solve(matrices, vectors[:, :, None])[:, :, 0]
    return np.asarray((vectors * solved).sum(axis=1))


def _fixed_effect(
    left: NormalEquations, candidate: Candidate, gain: float, count: int
) -> ScoredCandidate:
    """count: parameters that the readings determine."""
    one_sided = _one_sided(candidate)
    if one_sided:
        gain = _gain_above_nothing(left, candidate.members)
    p_value = min(1.0, float(chdtrc(count, gain)) * candidate.shape_trials)
    if candidate.known:  # no factor is fitted: it gains what it gains
        p, count = candidate.members[0], 0
        size = 1.0 / left.scale[p]
        gain = float(2.0 * left.right[p] * size - left.normal[p, p] * size**2)
    trials = candidate.trials * candidate.shape_trials
    fit = gain - PER_PARAMETER * count
    price = PER_PARAMETER * count + 2.0 * np.log(trials) + candidate.term.rarity
    price -= 2.0 * np.log(2.0) if one_sided else 0.0  # half the room for a chance estimate
    price += FREE_FORM * gain if candidate.name == UNNAMED else 0.0
    # What is known to be there needs no other that imitates it, as a sensitivity to the field of
    # Earth does its rotation.
    price -= CERTAIN if candidate.known and gain > 2.0 * CERTAIN else 0.0
    return ScoredCandidate(candidate, gain, fit, gain - price, p_value)


def _one_sided(candidate: Candidate) -> bool:
    """Whether none of its parameters can be negative, such as a time constant."""
    if candidate.known:
        return False
    return all(candidate.term.parameters[q].plausible[0] == 0.0 for q in candidate.own)


def _gain_above_nothing(left: NormalEquations, members: Sequence[int]) -> float:
    """Chi-squared that parameters gain of which none is fitted below nothing."""
    kept = list(members)
    while kept:
        block = left.normal[np.ix_(kept, kept)] + SINGULAR * np.eye(len(kept))
        fitted = np.linalg.solve(block, left.right[kept])
        if (fitted >= 0.0).all():
            return float(left.right[kept] @ fitted)
        kept = [p for p, value in zip(kept, fitted, strict=True) if value >= 0.0]
    return 0.0


def prior_precision(
    equations: NormalEquations, candidates: Sequence[Candidate], members: Sequence[int]
) -> np.ndarray:
    """Prior precision (m,) of some parameters at unit column size; zero for most."""
    precision = np.zeros(len(equations.scale))
    for candidate in candidates:
        if candidate.prior is not None:
            own = np.array(candidate.members)
            precision[own] = candidate.prior.precision(equations.power[own])
    return precision[list(members)]


def _random_effects(
    left: NormalEquations, candidates: Sequence[Candidate]
) -> list[ScoredCandidate]:
    """Random drifts: 2·ln of how much likelier the readings are with one than without.

    Channel by channel, which share columns between many candidates; what other findings couple
    between the channels is left out here.
    """
    if not candidates:
        return []
    drifts = {candidate.key: _drifts(candidate) for candidate in candidates}
    distinct = list(dict.fromkeys(drift for own in drifts.values() for drift in own))
    gain_of: dict[tuple[Prior | Weights, tuple[int, ...]], float] = {}
    for count in {len(channel) for _, channel in distinct}:
        gain_of |= _gains_of_drifts(left, [each for each in distinct if len(each[1]) == count])
    scored = []
    for candidate in candidates:
        gain = sum(gain_of[drift] for drift in drifts[candidate.key])
        price = 2.0 * PER_PARAMETER + 2.0 * np.log(candidate.trials) + candidate.term.rarity
        # No walk where another drift may explain it as well. The name of an unlisted form is
        # compared with all others once it is selected.
        price += CERTAIN if candidate.name != UNNAMED and not candidate.unlisted else 0.0
        price += OF_A_FORM * max(gain, 0.0) if candidate.unlisted else 0.0
        p_value = float(np.exp(-0.5 * max(gain, 0.0)))
        score = gain - price
        fit = gain if candidate.unlisted else score
        scored.append(ScoredCandidate(candidate, gain, fit, score, p_value))
    return scored


def _gains_of_drifts(
    left: NormalEquations, drifts: Sequence[tuple[Prior | Weights, tuple[int, ...]]]
) -> dict[tuple[Prior | Weights, tuple[int, ...]], float]:
    """Of each prior on as many columns of one channel, 2·ln of the ratio of likelihoods."""
    members = np.array([channel for _, channel in drifts])
    power = left.power
    root = 1.0 / np.sqrt([prior.precision(power[list(own)]) for prior, own in drifts])
    blocks = left.normal[members[:, :, None], members[:, None, :]]
    blocks = np.eye(members.shape[1]) + root[:, :, None] * blocks * root[:, None, :]
    gains = _quadratic_forms(root * left.right[members], blocks) - np.linalg.slogdet(blocks)[1]
    return dict(zip(drifts, gains.tolist(), strict=True))


def _drifts(candidate: Candidate) -> list[tuple[Prior | Weights, tuple[int, ...]]]:
    """Prior and parameters of a random drift or an unlisted form in each of its channels."""
    prior = candidate.prior
    assert prior is not None
    starts = range(0, len(candidate.members), prior.columns)
    return [(prior, candidate.members[start : start + prior.columns]) for start in starts]


def joint_gain(
    equations: NormalEquations, together: Sequence[Candidate], selected: Sequence[Candidate]
) -> float:
    """Chi-squared that some candidates gain together beside others that are selected."""
    left, members = projected(equations, selected), np.array(members_of(together))
    block = left.normal[np.ix_(members, members)]
    observable = (left.scale[members] > 0) & (np.diag(block) > OBSERVABLE)
    block = block * observable[:, None] * observable + np.diag(np.where(observable, SINGULAR, 1.0))
    return float(_quadratic_forms((left.right[members] * observable)[None], block[None])[0])
