"""The standard's model and what was found, fitted together in their real, non-linear form.

In the transformed domain noise of S = w + b/f is independent from coefficient to coefficient:
generalised least squares, whose covariance holds for samples that drift.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tasks.explain.inputs.blocks import Blocks
from tasks.explain.regression.equations import whitening
from tasks.explain.regression.spectrum import Noise
from tasks.explain.search.candidates import Candidate
from tasks.model.gauss_newton import Step, gauss_newton
from tasks.model.model import Model
from tasks.model.simulate import linearise
from tasks.model.term import Column, Term, nominal_values, places
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.model.terms.timing import TIME_OFFSET

MAX_STEPS = 10
SETTLED = 0.02  # of a standard uncertainty: nothing moves any more
NO_GAIN = 0.01  # chi-squared that a step promises: what still moves is not determined


def model_of(chosen: Sequence[tuple[Candidate, np.ndarray]], observed: Blocks) -> Model:
    """The standard's model at its ideal values and the chosen terms at nothing.

    chosen: candidates with the prior precision (m,) of their parameters, zero for most. What the
    recording gives the standard's model nothing to determine by (a scale factor where nothing
    turned) stays as an ideal unit has it.
    """
    terms: list[Term] = list(STANDARD_TERMS)
    ideal = linearise(STANDARD_TERMS, observed.motion, nominal_values(STANDARD_TERMS)).columns
    seen = np.array([_seen(column, observed.weight) for column in ideal])
    free = [seen[place] for place in places(STANDARD_TERMS)]
    prior = [np.zeros(len(term.parameters)) for term in terms]
    for candidate, precision in chosen:
        same = [k for k, term in enumerate(terms) if term.key == candidate.term.key]
        if not same:
            terms.append(candidate.term)
            free.append(np.zeros(len(candidate.term.parameters), bool))
            widths = [high - low for low, high in (p.plausible for p in candidate.term.parameters)]
            prior.append(4.0 / np.array(widths) ** 2)
            same = [len(terms) - 1]
        if candidate.term.parameters:
            free[same[0]][list(candidate.own)] = True
            prior[same[0]][list(candidate.own)] += precision
    return Model.of(tuple(terms), free=np.concatenate(free), prior=np.concatenate(prior))


def _seen(column: Column, weight: np.ndarray) -> bool:
    return any(np.nan_to_num(course * weight[:, c]).any() for c, course in column.items())


def with_values_of(model: Model, before: Model) -> Model:
    """The model with the values that an earlier one had for the same terms."""
    values = model.values.copy()
    earlier = dict(zip((term.key for term in before.terms), places(before.terms), strict=True))
    for term, place in zip(model.terms, places(model.terms), strict=True):
        if term.key in earlier:
            values[place] = before.values[earlier[term.key]]
    return replace(model, values=np.where(model.free, values, model.values))


def with_later_clock(model: Model, late: float) -> Model:
    """The model with a clock that is `late` seconds later still."""
    values = model.values.copy()
    for term, place in zip(model.terms, places(model.terms), strict=True):
        if term.name == TIME_OFFSET.name:
            values[place] += late
    return replace(model, values=values)


def fitted(model: Model, observed: Blocks, noises: Sequence[Noise]) -> Model:
    """The model with its free parameters and continuous shapes fitted.

    noises: of a coefficient at the observed rate.
    """
    whiten = whitening(observed, noises)
    return gauss_newton(model, observed.motion, observed.readings, whiten, _settled, MAX_STEPS)[0]


def _settled(model: Model, step: Step) -> bool:
    moves = np.abs(step.change) > SETTLED * step.u + 1e-300
    return not moves.any() or step.gain < NO_GAIN


def linearised(
    model: Model, observed: Blocks, chosen: Sequence[Candidate]
) -> tuple[dict[int, Column], np.ndarray]:
    """Columns of the chosen candidates' parameters (by their number in the pool) where the fit put
    them, and the readings (n, 6) that a linear model of these columns would have had.
    """
    design = linearise(model.terms, observed.motion, model.values)
    readings = observed.readings - design.prediction
    own = places(model.terms)
    columns: dict[int, Column] = {}
    for candidate in chosen:
        k = next(n for n, term in enumerate(model.terms) if term.key == candidate.term.key)
        if candidate.known:
            effect = model.effect_of(candidate.term, observed.motion, design.prediction)
            columns[candidate.members[0]] = effect
            readings = readings + np.column_stack(list(effect.values()))
            continue
        for p, q in zip(candidate.members, candidate.own, strict=True):
            column = design.columns[own[k].start + q]
            columns[p] = column
            for channel, course in column.items():
                readings[:, channel] += model.values[own[k].start + q] * course
    return columns, np.nan_to_num(readings)
