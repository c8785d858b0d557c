"""One piece of physics: its name, equation and parameters, and how it changes what is read.

A model is a list of terms. A term acts on what the unit feels (stage «input»: Earth's rotation,
a lever arm) or on what the unit makes of it (stage «sensor»: a column of readings for each
parameter). Nothing knows the terms by name: adding physics is adding one term.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from tasks.motion.whole import Motion

Stage = Literal["input", "sensor"]
Column = Mapping[int, np.ndarray]  # channel 0 to 5 -> (n,) reading per unit of the parameter


@dataclass(frozen=True)
class Parameter:
    """A parameter of a term, in SI; printed it is multiplied by `factor`.

    plausible: the range (SI) that a working unit or station may have it in.
    nominal: the value (SI) of an ideal unit.
    """

    name: str
    symbol: str
    unit: str
    factor: float
    plausible: tuple[float, float]
    nominal: float = 0.0


@dataclass(frozen=True)
class Inputs:
    """What the sensors feel: rate (n, 3) rad/s, specific force (n, 3) m/s²."""

    rate: np.ndarray
    force: np.ndarray


@dataclass(frozen=True)
class Term:
    """A piece of physics. A subclass overrides the method of its stage."""

    name: str
    family: str
    stage: Stage
    equation: str
    source: str
    parameters: tuple[Parameter, ...]

    def felt(self, motion: Motion, inputs: Inputs, values: np.ndarray) -> Inputs:
        """What the sensors feel with this term, given the terms before it; stage «input»."""
        return inputs

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        """For each parameter the readings per unit of it, rad/s or m/s²; stage «sensor»."""
        return ()


def parameters_of(terms: tuple[Term, ...]) -> tuple[Parameter, ...]:
    """The parameters of a list of terms, in its order."""
    return tuple(parameter for term in terms for parameter in term.parameters)


def nominal_values(terms: tuple[Term, ...]) -> np.ndarray:
    """(p,) values of an ideal unit, SI."""
    return np.array([parameter.nominal for parameter in parameters_of(terms)])


def places(terms: tuple[Term, ...]) -> tuple[slice, ...]:
    """Where each term's parameters stand among those of the list."""
    ends = np.cumsum([0, *(len(term.parameters) for term in terms)]).tolist()
    return tuple(slice(a, b) for a, b in pairwise(ends))
