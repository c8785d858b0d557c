"""How uncertain what a finding adds to the readings is, by each of its parameters."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import FoundParameter
from tasks.explain.explanation import Finding
from tasks.model.simulate import predict
from tasks.model.term import Term, nominal_values
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.whole import Motion

SAME = 0.2  # of a contribution: a term that misses it by more is not the one it came from
Adds = Callable[[Mapping[str, float]], np.ndarray]


@dataclass(frozen=True)
class Sensitivity:
    """How a contribution changes (n, 6) when one parameter grows by its standard uncertainty."""

    finding: Finding
    parameter: FoundParameter
    change: np.ndarray


def sensitivities(finding: Finding, terms: Sequence[Term], motion: Motion) -> Iterator[Sensitivity]:
    """What each parameter's standard uncertainty does to a finding's contribution.

    By the catalogue's term where one makes this contribution of these parameters; else the
    contribution is taken as uncertain as its parameters are as a whole. None where a term without
    a free parameter makes it: then what is said of its size is a check, and was not used.
    """
    if _is_known(finding, terms, motion):
        return
    uncertain = [p for p in finding.parameters if p.u > 0.0]
    adds = _adds_of(finding, terms, motion)
    if adds is None:
        yield from _as_a_whole(finding, uncertain)
        return
    found = {p.name: p.value for p in finding.parameters}
    for p in uncertain:
        more, less = (adds(found | {p.name: p.value + sign * p.u}) for sign in (1.0, -1.0))
        yield Sensitivity(finding, p, (more - less) / 2.0)


def _is_known(finding: Finding, terms: Sequence[Term], motion: Motion) -> bool:
    """Whether a term that nothing is fitted of makes the contribution."""
    ideal = nominal_values(STANDARD_TERMS)
    plain = predict(STANDARD_TERMS, motion, ideal)
    return any(
        _miss(predict((*STANDARD_TERMS, term), motion, ideal) - plain, finding) < SAME
        for term in terms
        if term.name == finding.effect and not (term.parameters or term.shapes)
    )


def _adds_of(finding: Finding, terms: Sequence[Term], motion: Motion) -> Adds | None:
    """What the term adds by its printed parameters, (n, 6); None if no term makes the finding."""
    plain = predict(STANDARD_TERMS, motion, nominal_values(STANDARD_TERMS))
    found = {p.name: p.value for p in finding.parameters}
    units = {(p.name, p.unit) for p in finding.parameters}
    best: tuple[float, Adds | None] = (SAME, None)
    for term in terms:
        known = {(p.name, p.unit) for p in (*term.parameters, *term.shapes)}
        if term.name != finding.effect or not units <= known:
            continue

        def adds(printed: Mapping[str, float], term: Term = term) -> np.ndarray:
            values = [printed.get(p.name, p.nominal * p.factor) / p.factor for p in term.parameters]
            places = zip(term.shapes, term.at, strict=True)
            at = tuple(printed[s.name] / s.factor if s.name in printed else a for s, a in places)
            one = (*STANDARD_TERMS, term.shaped(at))
            whole = np.concatenate([nominal_values(STANDARD_TERMS), values])
            return predict(one, motion, whole) - plain

        miss = _miss(adds(found), finding)
        if miss < best[0]:
            best = (miss, adds)
    return best[1]


def _miss(made: np.ndarray, finding: Finding) -> float:
    """How much of a contribution is missed, by the channel of the finding that misses most."""
    contribution = finding.contribution[:, list(finding.channels)]
    made = made[:, list(finding.channels)]
    known = np.isfinite(made) & np.isfinite(contribution)
    left = np.linalg.norm(np.where(known, made - contribution, 0.0), axis=0)
    size = np.linalg.norm(np.where(known, contribution, 0.0), axis=0)
    share = np.divide(left, size, out=np.full(len(size), np.inf), where=size > 0.0)
    return float(share.max(initial=0.0))


def _as_a_whole(finding: Finding, uncertain: Sequence[FoundParameter]) -> Iterator[Sensitivity]:
    """One spread: the contribution times the largest relative uncertainty of a common unit."""
    by_unit: dict[str, list[FoundParameter]] = {}
    for p in uncertain:
        by_unit.setdefault(p.unit, []).append(p)
    relative = [
        (math.hypot(*(p.u for p in some)) / max(math.hypot(*(p.value for p in some)), 1e-300), some)
        for some in by_unit.values()
    ]
    for share, some in sorted(relative, key=lambda each: -each[0])[:1]:
        largest = max(some, key=lambda p: abs(p.value))
        whole = largest.model_copy(update={"u": share * abs(largest.value)})
        yield Sensitivity(finding, whole, share * finding.contribution)
