"""The standard's model and what was found, fitted together in their real, non-linear form.

Gauss and Newton's method in the transformed domain, where noise of S = w + b/f is independent
from coefficient to coefficient: generalised least squares, and its covariance holds for samples
that drift.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tasks.explain.inputs.blocks import Blocks
from tasks.explain.regression.equations import equations_of
from tasks.explain.regression.spectrum import Noise
from tasks.explain.search.candidates import Candidate
from tasks.model.regression import inverse
from tasks.model.simulate import linearise, predict
from tasks.model.term import Column, Term, nominal_values, parameters_of, places
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.model.terms.timing import TIME_OFFSET
from tasks.motion.whole import Motion

ROUNDS = 10
SETTLED = 0.02  # of a standard uncertainty: nothing moves any more
NO_GAIN = 0.01  # chi-squared that a step promises: what still moves is not determined
TermKey = tuple[str, int]
SHAPE_STEP = 0.02  # of a shape's value, to differentiate by it


@dataclass(frozen=True)
class Model:
    """Terms with their values, those that were fitted, and how well they are known.

    values: (p,) of all parameters; free: (p,) bool; covariance: (p, p), zero where not free.
    prior: (p,) precision that a random course's parameters have beforehand.
    shape_u: for each term the standard uncertainty of its continuous shape, else nothing.
    """

    terms: tuple[Term, ...]
    values: np.ndarray
    free: np.ndarray
    prior: np.ndarray
    covariance: np.ndarray
    shape_u: tuple[float | None, ...]

    @property
    def u(self) -> np.ndarray:
        """(p,) standard uncertainties; zero where not free."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    def with_free(self, term: Term) -> "Model":
        """The same values with one more term at its nominal values, all its parameters free."""
        count = len(term.parameters)
        size = len(self.values) + count
        return Model(
            (*self.terms, term),
            np.concatenate([self.values, nominal_values((term,))]),
            np.concatenate([self.free, np.ones(count, bool)]),
            np.concatenate([self.prior, np.zeros(count)]),
            np.zeros((size, size)),
            (*self.shape_u, None),
        )

    def without(self, some: Collection[TermKey]) -> "Model":
        """The same values with some terms taken out."""
        kept = [k for k, term in enumerate(self.terms) if term.key not in some]
        own = places(self.terms)
        rows = np.concatenate([np.arange(own[k].start, own[k].stop) for k in kept]).astype(int)
        return Model(
            tuple(self.terms[k] for k in kept), self.values[rows], self.free[rows],
            self.prior[rows], self.covariance[np.ix_(rows, rows)],
            tuple(self.shape_u[k] for k in kept),
        )  # fmt: skip


def whole_effect(model: Model, term: Term, motion: Motion, prediction: np.ndarray) -> Column:
    """What one term of a model adds to its prediction (n, 6), in every channel."""
    rest = model.without({term.key})
    effect = prediction - predict(rest.terms, motion, rest.values)
    return {channel: effect[:, channel] for channel in range(6)}


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
    values = nominal_values(tuple(terms))
    return Model(
        tuple(terms), values, np.concatenate(free), np.concatenate(prior),
        np.zeros((len(values), len(values))), (None,) * len(terms),
    )  # fmt: skip


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
    for _ in range(ROUNDS):
        shapes = _shaped(model)
        columns = _columns(model, observed, shapes)
        equations = equations_of(columns, _misfit(model, observed), observed, noises)
        normal, right, _ = equations.normal()
        rows = np.flatnonzero(model.free)
        beforehand = np.concatenate([model.prior[rows], np.zeros(len(shapes))])
        pulled = np.concatenate([model.prior[rows] * model.values[rows], np.zeros(len(shapes))])
        covariance = inverse(normal + np.diag(beforehand))
        step = covariance @ (right - pulled)
        u = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        stepped = _stepped(model, step, covariance, shapes)
        wrong = _of_wrong_sign(stepped)
        if wrong.any():  # the others' step made up for it: they are asked again
            model = _held_at_nothing(model, wrong)
            continue
        model = stepped
        if (np.abs(step) <= SETTLED * u + 1e-300).all() or step @ (right - pulled) < NO_GAIN:
            break
    return model


def _of_wrong_sign(model: Model) -> np.ndarray:
    """Parameters (p,) bool that no unit has below nothing, such as a time constant, and are."""
    lowest = np.array([p.plausible[0] for p in parameters_of(model.terms)])
    return np.asarray((lowest == 0.0) & (model.values < 0.0))


def _held_at_nothing(model: Model, some: np.ndarray) -> Model:
    """Some parameters (p,) bool are not there, and are no longer fitted."""
    left = ~some
    return replace(
        model,
        values=np.where(some, 0.0, model.values),
        free=model.free & left,
        covariance=model.covariance * left[:, None] * left,
    )


def _columns(model: Model, observed: Blocks, shapes: Sequence[int]) -> list[Column]:
    design = linearise(model.terms, observed.motion, model.values)
    columns = [design.columns[p] for p in np.flatnonzero(model.free)]
    return columns + [_shape_column(model, observed, k) for k in shapes]


def _misfit(model: Model, observed: Blocks) -> np.ndarray:
    return observed.readings - predict(model.terms, observed.motion, model.values)


def _shaped(model: Model) -> list[int]:
    """Terms with one continuous shape in whose columns there is something to differentiate."""
    own = places(model.terms)
    return [k for k, term in enumerate(model.terms) if term.bent and model.values[own[k]].any()]


def _shape_column(model: Model, observed: Blocks, k: int) -> Column:
    term = model.terms[k]
    step = SHAPE_STEP * max(abs(term.at[0]), 0.1)
    reads = []
    for sign in (1.0, -1.0):
        moved = list(model.terms)
        moved[k] = term.shaped((term.at[0] + sign * step,))
        reads.append(predict(tuple(moved), observed.motion, model.values))
    slope = (reads[0] - reads[1]) / (2.0 * step)
    return {c: slope[:, c] for c in range(6) if np.nan_to_num(slope[:, c]).any()}


def _stepped(
    model: Model, step: np.ndarray, covariance: np.ndarray, shapes: Sequence[int]
) -> Model:
    rows = np.flatnonzero(model.free)
    values, whole = model.values.copy(), np.zeros_like(model.covariance)
    values[rows] += step[: len(rows)]
    whole[np.ix_(rows, rows)] = covariance[: len(rows), : len(rows)]
    terms, shape_u = list(model.terms), list(model.shape_u)
    for n, k in enumerate(shapes, len(rows)):
        now = terms[k].at[0]
        low, high = terms[k].shapes[0].plausible
        most = 0.5 * max(abs(now), 0.1)
        to = float(np.clip(now + np.clip(step[n], -most, most), low, high))
        terms[k] = terms[k].shaped((to,))
        shape_u[k] = float(np.sqrt(covariance[n, n]))
    return replace(
        model, terms=tuple(terms), values=values, covariance=whole, shape_u=tuple(shape_u)
    )


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
            effect = whole_effect(model, candidate.term, observed.motion, design.prediction)
            columns[candidate.members[0]] = effect
            readings = readings + np.column_stack(list(effect.values()))
            continue
        for p, q in zip(candidate.members, candidate.own, strict=True):
            column = design.columns[own[k].start + q]
            columns[p] = column
            for channel, course in column.items():
                readings[:, channel] += model.values[own[k].start + q] * course
    return columns, np.nan_to_num(readings)
