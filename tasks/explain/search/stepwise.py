"""Stepwise selection: effects are added one by one until only noise is left, then pruned."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tasks.explain.search.candidates import Candidate, members_of
from tasks.explain.search.design import (
    UNIT_NOISE,
    BandedDesign,
    NormalEquations,
    normal_equations,
    residual_noises,
)
from tasks.explain.search.scores import prior_precision, rank
from tasks.explain.whitening import Noise
from tasks.model.term import TermKey

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
