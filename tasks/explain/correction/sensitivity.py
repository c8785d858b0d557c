"""How uncertain what a finding adds to the readings is, by each of its parameters."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from schemas.discrepancy import FoundParameter
from tasks.explain.explanation import Finding
from tasks.model.simulate import predict
from tasks.model.term import Parameter, Term, nominal_values
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.whole import Motion

MAX_MISFIT = 0.2  # of a contribution: a term that misses it by more is not the one it came from


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
    a free parameter makes it: then its parameters are a check, and were not used.
    """
    values = {p.name: p.value for p in finding.parameters}
    uncertain = [p for p in finding.parameters if p.u > 0.0]
    unit = _Unit(motion)
    own = [term for term in terms if term.name == finding.effect]
    known = [term for term in own if not (term.parameters or term.shapes)]
    if any(_misfit(unit.added(term, {}), finding) < MAX_MISFIT for term in known):
        return
    units = {(p.name, p.unit) for p in finding.parameters}
    fitting = [term for term in own if units <= {(p.name, p.unit) for p in _parameters(term)}]
    misfits = [_misfit(unit.added(term, values), finding) for term in fitting]
    if not fitting or min(misfits) >= MAX_MISFIT:
        yield from _as_a_whole(finding, uncertain)
        return
    term = fitting[misfits.index(min(misfits))]
    for p in uncertain:
        more, less = (
            unit.added(term, values | {p.name: p.value + sign * p.u}) for sign in (1.0, -1.0)
        )
        yield Sensitivity(finding, p, (more - less) / 2.0)


def _parameters(term: Term) -> tuple[Parameter, ...]:
    return (*term.parameters, *term.shapes)


@dataclass(frozen=True)
class _Unit:
    """An ideal unit on a motion."""

    motion: Motion

    @cached_property
    def readings(self) -> np.ndarray:
        return predict(STANDARD_TERMS, self.motion, nominal_values(STANDARD_TERMS))

    def added(self, term: Term, printed: Mapping[str, float]) -> np.ndarray:
        """(n, 6) what a term adds to the readings, by its parameters as they are printed."""
        values = [printed.get(p.name, p.nominal * p.factor) / p.factor for p in term.parameters]
        shapes = zip(term.shapes, term.at, strict=True)
        at = tuple(printed[s.name] / s.factor if s.name in printed else own for s, own in shapes)
        every = np.concatenate([nominal_values(STANDARD_TERMS), values])
        return predict((*STANDARD_TERMS, term.shaped(at)), self.motion, every) - self.readings


def _misfit(added: np.ndarray, finding: Finding) -> float:
    """How much of a contribution is missed, by the channel of the finding that misses most."""
    channels = list(finding.channels)
    contribution, added = finding.contribution[:, channels], added[:, channels]
    known = np.isfinite(added) & np.isfinite(contribution)
    left = np.linalg.norm(np.where(known, added - contribution, 0.0), axis=0)
    size = np.linalg.norm(np.where(known, contribution, 0.0), axis=0)
    share = np.divide(left, size, out=np.full(len(size), np.inf), where=size > 0.0)
    return float(share.max(initial=0.0))


def _as_a_whole(finding: Finding, uncertain: Sequence[FoundParameter]) -> Iterator[Sensitivity]:
    """The contribution times the largest relative uncertainty of parameters of one unit."""
    by_unit: dict[str, list[FoundParameter]] = {}
    for p in uncertain:
        by_unit.setdefault(p.unit, []).append(p)
    relative = [
        (math.hypot(*(p.u for p in some)) / max(math.hypot(*(p.value for p in some)), 1e-300), some)
        for some in by_unit.values()
    ]
    if relative:
        share, some = max(relative, key=lambda pair: pair[0])
        largest = max(some, key=lambda p: abs(p.value))
        whole = largest.model_copy(update={"u": share * abs(largest.value)})
        yield Sensitivity(finding, whole, share * finding.contribution)
