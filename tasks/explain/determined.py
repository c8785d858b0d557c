"""The part of a fit that the recording determines; only this part is corrected for."""

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from schemas.discrepancy import FoundParameter
from tasks.explain.channels import CHANNELS
from tasks.model.model import Model
from tasks.model.term import Column, Parameter, TermKey
from tasks.motion.whole import Motion


@dataclass(frozen=True)
class DeterminedParameter:
    """A parameter of a term as it was taken off, SI.

    place: its row of the covariance; none where it was not fitted, and u is 0. held: at nothing,
    because it is not determined: then u is what it may be.
    """

    parameter: Parameter
    value: float
    u: float = 0.0
    place: int | None = None
    held: bool = False

    @property
    def found(self) -> FoundParameter:
        return self.parameter.found(self.value, self.u)


@dataclass(frozen=True)
class DeterminedModel:
    """A fitted model whose findings have those parameters alone that are known better than their
    size: the others are held at nothing, and all the rest was fitted without them.

    held: (p,) bool. covariance: (q, q) of the free parameters, those held included since they may
    be something, then of the fitted shapes, widened by what is left of the mismatch. motion: at
    the unit's rows; start: of its t = 0 on the recording's clock, s. axes: (6, 6) from readings
    put right to those that were recorded.
    """

    model: Model
    held: np.ndarray
    covariance: np.ndarray
    motion: Motion
    start: float = 0.0
    axes: np.ndarray = field(default_factory=lambda: np.eye(len(CHANNELS)))

    @cached_property
    def u(self) -> np.ndarray:
        """(q,) standard uncertainties."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    @cached_property
    def correlation(self) -> np.ndarray:
        """(q, q)"""
        scale = np.divide(1.0, self.u, out=np.zeros_like(self.u), where=self.u > 0.0)
        return np.asarray(self.covariance * scale[:, None] * scale)

    def contribution(self, keys: Collection[TermKey]) -> np.ndarray:
        """(n, 6) rad/s and m/s², what some terms add to the readings."""
        added = self.model.effect_of(keys, self.motion, self._prediction)
        return np.asarray(added @ self.axes.T)

    def parameters(self, keys: Collection[TermKey]) -> tuple[DeterminedParameter, ...]:
        """Of some terms: what was fitted, and the shapes, of which some were only tried."""
        model, found = self.model, list[DeterminedParameter]()
        free = np.flatnonzero(model.free).tolist()
        for k, term in enumerate(model.terms):
            if term.key not in keys:
                continue
            first = model.places[term.key].start
            for p, parameter in enumerate(term.parameters, first):
                if model.free[p]:
                    place, value = free.index(p), float(model.values[p])
                    held = bool(self.held[p])
                    u = float(self.u[place])
                    found.append(DeterminedParameter(parameter, value, u, place, held))
            for shape, value in zip(term.shapes, term.at, strict=True):
                value += self.start if shape.name == "time" else 0.0
                if k not in model.fitted_shapes:
                    found.append(DeterminedParameter(shape, value))
                    continue
                place = len(free) + model.fitted_shapes.index(k)
                found.append(DeterminedParameter(shape, value, float(self.u[place]), place))
        return tuple(found)

    def change(self, step: np.ndarray) -> np.ndarray:
        """(n, 6) by which the readings grow with a step (q,) of parameters and shapes.

        A time constant no better known than its size would be negative after the step back: the
        readings are then asked for a part of the step, and what they change by is scaled.
        """
        part = self._possible_part(step)
        more, less = (self._moved(way * part * step).prediction(self.motion) for way in (1.0, -1.0))
        return np.asarray((more - less) / (2.0 * part) @ self.axes.T)

    def columns(self, asked: np.ndarray) -> tuple[Column, ...]:
        """Readings per unit of the parameters at some rows (k,) of the covariance."""
        model, free = self.model, np.flatnonzero(self.model.free)
        wanted = np.zeros(len(model.free), bool)
        wanted[free[asked]] = True
        design = model.linearised(self.motion, wanted)
        return tuple(design.columns[p] for p in free[asked])

    def _possible_part(self, step: np.ndarray) -> float:
        """The part of a step either way after which each positive shape is half of what it was."""
        part = 1.0
        for k, more in self._shape_steps(step):
            term = self.model.terms[k]
            if term.shapes[0].plausible[0] >= 0.0 < term.at[0]:
                part = min(part, 0.5 * term.at[0] / abs(more))
        return part

    def _shape_steps(self, step: np.ndarray) -> list[tuple[int, float]]:
        """The terms whose fitted shape a step (q,) changes, and by how much."""
        shapes = step[int(self.model.free.sum()) :].tolist()
        pairs = zip(self.model.fitted_shapes, shapes, strict=True)
        return [(k, more) for k, more in pairs if more]

    def _moved(self, step: np.ndarray) -> Model:
        """The model with each parameter and fitted shape greater by a step (q,)."""
        model, free = self.model, np.flatnonzero(self.model.free)
        values, terms = model.values.copy(), list(model.terms)
        values[free] += step[: len(free)]
        for k, more in self._shape_steps(step):
            terms[k] = terms[k].shaped((terms[k].at[0] + more,))
        return replace(model, values=values, terms=tuple(terms))

    @cached_property
    def _prediction(self) -> np.ndarray:
        return self.model.prediction(self.motion)
