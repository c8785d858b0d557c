"""Which parameters of the findings the recording determines, and the model of these alone."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tasks.explain.determined import DeterminedModel
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.scrutiny import Scrutiny
from tasks.explain.inputs.full_rate import FullRate
from tasks.explain.odds import COVERAGE
from tasks.explain.search.refit import fitted
from tasks.explain.whitening import equations_of
from tasks.model.model import Model
from tasks.model.regression import inverse
from tasks.model.term import TermKey


def determined_model(
    evidence: Evidence, scrutinies: Mapping[int, Scrutiny], full: FullRate
) -> DeterminedModel:
    """The fitted model with its undetermined parameters set to nothing and the rest fitted again.

    A parameter no better known than its size would otherwise shift the standard's parameters that
    compensate for it. Its possible size, with everything that compensates for it, stays in the
    covariance. scrutinies: of the findings, by number.
    """
    fit, model = evidence.fit, evidence.fit.model
    wider = widening(evidence, scrutinies)
    free, groups = np.flatnonzero(model.free), evidence.groups
    own = [evidence.own[number][0] for number in scrutinies if not groups[number].random]
    loose = undetermined(
        model, [{int(free[q]) for q in one if q < len(free)} for one in own], wider
    )
    if loose.any():
        without = fitted(model.held_at_zero(loose), fit.blocks, fit.noises)
        model = replace(without, free=without.free | loose)
    spread = [_spread(evidence, model.terms[k].key) for k in model.fitted_shapes]
    wide = np.concatenate([wider[model.free], spread])
    covariance = _covariance(model, evidence) * wide[:, None] * wide
    return DeterminedModel(model, loose, covariance, full.motion, full.start)


def _spread(evidence: Evidence, key: TermKey) -> float:
    """The factor by which the residual widens u of a term's shape."""
    numbers = [n for n, group in enumerate(evidence.groups) if key in {t.key for t in group.terms}]
    return float(np.sqrt(max((evidence.scatter.dispersion(n) for n in numbers), default=1.0)))


def widening(evidence: Evidence, scrutinies: Mapping[int, Scrutiny]) -> np.ndarray:
    """(p,) factors by which the residual, and the differences between parts, widen each u."""
    model, wider = evidence.fit.model, np.ones(len(evidence.fit.model.values))
    free = np.flatnonzero(model.free)
    for number, scrutiny in scrutinies.items():
        for q, u in zip(evidence.own[number][0], scrutiny.u.tolist(), strict=True):
            if q < len(free) and model.u[free[q]] > 0.0:
                wider[free[q]] = u / model.u[free[q]]
    return wider


def undetermined(model: Model, owned: Sequence[set[int]], wider: np.ndarray) -> np.ndarray:
    """(p,) bool: parameters no larger than their U once the less clear ones are set to nothing.

    One by one, the least clear first, since whatever compensates for it then becomes clearer: of
    effects that compensate for each other one stays, and the last parameter of each does. owned:
    the places of each effect's parameters. wider: (p,) factors by which each u exceeds the fit's.
    """
    values, covariance = model.values.copy(), model.covariance.copy()
    left = [set(own) for own in owned]
    loose = np.zeros(len(values), bool)
    while True:
        u = wider * np.sqrt(np.maximum(np.diag(covariance), 0.0))
        tried = [p for own in left if len(own) > 1 for p in own if u[p] > 0.0]
        least = min(tried, key=lambda p: abs(values[p]) / u[p], default=None)
        if least is None or abs(values[least]) > COVERAGE * u[least]:
            return loose
        loose[least] = True
        for own in left:
            own.discard(least)
        gain = covariance[:, least] / covariance[least, least]
        values = values - gain * values[least]
        covariance = covariance - np.outer(gain, covariance[least])


def _covariance(model: Model, evidence: Evidence) -> np.ndarray:
    """(q, q) of the free parameters and the fitted shapes, by the fit's noise."""
    blocks, noises = evidence.fit.blocks, evidence.fit.noises
    if model.fitted_shapes:
        design = model.design(blocks.motion)
        misfit = blocks.readings - design.prediction
        normal, _, _ = equations_of(design.columns, misfit, blocks, noises).normal()
    else:
        rows = np.flatnonzero(model.free[evidence.fit.model.free])
        normal = evidence.whole.normal()[0][np.ix_(rows, rows)]
    prior = np.zeros(len(normal))
    prior[: int(model.free.sum())] = model.prior[model.free]
    return inverse(normal + np.diag(prior))
