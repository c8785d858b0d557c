"""A model that is linearised again and again about nearly the same values, as a fit does.

What is felt changes by a small rotation, a lever arm and the like in proportion to their
parameters. So what is felt per unit of each is computed once, from the motion that was reported,
and kept as long as it says what the terms do with their values; else the readings are
differentiated anew, as `tasks.model.simulate` does.
"""

from collections.abc import Collection
from dataclasses import dataclass, field, fields

import numpy as np

from tasks.model.model import Model
from tasks.model.simulate import CHANNEL_COUNT, STANDARD, STEP, Design
from tasks.model.term import Column, Inputs, Term, TermKey, parameters_of
from tasks.motion.whole import Motion

ROUNDING = 1e-9  # rad/s, m/s²: of derivatives times what their parameters are
LINEAR = 0.01  # of what terms change of what is felt: columns that err by less are good enough


@dataclass(frozen=True)
class Derivatives:
    """What is felt, (n, 6) rate and force, per unit of each parameter of motion and input.

    by_shape: what was computed so far, by term, shape and number of the parameter.
    """

    motion: Motion
    by_shape: dict[tuple[TermKey, tuple[float, ...], int], np.ndarray] = field(default_factory=dict)

    def of(self, term: Term, number: int) -> np.ndarray:
        """Of one parameter of a term that acts alone."""
        shape = term.key, term.at, number
        if shape not in self.by_shape:
            low, high = term.parameters[number].plausible
            values = np.zeros(len(term.parameters))
            values[number] = STEP * (high - low)
            more, less = (felt((term,), self.motion, side)[1] for side in (values, -values))
            self.by_shape[shape] = (_both(more) - _both(less)) / (2.0 * values[number])
        return self.by_shape[shape]


def felt(terms: tuple[Term, ...], motion: Motion, values: np.ndarray) -> tuple[Motion, Inputs]:
    """The real motion and what the sensors feel of it, each term acting on those before it."""
    own = Model.of(terms).places
    for term in terms:
        motion = term.moved(motion, values[own[term.key]])
    inputs = Inputs.of(motion)
    for term in terms:
        inputs = term.felt(motion, inputs, values[own[term.key]])
    return motion, inputs


def _both(inputs: Inputs) -> np.ndarray:
    return np.hstack([inputs.rate, inputs.force])


@dataclass(frozen=True)
class FittedModel(Model):
    """A model that is fitted on the motion of `derivatives`."""

    derivatives: Derivatives = field(kw_only=True)

    @classmethod
    def of_model(cls, model: Model, derivatives: Derivatives) -> "FittedModel":
        """Any model with these derivatives."""
        own = {each.name: getattr(model, each.name) for each in fields(Model)}
        return cls(**own, derivatives=derivatives)

    def without(self, some: Collection[TermKey]) -> "FittedModel":
        """As `Model.without` has it."""
        return self.of_model(super().without(some), self.derivatives)

    def with_term(self, term: Term) -> "FittedModel":
        """As `Model.with_term` has it."""
        return self.of_model(super().with_term(term), self.derivatives)

    def linearised(self, motion: Motion, wanted: np.ndarray | None = None) -> Design:
        """Prediction and columns, those of motion and input by the derivatives where they hold."""
        wanted = np.ones(len(self.values), bool) if wanted is None else wanted
        kept = self._kept(wanted) if motion is self.derivatives.motion else {}
        rest = wanted.copy()
        rest[list(kept)] = False
        design = super().linearised(motion, rest)
        columns = list(design.columns)
        for p, slope in kept.items():
            columns[p] = slope
        return Design(design.prediction, tuple(columns))

    def _kept(self, wanted: np.ndarray) -> dict[int, Column]:
        """Readings per unit of the parameters of motion and input among those that are wanted,
        through the standard's terms only; empty where the derivatives do not hold.
        """
        own, motion = self.places, self.derivatives.motion
        acting = tuple(term for term in self.terms if term.stage in ("motion", "input"))
        number = {
            p: (term, p - own[term.key].start)
            for term in acting
            for p in range(own[term.key].start, own[term.key].stop)
        }
        asked = [p for p in number if wanted[p]]
        if not asked:
            return {}
        values = np.concatenate([self.values[own[term.key]] for term in acting])
        moved, inputs = felt(acting, motion, values)
        nothing = _both(felt(acting, motion, np.zeros(len(values)))[1])
        change = sum(self.values[p] * self.derivatives.of(*number[p])
                     for p in number if self.values[p])  # fmt: skip
        now = _both(inputs)
        size, error = (np.nan_to_num(np.abs(each)).max(axis=0)
                       for each in (now - nothing, now - nothing - change))  # fmt: skip
        if (error > LINEAR * size + ROUNDING).any():
            return {}
        read = self._standard(moved, now)
        ranges = [high - low for low, high in (p.plausible for p in parameters_of(self.terms))]
        return {p: self._slope(moved, now, read, self.derivatives.of(*number[p]), STEP * ranges[p])
                for p in asked}  # fmt: skip

    def _slope(
        self, motion: Motion, now: np.ndarray, read: np.ndarray, change: np.ndarray, step: float
    ) -> Column:
        """Readings per unit of what changes the inputs (n, 6) so."""
        slope = (self._standard(motion, now + step * change) - read) / step
        slope = np.where(self.derivatives.motion.felt, slope, np.nan)
        own = self.places
        for term in self.terms:
            slope = term.passed(motion, slope, self.values[own[term.key]])
        return {c: slope[:, c] for c in range(CHANNEL_COUNT) if slope[:, c].any()}

    def _standard(self, motion: Motion, inputs: np.ndarray) -> np.ndarray:
        """(n, 6) what the standard's terms read of inputs (n, 6)."""
        readings, own = np.zeros((CHANNEL_COUNT, len(inputs))), self.places
        for term in self.terms:
            if term.family == STANDARD:
                columns = term.columns(motion, Inputs(inputs[:, :3], inputs[:, 3:]))
                for value, column in zip(self.values[own[term.key]], columns, strict=True):
                    for channel, each in column.items():
                        readings[channel] += value * each
        return readings.T
