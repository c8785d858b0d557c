"""What a unit reads by a list of terms, and how its readings follow each parameter."""

from dataclasses import dataclass

import numpy as np

from tasks.model.term import Column, Inputs, Term, parameters_of, places
from tasks.motion.whole import Motion

CHANNEL_COUNT = 6  # gyro x, y, z in rad/s, then accelerometer x, y, z in m/s²
STEP = 1e-3  # of the plausible range, to differentiate by a parameter of the input


def predict(terms: tuple[Term, ...], motion: Motion, values: np.ndarray) -> np.ndarray:
    """Readings (n, 6) in rad/s and m/s² of a unit with the parameter values (p,)."""
    inputs = _felt(terms, motion, values)
    readings = np.zeros((CHANNEL_COUNT, len(motion.t)))
    for term, place in zip(terms, places(terms), strict=True):
        for value, column in zip(values[place], term.columns(motion, inputs), strict=False):
            for channel, readout in column.items():
                readings[channel] += value * readout
    return readings.T


@dataclass(frozen=True)
class Design:
    """A model linearised at some values.

    prediction: (n, 6). columns: for each parameter the readings per unit of it, by channel.
    """

    prediction: np.ndarray
    columns: tuple[Column, ...]

    def of_channel(self, channel: int) -> tuple[list[int], np.ndarray]:
        """The parameters that a channel reads, and their columns (n, k)."""
        used = [p for p, column in enumerate(self.columns) if channel in column]
        if not used:
            return [], np.zeros((len(self.prediction), 0))
        return used, np.column_stack([self.columns[p][channel] for p in used])


def linearise(terms: tuple[Term, ...], motion: Motion, values: np.ndarray) -> Design:
    """Prediction and columns at the values (p,).

    What a sensor makes of its input is linear in its parameters; parameters of the input are
    differentiated by central differences, exact for what is quadratic.
    """
    inputs = _felt(terms, motion, values)
    columns: list[Column] = []
    for term, place in zip(terms, places(terms), strict=True):
        if term.stage == "sensor":
            columns.extend(term.columns(motion, inputs))
        else:
            columns.extend(
                _difference(terms, motion, values, p) for p in range(place.start, place.stop)
            )
    return Design(predict(terms, motion, values), tuple(columns))


def _felt(terms: tuple[Term, ...], motion: Motion, values: np.ndarray) -> Inputs:
    """What the sensors feel, each term acting on what those before it made of the motion."""
    inputs = Inputs(motion.rate, motion.force)
    for term, place in zip(terms, places(terms), strict=True):
        inputs = term.felt(motion, inputs, values[place])
    return inputs


def _difference(terms: tuple[Term, ...], motion: Motion, values: np.ndarray, p: int) -> Column:
    """Readings per unit of one parameter, in the channels that follow it."""
    low, high = parameters_of(terms)[p].plausible
    step = STEP * (high - low)
    moved = []
    for sign in (1.0, -1.0):
        shifted = values.copy()
        shifted[p] += sign * step
        moved.append(predict(terms, motion, shifted))
    slope = (moved[0] - moved[1]) / (2.0 * step)
    return {
        channel: slope[:, channel] for channel in range(CHANNEL_COUNT) if slope[:, channel].any()
    }
