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
from typing import Literal, Self

import numpy as np

from schemas.discrepancy import FoundParameter
from schemas.recording import ACCEL, AXES, GYRO
from tasks.motion.whole import STANDARD_GRAVITY, Motion
from tasks.words import Sayable, known, message

# The record of an effect, whether it is a term of a model or an event in the samples.

Stage = Literal["motion", "input", "sensor", "signal", "event"]
TimeCourse = Literal["drift", "jump", "random walk"]


@dataclass(frozen=True)
class Effect:
    """A piece of physics that readings may show and the standard's model leaves out.

    stage: where it acts; an event is found by looking at the samples and is no term of a model.
    confused_with: names of effects that look much the same. rarity: chi-squared that it must gain
    beyond a more usual effect that looks the same. time_course: how a bias changes, if that is
    what it is. since_power_on: whether it follows the time since then alone, whatever happens to
    the unit. own_title: its title where the catalogue of words has no entry of its name.
    """

    name: str
    family: str
    stage: Stage
    equation: str
    source: str
    confused_with: tuple[str, ...] = field(default=(), kw_only=True)
    rarity: float = field(default=0.0, kw_only=True)
    time_course: TimeCourse | None = field(default=None, kw_only=True)
    since_power_on: bool = field(default=False, kw_only=True)
    own_title: Sayable | None = field(default=None, kw_only=True)

    @property
    def title(self) -> Sayable:
        """What an engineer calls it, with the order or axis of its variant."""
        if self.own_title is not None:
            return self.own_title
        return _attribute(self.name, "title", **self.word_arguments) or _spelled(self.name)

    @property
    def behaviour(self) -> Sayable:
        """What readings that show it follow, without its name; what has none is called by that.

        A form with a title of its own need not behave like the effect's usual one.
        """
        usual = _attribute(self.name, "behaviour", **self.word_arguments)
        if self.own_title is not None and usual is None:
            return self.own_title
        return usual if usual and self.own_title is None else message(f"behaviour-{self.stage}")

    @property
    def separated_by(self) -> Sayable | None:
        """The recording that would separate it from the effects it is confused with."""
        return separating_recording(self.name)

    @property
    def word_arguments(self) -> dict[str, int]:
        """What distinguishes the variants of one name, as arguments of their words."""
        return {}


def effect_name(name: str) -> Sayable:
    """What an effect is called within a sentence; its name spelled out where it has no entry."""
    id_ = _message_id(name)
    return message(id_) if known(id_) else _spelled(name)


def separating_recording(name: str) -> Sayable | None:
    """The recording that would separate an effect from those it is confused with."""
    return _attribute(name, "separated-by")


def next_step(name: str) -> Sayable | None:
    """What an engineer does about an effect that was found."""
    return _attribute(name, "next")


def _attribute(name: str, attribute: str, **arguments: int) -> Sayable | None:
    id_ = f"{_message_id(name)}.{attribute}"
    return message(id_, **arguments) if known(id_) else None


def _message_id(name: str) -> str:
    return "effect-" + name.replace("_", "-")


def _spelled(name: str) -> str:
    return name.replace("_", " ")


LOGGER = "logger and firmware"

# Effects that are no term of a model: they are found by looking at samples.
_EVENTS = (
    Effect(
        "gyro_saturation", "gyro", "event", "ω′ᵢ = max(−L, min(L, ω′ᵢ))",
        "IEEE Std 528; IEEE Std 1431", confused_with=("gyro_scale_nonlinearity",),
    ),
    Effect(
        "accel_saturation", "accelerometer", "event", "a′ᵢ = max(−L, min(L, a′ᵢ))",
        "IEEE Std 528; IEEE Std 1293", confused_with=("accel_nonlinearity",),
    ),
    Effect(
        "dropped_samples", "time", "event", "y′ₖ = y(tₖ + n·Δt) after n lost samples",
        "definition of a time stamp; IEEE Std 1554", confused_with=("clock_skew", "time_offset"),
    ),
    Effect(
        "coarse_quantisation", "electronics", "event",
        "y′ᵢ = q·round(yᵢ/q), white noise q²/12 where the noise is large", "IEEE Std 1241",
        confused_with=("bias_random_walk",),
    ),
    Effect(
        "mains_pickup", "electronics", "event",
        "bᵢ(t) = Aᵢ·cos(2πf·t + φᵢ), f = |n·fs − 50 Hz| or |n·fs − 60 Hz|", "IEEE Std 952",
        confused_with=("rate_ripple",),
    ),
    Effect(
        "range_setting", LOGGER, "event", "y′ = c·y on a whole triad: c = 2ⁿ, 180/π, g, 1000 …",
        "IEEE Std 1431, scale factor; register maps of digital inertial sensors",
        confused_with=("table_scale", "gyro_saturation"),
    ),
    Effect(
        "axis_mapping", LOGGER, "event", "y′ = P·y, P a signed permutation of the axes",
        "IEEE Std 1431, input axis; sensor frames of digital inertial sensors",
        confused_with=("range_setting",),
    ),
    Effect(
        "gravity_removed", LOGGER, "event", "y′ = a − g·up, as the driver estimates up",
        "linear acceleration of drivers of digital inertial sensors",
        confused_with=("range_setting",),
    ),
    Effect(
        "dead_zone", LOGGER, "event", "y′ = 0 for |y| < d; or at rest y′ = y − mean of y",
        "IEEE Std 1431, dead band; IEEE Std 528", confused_with=("coarse_quantisation",),
    ),
    Effect(
        "code_fault", LOGGER, "event", "y′ = y + n·2ᵇ·q, n a whole number by the code of y",
        "IEEE Std 1241, missing codes and bit errors", confused_with=("bias_step",),
    ),
    Effect(
        "repeated_samples", LOGGER, "event",
        "y′ₖ = y′ₖ₋₁, or on the straight line from y′ₖ₋₁ to y′ₖ₊₁",
        "IEEE Std 1241, sample and hold; R. E. Crochiere, L. R. Rabiner, Multirate Digital Signal "
        "Processing, 1983",
        confused_with=("time_offset", "dropped_samples"),
    ),
    Effect(
        "timestamp_jitter", LOGGER, "event", "t′ₖ = tₖ + jₖ, so that y′(t′ₖ) = y(t′ₖ − jₖ)",
        "IEEE Std 1241, aperture uncertainty; IEEE Std 1139",
        confused_with=("time_offset", "dropped_samples"),
    ),
)  # fmt: skip

EVENTS: Mapping[str, Effect] = {event.name: event for event in _EVENTS}


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


# Parameters for each axis, pair of axes or channel, and the columns they multiply.
#
# First index: the axis that reads.

DEG = float(np.degrees(1.0))
MATRIX = tuple((i, j) for i in range(3) for j in range(3))
OFF_DIAGONAL = tuple((i, j) for i, j in MATRIX if i != j)
GYRO_FIRST, ACCEL_FIRST = 0, 3  # channels of the x axes
G = STANDARD_GRAVITY  # m/s², to print per g
STILL = 1e-3  # rad/s: a slower axis stands still
Printed = tuple[str, str, float]  # unit, the SI unit of it, largest plausible in that


def each_axis(name: str, symbol: str, printed: Printed) -> tuple[Parameter, ...]:
    """name_x, name_y, name_z."""
    return tuple(_symmetric(f"{name}_{a}", f"{symbol}_{a}", printed) for a in AXES)


def each_pair(
    letter: str, printed: Printed, pairs: tuple[tuple[int, int], ...] = MATRIX
) -> tuple[Parameter, ...]:
    """letter_xx, letter_xy …: the reading axis, then the one that it follows."""
    names = (f"{letter}_{AXES[i]}{AXES[j]}" for i, j in pairs)
    return tuple(_symmetric(name, name, printed) for name in names)


def each_channel(letter: str, gyro: Printed, accel: Printed) -> tuple[Parameter, ...]:
    """gyro_x … accel_z."""
    return each_gyro(letter, gyro) + tuple(
        _symmetric(name, f"{letter}_a{name[-1]}", accel) for name in ACCEL
    )


def each_gyro(letter: str, printed: Printed) -> tuple[Parameter, ...]:
    """gyro_x, gyro_y, gyro_z."""
    return tuple(_symmetric(name, f"{letter}_g{name[-1]}", printed) for name in GYRO)


def single(name: str, symbol: str, printed: Printed) -> tuple[Parameter, ...]:
    """A single parameter that is as likely negative as positive."""
    return (_symmetric(name, symbol, printed),)


def own(first: int, basis: np.ndarray) -> tuple[Column, ...]:
    """Each axis of the triad that starts at channel `first` reads its own column of (n, 3)."""
    return tuple({first + i: basis[:, i]} for i in range(3))


def crossed(
    first: int, basis: np.ndarray, pairs: tuple[tuple[int, int], ...] = MATRIX
) -> tuple[Column, ...]:
    """Each axis reads every column of (n, 3), in the order of `each_pair`."""
    return tuple({first + i: basis[:, j]} for i, j in pairs)


def same(signal: np.ndarray, channels: tuple[int, ...] = tuple(range(6))) -> tuple[Column, ...]:
    """Each channel reads the same signal (n,)."""
    return tuple({channel: signal} for channel in channels)


def triads(rate: np.ndarray, force: np.ndarray) -> tuple[Column, ...]:
    """Gyros read their column of the first (n, 3), accelerometers theirs of the second."""
    return own(GYRO_FIRST, rate) + own(ACCEL_FIRST, force)


def turned(motion: Motion) -> bool:
    """Whether the unit is known to have turned at all."""
    return bool((np.abs(np.nan_to_num(motion.rate)) > STILL).any())


def _symmetric(name: str, symbol: str, printed: Printed) -> Parameter:
    unit, si, largest = printed
    return Parameter(name, symbol, unit, si, (-largest, largest))
