"""The result of `explain` as arrays; its report in words is a discrepancy."""

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import log
from typing import Literal

import numpy as np

from schemas.discrepancy import FoundParameter, HeldOut, Verdict
from schemas.recording import ACCEL, GYRO, Recording
from tasks.model.model import Model
from tasks.model.term import Column, Parameter, TermKey
from tasks.motion.whole import Motion
from tasks.words import Sayable, message

# The channels by number: three gyros, then three accelerometers.

CHANNELS = GYRO + ACCEL
GYROS, ACCELS = (0, 1, 2), (3, 4, 5)
EVERY = GYROS + ACCELS
TRIADS = (GYROS, ACCELS)


# The part of a fit that the recording determines; only this part is corrected for.


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


UNNAMED = "unnamed"
FITTED = message("explain-model-fitted")

Partition = Literal["time", "rate", "up", "triad", "axis"]
RefusalKind = Literal[
    "implausible",
    "inhomogeneous",
    "channel_worse",
    "undetermined",
    "overshadowed",
    "form_error",
    "reference_noise",
    "placed",
    "switching",
]


@dataclass(frozen=True)
class Refusal:
    """Why a catalogue name was withdrawn from a finding, and the numbers that speak against it.

    kind: implausible: a parameter's `value` lies beyond the plausible `limit`. inhomogeneous: it
    runs from `smallest` to `largest` in different `parts` of the recording. channel_worse: the
    `channel` (0 to 5) that its equation touches is predicted worse with it, by `value` nats.
    undetermined: no parameter is larger than its U; `value`, `limit`: the clearest and its U.
    overshadowed: what stays unexplained in its channels is `value` times what it removes, and up
    to `limit` times the noise's variance.
    form_error: what else was found there has `value` times its evidence, and forms of its own.
    reference_noise: it fits no better than what makes the reference's own noise smaller.
    placed: labels alone tell `value` positions, and it has a parameter for all that they leave.
    switching: a random walk that changes at two moments, and hardly between.
    name: the catalogue's. parameter: the one in question, its numbers in `unit` (SI).
    parts: what divides the recording: time, rate, upward axis, triad, axis.
    """

    kind: RefusalKind
    name: str
    parameter: str | None = None
    unit: str = "1"
    value: float | None = None
    limit: float | None = None
    smallest: float | None = None
    largest: float | None = None
    channel: int | None = None
    parts: Partition | None = None


@dataclass(frozen=True, eq=False)
class Finding:
    """One piece of physics that the model left out.

    effect: its catalogue name, or UNNAMED. channels: indices 0 to 5 of those that show it.
    contribution: (n, 6) rad/s and m/s², what it adds to the readings, at the unit's rows.
    gain: chi-squared that it explains beyond all the rest, counted against what is left.
    share: of the mismatch above noise that it removes. homogeneity_p: that its parameters are the
    same in all parts of the recording; None where no parts determine them. group: catalogue names
    that make up for each other here, its own included; common: what their combinations have in
    common. terms: keys of its terms in the explanation's determined model; an event has none.
    refusal: why its name was withdrawn. behaviour: what it is called without a name; empty
    for physics that is known beforehand. unlisted: in a form that no publication lists. remainder:
    it is what nothing explains, and removes none.
    """

    effect: str
    family: str
    title: Sayable
    equation: str
    source: str
    channels: tuple[int, ...]
    parameters: tuple[FoundParameter, ...]
    contribution: np.ndarray
    gain: float
    delta_bic: float
    held_out_gain: float
    indistinguishable: tuple[str, ...] = ()
    separated_by: Sayable | None = None
    share: float = 0.0
    homogeneity_p: float | None = None
    group: tuple[str, ...] = ()
    common: tuple[FoundParameter, ...] = ()
    refusal: Refusal | None = None
    terms: tuple[TermKey, ...] = ()
    behaviour: Sayable = ""
    unlisted: bool = False
    remainder: bool = False

    @property
    def follows(self) -> Sayable | None:
        """What an unnamed finding follows, which is all that it is called by."""
        return self.title if self.effect == UNNAMED else None


@dataclass(frozen=True)
class Explanation:
    """Everything that `explain` found in one recording.

    nominal, found: (n, 6) predicted readings at the unit's rows, without and with the findings;
    NaN where the motion is not known. noise: (6,) standard deviation of one sample at rest.
    p_value: of the strongest mismatch, corrected for how many were looked for.
    findings: ordered by share. model: what `nominal` is of. left_over: (6,) chi-squared per degree
    of freedom of what is left after all of them, against the sensor's noise at rest; NaN where a
    channel was not recorded. explained_share: of the mismatch above noise. small: findings that
    remove less of it than a stated share. determined: the model by which findings are taken off.
    """

    recording: Recording
    nominal: np.ndarray
    found: np.ndarray
    noise: np.ndarray
    p_value: float
    verdict: Verdict
    held_out: HeldOut
    findings: tuple[Finding, ...]
    remarks: tuple[Sayable, ...] = ()
    model: Sayable = FITTED
    left_over: np.ndarray = field(default_factory=lambda: np.full(6, np.nan))
    explained_share: float = 0.0
    small: tuple[Finding, ...] = ()
    determined: DeterminedModel | None = None

    @property
    def by_name(self) -> dict[str, Finding]:
        """The findings that have a name, by each name that they may bear; the largest goes first.

        Of small remainders too: what is told in one line is as well determined.
        """
        named = [one for one in (*self.findings, *self.small) if one.effect != UNNAMED]
        own = {one.effect: one for one in reversed(named)}
        return {name: one for one in reversed(named) for name in one.group} | own


# How sure a name must be, and how exactly a form is known.
#
# Evidence is twice the logarithm of odds, which adds to chi-squared. Data of one model favour
# another by a likelihood ratio k with a probability of 1/k at most (Royall, Statistical Evidence,
# 1997, section 1.4): by so much to name one alone. What a form lacks is a random effect of a
# variance in proportion to what the form explains; beside it evidence counts less.

COVERAGE = 2.0  # standard uncertainties in U
CERTAIN = 2.0 * log(99.0)  # of a share of 0.99: what differs by less cannot be told apart
PUBLISHED = 0.03  # relative: by which units depart from a published equation
UNPUBLISHED = 0.12  # the same of what is called by its behaviour, or not found
UNKNOWN = 0.5  # the same of what has no name, along a name in the same readings


def as_likely_within(gain: float) -> float:
    """By how much the evidence of another name may be less than that of a name that gains so much
    chi-squared by a published form, and the two cannot be told apart.
    """
    return CERTAIN * (1.0 + PUBLISHED**2 * max(gain, 0.0))
