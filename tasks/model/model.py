"""A list of terms with the values of their parameters and their covariance."""

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tasks.model.term import Column, Inputs, Term, TermKey, nominal_values, parameters_of, places
from tasks.motion.whole import Motion

# Predicts the readings by a list of terms, and their derivatives by each parameter.

CHANNEL_COUNT = 6  # gyro x, y, z in rad/s, then accelerometer x, y, z in m/s²
STANDARD = "standard"  # family of the terms of models (1) and (2)
STEP = 1e-3  # of the plausible range, to differentiate by a parameter of motion or input


def predict(terms: tuple[Term, ...], motion: Motion, values: np.ndarray) -> np.ndarray:
    """Readings (n, 6) in rad/s and m/s² of a unit with the parameter values (p,)."""
    return _passed(terms, motion, _sensed(terms, motion, values), values)


def _sensed(terms: tuple[Term, ...], motion: Motion, values: np.ndarray) -> np.ndarray:
    """Readings (n, 6) of the sensors, before delays and filters; NaN where they feel unknowns."""
    moved, inputs = _felt(terms, motion, values)
    readings = np.zeros((CHANNEL_COUNT, len(motion.t)))
    for term, place in zip(terms, places(terms), strict=True):
        if term.stage == "sensor" and _has_size(term, values[place]):
            _add(readings, values[place], term.columns(moved, inputs))
    return np.where(motion.felt, readings.T, np.nan)


def _has_size(term: Term, values: np.ndarray) -> bool:
    """Whether it adds anything; the standard's terms always say where the motion is not known."""
    return term.family == STANDARD or bool(values.any())


def _add(readings: np.ndarray, values: np.ndarray, columns: tuple[Column, ...]) -> None:
    """Adds columns times their values to readings (6, n)."""
    for value, column in zip(values, columns, strict=True):
        for channel, readout in column.items():
            readings[channel] += value * readout


@dataclass(frozen=True)
class Design:
    """A model linearised at some values.

    prediction: (n, 6). columns: for each parameter the readings per unit of it, by channel.
    """

    prediction: np.ndarray
    columns: tuple[Column, ...]


def linearise(
    terms: tuple[Term, ...],
    motion: Motion,
    values: np.ndarray,
    wanted: np.ndarray | None = None,
) -> Design:
    """Prediction and columns at the values (p,).

    The response of a sensor to its input is linear in its parameters; parameters of motion, input
    and signal are differentiated by central differences, exact for quadratic functions. wanted:
    (p,) bool, parameters whose columns are requested; those of the others are empty.
    """
    moved, inputs = _felt(terms, motion, values)
    wanted = np.ones(len(values), bool) if wanted is None else wanted
    columns: list[Column] = []
    readings = np.zeros((CHANNEL_COUNT, len(motion.t)))
    differences = _Differences(terms, motion, values)
    for term, place in zip(terms, places(terms), strict=True):
        asked = wanted[place]
        if term.stage != "sensor":
            rows = range(place.start, place.stop)
            columns.extend(differences.column(term, p) if wanted[p] else {} for p in rows)
        elif asked.any() or _has_size(term, values[place]):
            own = term.columns(moved, inputs)
            _add(readings, values[place], own)
            kept = tuple(one if ask else {} for one, ask in zip(own, asked, strict=True))
            columns.extend(_passed_columns(terms, motion, kept, values))
        else:
            columns.extend({} for _ in asked)
    return Design(_passed(terms, motion, readings.T, values), tuple(columns))


def shape_column(
    terms: tuple[Term, ...], motion: Motion, values: np.ndarray, k: int, step: float
) -> Column:
    """Readings per unit of a term's one shape, by central differences of a step.

    A sensor's readings differ by its own columns alone.
    """
    shaped = [terms[k].shaped((terms[k].at[0] + sign * step,)) for sign in (1.0, -1.0)]
    reads = []
    if terms[k].stage == "sensor":
        moved, inputs = _felt(terms, motion, values)
        for term in shaped:
            readings = np.zeros((CHANNEL_COUNT, len(motion.t)))
            _add(readings, values[places(terms)[k]], term.columns(moved, inputs))
            reads.append(readings.T)
        slope = _passed(terms, motion, (reads[0] - reads[1]) / (2.0 * step), values)
    else:
        reads = [predict((*terms[:k], term, *terms[k + 1 :]), motion, values) for term in shaped]
        slope = (reads[0] - reads[1]) / (2.0 * step)
    return {c: slope[:, c] for c in range(CHANNEL_COUNT) if np.nan_to_num(slope[:, c]).any()}


def _felt(terms: tuple[Term, ...], motion: Motion, values: np.ndarray) -> tuple[Motion, Inputs]:
    """The real motion and what the sensors feel of it, each term acting on those before it."""
    placed = tuple(zip(terms, places(terms), strict=True))
    for term, place in placed:
        motion = term.moved(motion, values[place])
    inputs = Inputs.of(motion)
    for term, place in placed:
        inputs = term.felt(motion, inputs, values[place])
    return motion, inputs


def _passed(
    terms: tuple[Term, ...], motion: Motion, readings: np.ndarray, values: np.ndarray
) -> np.ndarray:
    for term, place in zip(terms, places(terms), strict=True):
        readings = term.passed(motion, readings, values[place])
    return readings


def _passed_columns(
    terms: tuple[Term, ...], motion: Motion, columns: tuple[Column, ...], values: np.ndarray
) -> list[Column]:
    """The columns after delays and filters, which are linear in the readings.

    These act on each channel separately: columns of different channels pass through them together.
    """
    if all(term.stage != "signal" for term in terms):
        return list(columns)
    behind: list[dict[int, np.ndarray]] = [{} for _ in columns]
    for together in _side_by_side(columns):
        readings = np.zeros((len(motion.t), CHANNEL_COUNT))
        for channel, p in together.items():
            readings[:, channel] = columns[p][channel]
        readings = _passed(terms, motion, readings, values)
        for channel, p in together.items():
            behind[p][channel] = readings[:, channel]
    return list(behind)


def _side_by_side(columns: tuple[Column, ...]) -> list[dict[int, int]]:
    """Which column stands in each channel, in as few sets of readings as hold them all."""
    readers: list[list[int]] = [[] for _ in range(CHANNEL_COUNT)]
    for p, column in enumerate(columns):
        for channel in column:
            readers[channel].append(p)
    count = max(map(len, readers))
    return [
        {channel: own[k] for channel, own in enumerate(readers) if k < len(own)}
        for k in range(count)
    ]


class _Differences:
    """Central differences of the readings by parameters of motion, input and signal.

    Through the standard's terms only: the response of other sensor terms to a small change of their
    input is of second order, and an iteration does without it.
    """

    def __init__(self, terms: tuple[Term, ...], motion: Motion, values: np.ndarray) -> None:
        own = places(terms)
        kept = [k for k, term in enumerate(terms)
                if term.stage != "sensor" or term.family == STANDARD]  # fmt: skip
        self.rows = np.concatenate([np.arange(own[k].start, own[k].stop) for k in kept])
        self.terms, self.values = tuple(terms[k] for k in kept), values[self.rows]
        self.motion = motion

    def column(self, term: Term, p: int) -> Column:
        """Readings per unit of parameter p of a term, in the channels that follow it.

        Delays and filters are linear in the readings: what the sensors read differs before them.
        """
        k = int(np.flatnonzero(self.rows == p)[0])
        low, high = parameters_of(self.terms)[k].plausible
        step = STEP * (high - low)
        more, less = self.values.copy(), self.values.copy()
        more[k], less[k] = more[k] + step, less[k] - step
        terms, motion = self.terms, self.motion
        if term.stage == "signal":
            reads = [_passed(terms, motion, self._sensed, values) for values in (more, less)]
            slope = (reads[0] - reads[1]) / (2.0 * step)
        else:
            reads = [_sensed(terms, motion, values) for values in (more, less)]
            slope = _passed(terms, motion, (reads[0] - reads[1]) / (2.0 * step), self.values)
        return {c: slope[:, c] for c in range(CHANNEL_COUNT) if slope[:, c].any()}

    @cached_property
    def _sensed(self) -> np.ndarray:
        """(n, 6) which no delay or filter changes."""
        return _sensed(self.terms, self.motion, self.values)


SHAPE_STEP = 0.02  # of a shape's value, to differentiate by it


@dataclass(frozen=True)
class Model:
    """Terms with their values, those that are fitted, and how well they are known.

    values: (p,) of all parameters, SI; free: (p,) bool; covariance: (p, p), zero where not free.
    prior: (p,) precision that the parameters have beforehand, about zero.
    shape_u: for each term the standard uncertainty of its continuous shape, else nothing.
    """

    terms: tuple[Term, ...]
    values: np.ndarray
    free: np.ndarray
    prior: np.ndarray
    covariance: np.ndarray
    shape_u: tuple[float | None, ...]

    @classmethod
    def of(
        cls,
        terms: tuple[Term, ...],
        values: np.ndarray | None = None,
        free: np.ndarray | None = None,
        prior: np.ndarray | None = None,
    ) -> "Model":
        """Terms before a fit: at their nominal values, all free, nothing known beforehand."""
        count = len(parameters_of(terms))
        return cls(
            terms,
            nominal_values(terms) if values is None else values,
            np.ones(count, bool) if free is None else free,
            np.zeros(count) if prior is None else prior,
            np.zeros((count, count)),
            (None,) * len(terms),
        )

    @property
    def u(self) -> np.ndarray:
        """(p,) standard uncertainties; zero where not free."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

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

    def with_term(self, term: Term) -> "Model":
        """The same values with one term more, at its nominal values and free."""
        longer = Model.of((*self.terms, term))
        count = len(self.values)
        longer.values[:count], longer.free[:count] = self.values, self.free
        longer.prior[:count] = self.prior
        longer.covariance[:count, :count] = self.covariance
        return replace(longer, shape_u=(*self.shape_u, None))

    @property
    def places(self) -> dict[TermKey, slice]:
        """Where each term's parameters stand."""
        return dict(zip((term.key for term in self.terms), places(self.terms), strict=True))

    def with_values_of(self, other: "Model") -> "Model":
        """The model with the values that another has for the same terms, where they are free."""
        values, theirs = self.values.copy(), other.places
        for key, place in self.places.items():
            if key in theirs:
                values[place] = other.values[theirs[key]]
        return replace(self, values=np.where(self.free, values, self.values))

    def prediction(self, motion: Motion) -> np.ndarray:
        """Readings (n, 6) in rad/s and m/s² of a unit with these values."""
        return predict(self.terms, motion, self.values)

    def linearised(self, motion: Motion, wanted: np.ndarray | None = None) -> Design:
        """Prediction and columns of all parameters, or of those (p,) bool that are wanted."""
        return linearise(self.terms, motion, self.values, wanted)

    def effect_of(
        self, some: Collection[TermKey], motion: Motion, prediction: np.ndarray
    ) -> np.ndarray:
        """(n, 6) what some of its terms add to its prediction (n, 6)."""
        return prediction - self.without(some).prediction(motion)

    def design(self, motion: Motion) -> Design:
        """Prediction and columns of the free parameters, then of the continuous shapes."""
        whole = self.linearised(motion, self.free)
        columns = [whole.columns[p] for p in np.flatnonzero(self.free)]
        for k in self.fitted_shapes:
            step = SHAPE_STEP * max(abs(self.terms[k].at[0]), 0.1)
            columns.append(shape_column(self.terms, motion, self.values, k, step))
        return Design(whole.prediction, tuple(columns))

    @property
    def fitted_shapes(self) -> list[int]:
        """Terms with one continuous shape in whose columns there is something to differentiate."""
        own = places(self.terms)
        pairs = enumerate(zip(self.terms, own, strict=True))
        return [
            k
            for k, (term, place) in pairs
            if term.has_continuous_shape and self.values[place].any()
        ]

    def stepped(self, change: np.ndarray, covariance: np.ndarray) -> "Model":
        """After a step (q,) of the free parameters and shapes, known by its covariance (q, q)."""
        rows = np.flatnonzero(self.free)
        values, whole = self.values.copy(), np.zeros_like(self.covariance)
        values[rows] += change[: len(rows)]
        whole[np.ix_(rows, rows)] = covariance[: len(rows), : len(rows)]
        terms, shape_u = list(self.terms), list(self.shape_u)
        for n, k in enumerate(self.fitted_shapes, len(rows)):
            now = terms[k].at[0]
            low, high = terms[k].shapes[0].plausible
            longest = 0.5 * max(abs(now), 0.1)
            to = float(np.clip(now + np.clip(change[n], -longest, longest), low, high))
            terms[k] = terms[k].shaped((to,))
            shape_u[k] = float(np.sqrt(covariance[n, n]))
        return replace(
            self, terms=tuple(terms), values=values, covariance=whole, shape_u=tuple(shape_u)
        )

    def held_at_zero(self, some: np.ndarray) -> "Model":
        """Some parameters (p,) bool are zero, and are no longer fitted."""
        left = ~some
        return replace(
            self,
            values=np.where(some, 0.0, self.values),
            free=self.free & left,
            covariance=self.covariance * left[:, None] * left,
        )

    @property
    def negative(self) -> np.ndarray:
        """(p,) bool: below zero where no unit has them, such as a time constant."""
        lowest = np.array([p.plausible[0] for p in parameters_of(self.terms)])
        return np.asarray((lowest == 0.0) & (self.values < 0.0))
