"""Predicts the readings by a list of terms, and their derivatives by each parameter."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tasks.model.term import Column, Inputs, Term, parameters_of, places
from tasks.motion.whole import Motion

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
