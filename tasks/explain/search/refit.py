"""Fits the standard's model and the selected terms together in their exact, non-linear form.

In the transformed domain noise of S = w + b/f is independent from coefficient to coefficient:
generalised least squares, whose covariance holds for samples that drift.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tasks.explain.inputs.blocks import Blocks
from tasks.explain.search.candidates import Candidate
from tasks.explain.whitening import Noise, equations_of, scores_of
from tasks.model.gauss_newton import Step, gauss_newton
from tasks.model.model import Model
from tasks.model.regression import WhitenedEquations
from tasks.model.term import Column, Term
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.model.terms.timing import TIME_OFFSET

MAX_STEPS = 10
SETTLED = 0.02  # of a standard uncertainty: nothing moves any more
NO_GAIN = 0.01  # chi-squared that a step promises: what still moves is not determined


def model_of(selected: Sequence[tuple[Candidate, np.ndarray]], blocks: Blocks) -> Model:
    """The standard's model at its ideal values and the selected terms at nothing.

    selected: candidates with the prior precision (m,) of their parameters, zero for most. What the
    recording does not let the standard's model determine (a scale factor where nothing turned)
    stays as an ideal unit has it.
    """
    terms: list[Term] = list(STANDARD_TERMS)
    ideal = Model.of(STANDARD_TERMS)
    columns = ideal.linearised(blocks.motion).columns
    observable = np.array([_observable(column, blocks.weight) for column in columns])
    free = {key: observable[place] for key, place in ideal.places.items()}
    prior = {key: np.zeros(len(own)) for key, own in free.items()}
    for candidate, precision in selected:
        term = candidate.term
        if term.key not in free:
            terms.append(term)
            free[term.key] = np.zeros(len(term.parameters), bool)
            prior[term.key] = np.array([4.0 / np.ptp(p.plausible) ** 2 for p in term.parameters])
        if term.parameters:
            free[term.key][list(candidate.own)] = True
            prior[term.key][list(candidate.own)] += precision
    return Model.of(
        tuple(terms), free=np.concatenate([*free.values()]), prior=np.concatenate([*prior.values()])
    )


def _observable(column: Column, weight: np.ndarray) -> bool:
    return any(np.nan_to_num(signal * weight[:, c]).any() for c, signal in column.items())


def with_later_clock(model: Model, delay: float) -> Model:
    """The model with a clock that is `delay` seconds later still."""
    values = model.values.copy()
    for (name, _), place in model.places.items():
        if name == TIME_OFFSET.name:
            values[place] += delay
    return replace(model, values=values)


def fitted(model: Model, blocks: Blocks, noises: Sequence[Noise]) -> Model:
    """The model with its free parameters and continuous shapes fitted.

    noises: of a coefficient at the blocks' rate.
    """

    def whiten(columns: Sequence[Column], misfit: np.ndarray) -> WhitenedEquations:
        return equations_of(columns, misfit, blocks, noises)

    def scores(columns: Sequence[Column], misfit: np.ndarray) -> tuple[np.ndarray, float]:
        return scores_of(columns, misfit, blocks, noises)

    motion, readings = blocks.motion, blocks.readings
    settled = _Settled(blocks.used)
    return gauss_newton(model, motion, readings, whiten, settled, MAX_STEPS, scores)[0]


class _Settled:
    """Whether nothing moves any more beside its standard uncertainty, or promises to gain.

    Nor need what is so nearly linear be linearised again that the first step with the columns of
    the one before it has nothing left to do.
    """

    def __init__(self, used: int) -> None:
        """used: number of readings."""
        self.used = used
        self.first: Step | None = None  # with the present columns
        self.tried, self.nearly_linear = 0, False

    def __call__(self, model: Model, step: Step) -> bool:
        if self.first is None or step.columns is not self.first.columns:
            self.first, self.tried, self.nearly_linear = step, 0, False
        elif step.change is self.first.change:
            return self.nearly_linear or self._small(step)
        else:
            self.tried += 1
            self.nearly_linear = self.tried == 1 and self._small(step, SETTLED**2)
        return self._small(step)

    def _small(self, step: Step, no_gain: float = NO_GAIN) -> bool:
        # u is as much larger as the model is wrong
        dispersion = max(1.0, step.misfit / self.used)
        moves = np.abs(step.change) > SETTLED * np.sqrt(dispersion) * step.u + 1e-300
        return not moves.any() or step.gain < no_gain * dispersion


def linearised(
    model: Model, blocks: Blocks, selected: Sequence[Candidate]
) -> tuple[dict[int, Column], np.ndarray]:
    """Columns of the selected candidates' parameters (by their number in the design) where the fit
    put them, and the readings (n, 6) that a linear model of these columns would have had.
    """
    own, columns = model.places, dict[int, Column]()
    wanted = np.zeros(len(model.values), bool)
    for candidate in (one for one in selected if not one.known):
        wanted[[own[candidate.term.key].start + q for q in candidate.own]] = True
    design = model.linearised(blocks.motion, wanted)
    readings = blocks.readings - design.prediction
    for candidate in selected:
        if candidate.known:
            effect = model.effect_of({candidate.term.key}, blocks.motion, design.prediction)
            columns[candidate.members[0]] = dict(enumerate(effect.T))
            readings = readings + effect
            continue
        first = own[candidate.term.key].start
        for p, q in zip(candidate.members, candidate.own, strict=True):
            columns[p] = design.columns[first + q]
            for channel, signal in columns[p].items():
                readings[:, channel] += model.values[first + q] * signal
    return columns, _known_without(readings, model, blocks, selected)


def _known_without(
    readings: np.ndarray, model: Model, blocks: Blocks, selected: Sequence[Candidate]
) -> np.ndarray:
    """The linear model's readings (n, 6), where the candidates are unknown those beside the rest.

    As beside a gap, where what happened before is not known: their columns say nothing there, but
    those of the standard's model do.
    """
    if not (np.isnan(readings) & (blocks.weight > 0.0)).any():
        return np.nan_to_num(readings)
    rest = model.without({one.term.key for one in selected})
    beside = blocks.readings - rest.prediction(blocks.motion)
    return np.nan_to_num(np.where(np.isnan(readings), beside, readings))
