"""One piece of physics: its name, equation and parameters, and how it changes what is read.

A model is a list of terms. A term acts where its physics acts: on the motion (stage `motion`: a
tilt, a wobble), on what the unit feels of it (stage `input`: Earth's rotation, a lever arm), on
what the unit makes of that (stage `sensor`: a column of readings for each parameter) or on the
readings as a time series (stage `signal`: a delay, a low-pass). Nothing knows the terms by
name: adding physics is adding one term.
"""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from itertools import pairwise
from typing import Self

import numpy as np

from schemas.discrepancy import FoundParameter
from tasks.model.effect import Effect
from tasks.motion.whole import STANDARD_GRAVITY, Motion

Column = Mapping[int, np.ndarray]  # channel 0 to 5 -> (n,) reading per unit of the parameter
TermKey = tuple[str, int]
COUNTS = "1"  # unit of a shape that is a whole number
QUANTITIES = ("rad", "m", "s", "K", "V", "T", "Pa")
# By symbol: the size in SI units of these quantities, and the quantities. g: the standard's.
SYMBOLS = {
    **{name: (1.0, {name: 1}) for name in QUANTITIES},
    "deg": (math.pi / 180.0, {"rad": 1}), "arcsec": (math.pi / 648000.0, {"rad": 1}),
    "h": (3600.0, {"s": 1}), "mT": (1e-3, {"T": 1}), "hPa": (100.0, {"Pa": 1}),
    "g": (STANDARD_GRAVITY, {"m": 1, "s": -2}), "1": (1.0, {}), "%": (0.01, {}),
}  # fmt: skip
LABELS = ("of the speed", "of the largest")  # of ratios that are no counts
QUOTIENT = re.compile(r"(/?)(?:(sqrt)?\(([^()]+)\)|([A-Za-z]+|1|%))\^?(\d?)")


@cache
def unit_size(unit: str) -> tuple[float, tuple[float, ...]]:
    """How many SI units one of a unit such as “(deg/s)/g2” is, and its powers of QUANTITIES.

    Raises ValueError for a unit that is not made of known ones.
    """
    size, powers = 1.0, [0.0] * len(QUANTITIES)
    if unit in LABELS:
        return size, tuple(powers)
    parts = list(QUOTIENT.finditer(unit))
    if not parts or "".join(part[0] for part in parts) != unit:
        raise ValueError(f"unit {unit!r}: not a quotient of {', '.join(SYMBOLS)}")
    for over, root, inner, symbol, power in (part.groups() for part in parts):
        if symbol and symbol not in SYMBOLS:
            raise ValueError(f"unit {unit!r}: {symbol!r} is none of {', '.join(SYMBOLS)}")
        own, of = unit_size(inner) if inner else _of_symbol(symbol)
        times = int(power or 1) * (-1.0 if over else 1.0) * (0.5 if root else 1.0)
        size *= own**times
        powers = [p + times * q for p, q in zip(powers, of, strict=True)]
    return size, tuple(powers)


def _of_symbol(symbol: str) -> tuple[float, tuple[float, ...]]:
    size, powers = SYMBOLS[symbol]
    return size, tuple(powers.get(name, 0.0) for name in QUANTITIES)


@dataclass(frozen=True)
class Parameter:
    """A parameter of a term: its value is in the unit `si`, and is printed in `unit`.

    plausible: the range (in `si`) that a working unit or station may have it in.
    nominal: the value (in `si`) of an ideal unit.
    Raises ValueError for an unknown unit, and where the two are of different quantities.
    """

    name: str
    symbol: str
    unit: str
    si: str
    plausible: tuple[float, float]
    nominal: float = 0.0

    def __post_init__(self) -> None:
        if unit_size(self.unit)[1] != unit_size(self.si)[1]:
            raise ValueError(f"{self.name}: {self.unit!r} and {self.si!r} differ in quantity")

    @cached_property
    def factor(self) -> float:
        """By which the value is multiplied to be printed in `unit`."""
        return unit_size(self.si)[0] / unit_size(self.unit)[0]

    def found(self, value: float, u: float) -> FoundParameter:
        """A value that was found, with its standard uncertainty, both in `si`."""
        return FoundParameter(name=self.name, value=value, unit=self.si, u=u)


@dataclass(frozen=True)
class Inputs:
    """What the sensors feel: rate (n, 3) rad/s, specific force (n, 3) m/s²."""

    rate: np.ndarray
    force: np.ndarray

    @classmethod
    def of(cls, motion: Motion) -> "Inputs":
        """The inputs for a motion. A gyro depends so little on the specific force that gravity
        alone replaces it where it is unknown, or zero.
        """
        force = motion.force
        known = np.isfinite(force)
        if not known.all():
            force = np.where(known, force, np.nan_to_num(motion.gravity * motion.up))
        return cls(motion.rate, force)


@dataclass(frozen=True)
class Term(Effect):
    """A piece of physics as a model has it. A subclass overrides the method of its stage.

    shapes, at: what its columns are not linear in (a time constant, an order), and its values,
    SI; they are searched where the rest is solved. Several terms of one name differ in them.
    variant: number among the terms of one name that a search tries, which a fit of the shape does
    not change.
    """

    parameters: tuple[Parameter, ...]
    shapes: tuple[Parameter, ...] = ()
    at: tuple[float, ...] = ()
    variant: int = 0

    @property
    def key(self) -> TermKey:
        """By which a term is recognised, whatever its shape."""
        return self.name, self.variant

    @property
    def word_arguments(self) -> dict[str, int]:
        """The shapes that are whole numbers: an order, an axis."""
        pairs = zip(self.shapes, self.at, strict=True)
        return {shape.name: int(value) for shape, value in pairs if shape.unit == COUNTS}

    @property
    def has_continuous_shape(self) -> bool:
        """Whether it has one continuous shape that a fit can follow: no count and no instant."""
        return (
            len(self.shapes) == 1
            and self.shapes[0].unit != COUNTS
            and self.shapes[0].name != "time"
        )

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        """The motion that really was, given the one that the table reports; stage `motion`."""
        return motion

    def felt(self, motion: Motion, inputs: Inputs, values: np.ndarray) -> Inputs:
        """What the sensors feel with this term, given the terms before it; stage `input`."""
        return inputs

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        """For each parameter the readings per unit of it, rad/s or m/s²; stage `sensor`."""
        return ()

    def passed(self, motion: Motion, readings: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Readings (n, 6) behind this term, given those before it; stage `signal`.

        The rows are a time series, evenly spaced but for gaps.
        """
        return readings

    def with_free_size(self) -> "Term | None":
        """Known physics with parameters that would show whether it is as known; else none."""
        return None

    def shaped(self, at: tuple[float, ...]) -> Self:
        """The same term with other values of what it is not linear in."""
        return replace(self, at=at)


@dataclass(frozen=True)
class SensorTerm(Term):
    """A term of stage `sensor` whose columns are a formula.

    reads: for each parameter the readings per unit of it, from the motion, what the sensors feel
    and the values of the shapes.
    """

    reads: Callable[[Motion, Inputs, tuple[float, ...]], tuple[Column, ...]] = field(kw_only=True)

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        return self.reads(motion, inputs, self.at)


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
