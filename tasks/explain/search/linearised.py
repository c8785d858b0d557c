"""A model that is linearised again and again about nearly the same values, as a fit does.

What is felt changes by a small rotation, a lever arm and the like in proportion to their
parameters. So what is felt per unit of each is computed once, about some values of all of them, and
kept as long as it says what the terms do at the values that they have now; else it is computed
about these.
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
Shape = tuple[TermKey, tuple[float, ...]]


@dataclass
class Derivatives:
    """What is felt, (n, 6) rate and force, per unit of each parameter of motion and input.

    about: the terms and their values about which that is; felt: with these.
    by_shape: what was computed so far, by shape and number of the parameter.
    """

    motion: Motion
    about: dict[Shape, tuple[Term, np.ndarray]] = field(default_factory=dict)
    felt: np.ndarray | None = None
    by_shape: dict[tuple[Shape, int], np.ndarray] = field(default_factory=dict)

    def at(self, acting: dict[Shape, tuple[Term, np.ndarray]]) -> tuple[Motion, np.ndarray]:
        """The real motion and what is felt with these terms and values, about which the derivatives
        hold from now on.
        """
        moved, inputs = felt(acting, self.motion)
        if self.felt is None or not self._hold(acting, inputs, self.felt):
            self.about, self.felt = acting, inputs
            self.by_shape.clear()
        return moved, inputs

    def of(self, term: Term, number: int) -> np.ndarray:
        """Of one parameter of a term, beside the others."""
        shape = term.key, term.at
        if (shape, number) not in self.by_shape:
            low, high = term.parameters[number].plausible
            step = np.zeros(len(term.parameters))
            step[number] = STEP * (high - low)
            _, values = self.about.get(shape, (term, np.zeros(len(step))))
            more, less = (
                felt({**self.about, shape: (term, values + side)}, self.motion)[1]
                for side in (step, -step)
            )
            self.by_shape[shape, number] = (more - less) / (2.0 * step[number])
        return self.by_shape[shape, number]

    def _hold(
        self, acting: dict[Shape, tuple[Term, np.ndarray]], inputs: np.ndarray, before: np.ndarray
    ) -> bool:
        """Whether they say what is felt with these terms and values; before: with the others."""
        known = [{shape for shape, (term, _) in some.items() if not term.parameters}
                 for some in (acting, self.about)]  # fmt: skip
        if known[0] != known[1]:
            return False
        change = np.zeros_like(inputs)
        for shape, (term, _) in (self.about | acting).items():
            nothing = term, np.zeros(len(term.parameters))
            now, then = acting.get(shape, nothing)[1], self.about.get(shape, nothing)[1]
            for number in np.flatnonzero(now != then).tolist():
                change += (now - then)[number] * self.of(term, number)
        size, error = (np.nan_to_num(np.abs(each)).max(axis=0)
                       for each in (inputs - before, inputs - before - change))  # fmt: skip
        return not (error > LINEAR * size + ROUNDING).any()


def felt(acting: dict[Shape, tuple[Term, np.ndarray]], motion: Motion) -> tuple[Motion, np.ndarray]:
    """The real motion and what the sensors feel of it, (n, 6) rate and force, each term acting on
    those before it.
    """
    for term, values in acting.values():
        motion = term.moved(motion, values)
    inputs = Inputs.of(motion)
    for term, values in acting.values():
        inputs = term.felt(motion, inputs, values)
    return motion, np.hstack([inputs.rate, inputs.force])


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
        """Prediction and columns, those of motion and input by the derivatives."""
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
        through the standard's terms only.
        """
        own = self.places
        acting = {
            (term.key, term.at): (term, self.values[own[term.key]].copy())
            for term in self.terms
            if term.stage in ("motion", "input")
        }
        asked = {p: (term, number) for term, _ in acting.values()
                 for number, p in enumerate(range(own[term.key].start, own[term.key].stop))
                 if wanted[p]}  # fmt: skip
        if not asked:
            return {}
        moved, now = self.derivatives.at(acting)
        read = self._standard(moved, now)
        ranges = [np.ptp(parameter.plausible) for parameter in parameters_of(self.terms)]
        return {p: self._slope(moved, now, read, self.derivatives.of(*one), STEP * ranges[p])
                for p, one in asked.items()}  # fmt: skip

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
