"""Stepwise selection: effects are added one by one until only noise is left, then pruned."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc

from tasks.explain.explanation import CERTAIN, UNNAMED, as_likely_within
from tasks.explain.noise import Noise
from tasks.explain.search.candidates import (
    Candidate,
    Prior,
    Weights,
    members_of,
    with_proposed_shapes,
)
from tasks.explain.search.design import (
    UNIT_NOISE,
    BandedDesign,
    NormalEquations,
    normal_equations,
    residual_noises,
)
from tasks.model.fit import inverse
from tasks.model.term import Term, TermKey

# The gain of each candidate beside those already selected.
#
# A candidate's gain is the chi-squared it takes away; its price is two for each parameter and
# twice the logarithm of how many of its name were tried, and for an empirical form a share of the
# gain.

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


FALSE_ALARMS = 0.005  # of clean recordings, at most
MAX_SELECTED = 8
MAX_EXCHANGES = 3


@dataclass(frozen=True)
class Selected:
    """A selected candidate; rivals: other names that fit as well in its place, best first.

    absorbed_by: the standard's term that absorbs it completely, if it was selected nevertheless.
    group: names that compensate for each other here, including its own; empty if none does.
    """

    candidate: Candidate
    gain: float
    score: float
    rivals: tuple[str, ...] = ()
    absorbed_by: str | None = None
    group: tuple[str, ...] = ()


@dataclass(frozen=True)
class Selection:
    """What a search selected, and the noise beside it.

    p_value: of the strongest candidate at first, Bonferroni-corrected.
    """

    selected: tuple[Selected, ...]
    noises: tuple[Noise, ...]
    p_value: float
    equations: NormalEquations

    @property
    def candidates(self) -> list[Candidate]:
        return [one.candidate for one in self.selected]

    def prior_precision(self, candidate: Candidate) -> np.ndarray:
        """(m,) prior precision of a candidate's parameters, in their own units."""
        if candidate.prior is None:
            return np.zeros(len(candidate.own))
        scale = self.equations.scale[list(candidate.members)]
        precision = prior_precision(self.equations, [candidate], candidate.members)
        return np.divide(precision, scale**2, out=np.full(len(scale), 1e30), where=scale > 0)

    def with_candidates(self, candidates: Sequence[Candidate]) -> "Selection":
        """The selection with other candidates in the places of its own, in their order."""
        pairs = zip(self.selected, candidates, strict=True)
        return replace(self, selected=tuple(replace(one, candidate=new) for one, new in pairs))


def search(
    design: BandedDesign,
    candidates: Sequence[Candidate],
    start: Sequence[Candidate] = (),
    noises: tuple[Noise, ...] | None = None,
) -> Selection:
    """The candidates that explain the design's readings.

    start, noises: what an earlier search selected.
    """
    if noises is None:
        noises = initial_noises(design)
    selected, noises, p_value = _stepwise(design, candidates, start, noises)
    instead = _by_behaviour(design, candidates, selected, noises)
    if instead is not None:
        selected, noises, _ = _stepwise(design, candidates, *instead)
    equations = normal_equations(design, noises)
    found = _with_gains(equations, candidates, selected)
    return Selection(found, noises, p_value, equations)


def _stepwise(
    design: BandedDesign,
    candidates: Sequence[Candidate],
    start: Sequence[Candidate],
    noises: tuple[Noise, ...],
) -> tuple[list[Candidate], tuple[Noise, ...], float]:
    """What is selected from a start on, the noise beside it, and the p value of the strongest at
    first.
    """
    selected = list(start)
    p_value = 1.0
    visited = {_keys(selected)}
    while len(selected) < MAX_SELECTED:
        ranked = rank(normal_equations(design, noises), candidates, selected)
        if not ranked:
            break
        corrected = min(1.0, ranked[0].p_value * len(candidates))
        if len(selected) == len(start):
            p_value = corrected
        if corrected > FALSE_ALARMS:
            break
        selected.append(ranked[0].candidate)
        noises = noises_beside(design, selected, noises)
        selected = _revised(normal_equations(design, noises), candidates, selected)
        noises = noises_beside(design, selected, noises)
        if _keys(selected) in visited:  # what was added does not stand
            break
        visited.add(_keys(selected))
    return selected, noises, p_value


def _by_behaviour(
    design: BandedDesign,
    candidates: Sequence[Candidate],
    selected: Sequence[Candidate],
    noises: tuple[Noise, ...],
) -> tuple[list[Candidate], tuple[Noise, ...]] | None:
    """The selection with an unlisted form in the place of what it explains better, and the noise
    beside it; none where no kind of behaviour does.

    What a published form leaves where the behaviour has another one counts as noise as long as it
    is selected: so the two are compared by the noise beside the unlisted form.
    """
    if not any(one.unlisted for one in candidates):
        return None
    nuisances = [one for one in selected if one.nuisance]
    if len(nuisances) == len(selected) or any(one.unlisted for one in selected):
        return None
    ranked = rank(normal_equations(design, noises), candidates, nuisances)
    kinds: dict[TermKey, Candidate] = {}
    for one in ranked:
        if one.candidate.unlisted and one.score > 0.0:
            kinds.setdefault(one.candidate.term.key, one.candidate)
    for kind in kinds.values():
        beside = noises_beside(design, [*selected, kind], noises)
        equations = normal_equations(design, beside)
        revised = _revised(equations, candidates, [*selected, kind])
        if any(one.unlisted for one in revised):
            return revised, noises_beside(design, revised, beside)
    return None


def initial_noises(design: BandedDesign) -> tuple[Noise, ...]:
    """The noise of what the standard's model alone leaves."""
    unit = [UNIT_NOISE] * len(design.channels)
    return residual_noises(design, (), residual_noises(design, (), unit))


def noises_beside(
    design: BandedDesign, selected: Sequence[Candidate], noises: Sequence[Noise]
) -> tuple[Noise, ...]:
    """The noise of what the selected candidates leave, fitted by earlier noises."""
    return residual_noises(design, members_of(selected), noises)


def _keys(candidates: Sequence[Candidate]) -> frozenset[object]:
    return frozenset(one.key for one in candidates)


def _revised(
    equations: NormalEquations, candidates: Sequence[Candidate], selected: list[Candidate]
) -> list[Candidate]:
    """Takes out what the others have made needless, and exchanges what another does better."""
    for _ in range(MAX_EXCHANGES):
        before = [one.key for one in selected]
        for one in list(selected):
            if one.nuisance or one.key not in _keys(selected):
                continue
            rest = [other for other in selected if other.key != one.key]
            ranked = rank(equations, candidates, rest)
            own = next((scored for scored in ranked if scored.candidate.key == one.key), None)
            if own is None or ranked[0].score <= 0:
                selected = rest
            elif ranked[0].score > own.score + 1e-9:
                best = ranked[0].candidate
                selected = [best if other.key == one.key else other for other in selected]
        if [one.key for one in selected] == before:
            break
    return selected


def _with_gains(
    equations: NormalEquations, candidates: Sequence[Candidate], selected: Sequence[Candidate]
) -> tuple[Selected, ...]:
    """The selected candidates by gain; one that has become unobservable is left out."""
    found = []
    for one in selected:
        rest = [other for other in selected if other.key != one.key]
        ranked = rank(equations, candidates, rest)
        own = next((scored for scored in ranked if scored.candidate.key == one.key), None)
        if own is None:
            if one.nuisance:
                found.append(Selected(one, 0.0, 0.0))
            continue
        found.append(Selected(one, own.gain, own.score))
    return tuple(sorted(found, key=lambda selected: -selected.gain))


# Tells a lever arm from the more general forms of which it is the special case.
#
# What fits a recording of a lever arm fits as well with the size effect, places alike; whether it
# could show that the accelerometers are apart decides whether the lever arm stands alone. Nine
# free factors of the angular acceleration are a lever arm where they are antisymmetric, ω̇×r.

HOLDS = {"lever_arm": "size_effect"}  # special case: general effect
BY_EQUATION = {"reading += c·ω̇": "lever_arm"}  # general form without a name: special case
APART = np.array([[1.0, 0.0, -1.0], [-1.0, 1.0, 0.0], [0.0, -1.0, 1.0]])  # accelerometer, component
# Chi-squared that a typical departure is to show: of six independent components, so that one in
# twenty shows a quarter of it.
SHOWN = 60.0


def special_cases(general: Term) -> tuple[str, ...]:
    """Names of the catalogue that a term holds as special cases."""
    named = (name for name, effect in HOLDS.items() if effect == general.name)
    unnamed = BY_EQUATION.get(general.equation)
    return (*named, *([unnamed] if unnamed else []))


def places_apart(r: np.ndarray) -> np.ndarray:
    """(9,) places (m) of three accelerometers that are as far apart as their mean r (3,) is from
    the axes.
    """
    return np.asarray((r + np.linalg.norm(r) / np.sqrt(3.0) * APART).ravel())


def departure_shown(
    equations: NormalEquations, general: Candidate, others: Sequence[Candidate], r: np.ndarray
) -> float:
    """Expected chi-squared of places that are apart by as much as r (3,) m is long, beside what
    their mean and other candidates may take of it.

    The columns of the places that the data move, of nine, are of unit size: their scale is divided
    out. S = G − GB(BᵀGB)⁻¹BᵀG with B the places alike; components of σ² = r²/3 show σ²·tr(S).
    """
    places = list(general.members)
    left, size = projected(equations, others), equations.power[places] ** 0.5
    information = left.normal[np.ix_(places, places)] * np.outer(size, size)
    alike = np.tile(np.eye(3), (3, 1))[list(general.own)]
    along = information @ alike
    apart = information - along @ inverse(alike.T @ along) @ along.T
    return float(np.trace(apart) * (r @ r) / 3.0)


# What fits as well in the place of something that was selected.
#
# The price of a search decides what is selected, and not what the data can tell apart: a step has
# many instants to be tried at, and between the same rests any of them fits alike. So the instants
# are proposed anew in the place of each selected candidate, and rivals are compared by the chi-
# squared that they gain and by their parameters alone, beside what the form of the selected one
# may lack.


def with_rivals(
    selection: Selection, design: BandedDesign, candidates: Sequence[Candidate]
) -> Selection:
    """The selection with the names of the catalogue that fit as well in each one's place.

    candidates: all that were tried.
    """
    selected = tuple(
        replace(one, rivals=_rivals(one, selection, design, candidates))
        for one in selection.selected
    )
    return replace(selection, selected=selected)


def _rivals(
    one: Selected, selection: Selection, design: BandedDesign, candidates: Sequence[Candidate]
) -> tuple[str, ...]:
    """Names other than its own, the best first; of an unlisted form `unnamed` among them."""
    if one.candidate.nuisance or one.candidate.name == UNNAMED:
        return ()
    rest = [other for other in selection.candidates if other.key != one.candidate.key]
    design, candidates = with_proposed_shapes(
        design, candidates, selection.noises, [*rest, one.candidate], beside=rest
    )
    equations = normal_equations(design, selection.noises)
    ranked = rank(equations, candidates, rest)
    own = next((each for each in ranked if each.candidate.key == one.candidate.key), None)
    if own is None:
        return ()
    names = dict.fromkeys(each.candidate.name for each in ranked if _fits_as_well(each, own))
    names.pop(own.candidate.name, None)
    if not own.candidate.unlisted:
        names.pop(UNNAMED, None)
    general = HOLDS.get(own.candidate.name)
    places = next((each for each in candidates if each.name == general), None)
    if places is not None:
        names.pop(places.name, None)
        arm = _values(own.candidate, equations, rest)
        if departure_shown(equations, places, rest, arm) <= SHOWN:
            names[places.name] = None
    return tuple(names)


def _values(one: Candidate, equations: NormalEquations, rest: Sequence[Candidate]) -> np.ndarray:
    """(p,) of all its term's parameters in their own units, fitted beside the rest."""
    left, members = projected(equations, rest), list(one.members)
    values = np.zeros(len(one.term.parameters))
    fitted = inverse(left.normal[np.ix_(members, members)]) @ left.right[members]
    values[list(one.own)] = fitted * left.scale[members]
    return values


def _fits_as_well(other: ScoredCandidate, own: ScoredCandidate) -> bool:
    """By the price of the search, or by the data alone; of an unlisted form, which is free to
    follow its drive, by the data.
    """
    better = own.fit - other.fit
    if own.candidate.unlisted:
        return better < CERTAIN
    return own.score - other.score < CERTAIN or better < as_likely_within(own.gain)
