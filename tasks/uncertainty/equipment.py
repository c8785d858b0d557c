"""Error limits of the measuring equipment: Table 1 of JJF 2003-2022 and of JJF 1536-2015.

The defaults are the tables' own recommendations; a laboratory's own limits go before them
(`with_limits`). Where a table is silent the entry says `assumed`.
"""

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from datetime import date
from functools import cached_property
from typing import get_args

import numpy as np

from schemas.base import Unusable
from schemas.laboratory import (
    STATED_OVER,
    EquipmentLimit,
    ErrorBound,
    ErrorFunction,
    ErrorPolynomial,
    LimitName,
    LimitShape,
    MeasurementStandard,
    StatedError,
)
from tasks.uncertainty.budget import InputQuantity
from tasks.uncertainty.monte_carlo import EXAMPLE
from tasks.uncertainty.type_a import DIVISORS
from tasks.words import Message, message
from tasks.words.numbers import USUAL_K

# What certificates of standards state as functions: errors of indication, their U and drift.
#
# An error is linear between the rows of a certificate, or a polynomial. Corrected, U and drift
# alone are left of it; budgeted, its size is added to U (GUM F.2.4.5).

YEAR_DAYS = 365.25
WRITTEN = re.compile(r"(.*): deviation (corrected|budgeted)(?:, drift over (\S+) a)?")
RANGE_STEPS = 200  # of a polynomial's range: its largest value lies between two of them


class LimitByRate(EquipmentLimit):
    """A limit that depends on the rate, one and the same error at every rate.

    half_width: the largest. ranges: from which rate (rad/s) on there is which half-width, rising.
    """

    ranges: tuple[tuple[float, float], ...]


def source_of(standard: MeasurementStandard) -> str:
    """How a budget names the certificate of a standard."""
    return f"{standard.certificate} ({standard.serial})"


@dataclass(frozen=True)
class FunctionSource:
    """What the source of a budget's line says of a stated function.

    paper: as `source_of`; deviation: corrected or budgeted; years: of drift, as text; empty: none.
    """

    paper: str
    deviation: str
    years: str

    def __str__(self) -> str:
        drift = f", drift over {self.years} a" if self.years else ""
        return f"{self.paper}: deviation {self.deviation}{drift}"

    @classmethod
    def read(cls, source: str) -> "FunctionSource | None":
        """From the text of a line; None for that of a limit."""
        found = WRITTEN.fullmatch(source)
        return found and cls(found[1], found[2], found[3] or "")


def extent(function: ErrorFunction, axis: str | None) -> tuple[float, float] | None:
    """From where to where an error is stated, °/s or °; None for an axis without any."""
    rows, polynomial = _of_axis(function, axis)
    if polynomial is not None:
        return polynomial.lowest, polynomial.highest
    at = [row.at or 0.0 for row in rows]
    return (at[0], at[-1]) if at else None


def error_at(function: ErrorFunction, axis: str | None, x: np.ndarray | float = 0.0) -> np.ndarray:
    """Indicated less actual at rates (°/s) or angles (°); beyond its extent that of the end."""
    rows, polynomial = _of_axis(function, axis)
    if polynomial is not None:
        inside = np.clip(x, polynomial.lowest, polynomial.highest)
        return np.polynomial.polynomial.polyval(inside, polynomial.coefficients)
    at, stated = [row.at or 0.0 for row in rows], [row.deviation for row in rows]
    return np.asarray(np.interp(x, at, stated))


def function_limit(
    standard: MeasurementStandard, name: LimitName, day: date | None
) -> EquipmentLimit:
    """What is left of a stated error on the day of a measurement: an expanded uncertainty, k = 2.

    The largest over its extent and its axes; of a rate also from which rate on it is how large.
    day: None for a recording that does not say its own; the drift is then that of `valid_until`.
    Raises Unusable where that is not known either.
    """
    function = standard.functions[name]
    drifted, aged = 0.0, ""
    if function.drift:
        years = _years(standard, day)
        drifted = function.drift.per_year * years / DIVISORS[function.drift.distribution]
        aged = f"{years:.2f}"
    source = str(FunctionSource(source_of(standard), function.deviation, aged))
    at = sorted({x for axis in function.axes for x in stated_at(function, axis)})
    stated = np.max([_half_widths(function, axis, at) for axis in function.axes], axis=0)
    half_widths = USUAL_K * np.hypot(stated / USUAL_K, drifted)
    largest = float(half_widths.max())
    if STATED_OVER[name] != "rate":
        return EquipmentLimit(half_width=largest, distribution="normal", source=source)
    until_next = np.maximum(half_widths, [*half_widths[1:], half_widths[-1]])
    ranges = zip(np.radians(at).tolist(), until_next.tolist(), strict=True)
    return LimitByRate(
        half_width=largest, distribution="normal", source=source, ranges=tuple(ranges)
    )


def _half_widths(function: ErrorFunction, axis: str | None, at: Iterable[float]) -> np.ndarray:
    """U with k = 2, with the size of the error where it is budgeted, at each x."""
    rows, polynomial = _of_axis(function, axis)
    x = np.array(list(at))
    U = (
        np.full(len(x), polynomial.U)
        if polynomial is not None
        else np.interp(x, [row.at or 0.0 for row in rows], [row.U for row in rows])
    )
    size = np.abs(error_at(function, axis, x)) if function.deviation == "budgeted" else 0.0
    return np.asarray(USUAL_K * U / function.k + size)


def stated_at(function: ErrorFunction, axis: str | None) -> list[float]:
    """Where it is stated: at each row, at many places of a polynomial."""
    rows, polynomial = _of_axis(function, axis)
    if polynomial is not None:
        return np.linspace(polynomial.lowest, polynomial.highest, RANGE_STEPS + 1).tolist()
    return [row.at or 0.0 for row in rows]


def _of_axis(
    function: ErrorFunction, axis: str | None
) -> tuple[list[StatedError], ErrorPolynomial | None]:
    """The rows of an axis, or its polynomial; what names no axis is of every one."""
    named = axis if function.axes != (None,) else None
    polynomials = [part for part in function.polynomials if part.axis == named]
    return [row for row in function.rows if row.axis == named], next(iter(polynomials), None)


def _years(standard: MeasurementStandard, day: date | None) -> float:
    """Between the calibration of a standard and a day, either way."""
    until = day or standard.valid_until
    if until is None or standard.calibrated_on is None:
        raise Unusable(
            f"{source_of(standard)} states a drift, and neither the recording says its day "
            "(recorded_at) nor the standard valid_until: give one of them"
        )
    return abs((until - standard.calibrated_on).days) / YEAR_DAYS


ARCSECOND = math.radians(1.0 / 3600.0)
EDGE = 0.99  # of the rate where a limit begins: a table holds 10 °/s to its own errors


@dataclass(frozen=True)
class ErrorLimit:
    """How far one property of the equipment may be from its stated value, and who says so.

    half_width: in `unit`; for `normal` it is an expanded uncertainty with k = 2.
    """

    symbol: str
    name: Message
    unit: str
    half_width: float
    distribution: LimitShape
    clause: str

    @property
    def u(self) -> float:
        """Standard uncertainty, half-width over the divisor of the distribution."""
        return self.half_width / DIVISORS[self.distribution]

    @cached_property  # one limit is in the budgets of many elements
    def quantity(self) -> InputQuantity:
        """The limit as an input quantity of type B, with infinitely many degrees of freedom."""
        return InputQuantity(
            self.symbol, self.name, self.unit, self.u, "B", self.distribution,
            half_width=self.half_width, source=self.clause,
        )  # fmt: skip


def _limit(
    symbol: str, name: str, unit: str, half_width: float, shape: LimitShape, clause: str
) -> ErrorLimit:
    return ErrorLimit(symbol, message(f"uncertainty-{name}"), unit, half_width, shape, clause)


GRAVITY = _limit(
    "g",
    "gravity",
    "m/s2",
    5e-4,
    "rectangular",
    "assumed: gravity from latitude and height, anomalies within 50 mGal",
)
LATITUDE = _limit(
    "φ", "latitude", "rad", math.radians(0.05), "rectangular", "assumed: latitude stated to 0.1°"
)


# What no specification recommends a limit for: symbol, name and unit of one that is stated.
UNSTATED: dict[LimitName, ErrorLimit] = {
    "time_base": _limit("ε4", "time-base", "1", 0.0, "rectangular", ""),
    "mounting": _limit("α6", "mounting", "rad", 0.0, "rectangular", ""),
    "heading": _limit("ψ", "heading", "rad", 0.0, "rectangular", ""),
}


@dataclass(frozen=True)
class Equipment:
    """Table, fixture and site of a calibration; None: not known, or not there.

    rates: relative error of the mean rate over whole turns, each limit from its slowest rate
    (rad/s) on, fastest first; those of one symbol are one error. ripple: within a turn.
    position, repeatability: of each table angle. axes: between the table's axes.
    fixture: between the fixture's faces. encoder_time: when each angle of a table that is polled
    was read (s), with which a mean rate begins and ends. commanded_rate: relative, of a held rate
    that is taken as commanded, because the angles of such a table tell it worse. level: of the
    vertical of the outermost axis, about each of two directions. mounting: of the unit's base in
    the fixture. time_base: of the clock of the recording, relative. creeps: whether an angle may
    move by its errors while it is held.
    """

    rates: tuple[tuple[float, ErrorLimit], ...] = ()
    ripple: ErrorLimit | None = None
    level: ErrorLimit | None = None
    position: ErrorLimit | None = None
    repeatability: ErrorLimit | None = None
    axes: ErrorLimit | None = None
    fixture: ErrorLimit | None = None
    gravity: ErrorLimit = GRAVITY
    latitude: ErrorLimit = LATITUDE
    encoder_time: ErrorLimit | None = None
    commanded_rate: ErrorLimit | None = None
    time_base: ErrorLimit | None = None
    mounting: ErrorLimit | None = None
    heading: ErrorLimit | None = None
    creeps: bool = False

    @property
    def angles(self) -> tuple[ErrorLimit, ...]:
        """What turns the unit by an error of its own in every position, rad."""
        return tuple(limit for limit in (self.position, self.repeatability) if limit is not None)

    @property
    def known(self) -> bool:
        """Whether somebody states the errors of its rates and of its angles."""
        limits = (*(limit for _, limit in self.rates), *self.angles)
        return bool(self.rates and self.angles) and all(one.clause != NOBODY for one in limits)

    def rate_at(self, rate: float) -> tuple[ErrorLimit, ...]:
        """The limit of the mean rate at a rate (rad/s); empty where none is known.

        A rate up to 1 % below where a limit begins is meant to have it.
        """
        limits = [limit for slowest, limit in self.rates if abs(rate) >= EDGE * slowest]
        return tuple(limits[:1])

    def rate_errors(self, rates: np.ndarray) -> Iterator[tuple[ErrorLimit, np.ndarray]]:
        """Each error of the mean rate: its largest limit, and its share (n,) at rates (n,) rad/s.

        NaN: no held rate.
        """
        at = [self.rate_at(float(rate)) for rate in rates]
        for symbol in dict.fromkeys(limit.symbol for _, limit in self.rates):
            one = [limit for _, limit in self.rates if limit.symbol == symbol]
            largest = max(one, key=lambda limit: limit.u)
            u = [sum(each.u for each in limits if each.symbol == symbol) for limits in at]
            yield largest, np.array(u) / largest.u


LEVELLED = "assumed: the vertical axis is levelled as well as the axes are square"
TABLE_1, FIXTURE_2003 = "JJF 2003-2022, Table 1", "JJF 2003-2022, 6.2"
RATE = _limit("ε1", "rate", "1", 1e-5, "rectangular", TABLE_1)
JJF2003 = Equipment(
    rates=((0.0, RATE),),
    ripple=_limit("ε2", "ripple", "1", 5e-4, "rectangular", TABLE_1),
    level=_limit("α5", "level", "rad", 10 * ARCSECOND, "rectangular", LEVELLED),
    position=_limit("α1", "position", "rad", 10 * ARCSECOND, "rectangular", TABLE_1),
    repeatability=_limit("α2", "angle-repeatability", "rad", 5 * ARCSECOND, "rectangular", TABLE_1),
    axes=_limit("α3", "axes", "rad", 10 * ARCSECOND, "rectangular", TABLE_1),
    fixture=_limit("α4", "fixture", "rad", 10 * ARCSECOND, "rectangular", FIXTURE_2003),
)
TABLE_1_AHRS = "JJF 1536-2015, Table 1"  # U_rel of the rate with k = 2
FIXTURE_1536 = "JJF 1536-2015, 6.2.2 b)"
JJF1536 = Equipment(
    rates=(
        (math.radians(10.0), _limit("ε1", "rate-fast", "1", 2e-4, "normal", TABLE_1_AHRS)),
        (math.radians(1.0), _limit("ε2", "rate-medium", "1", 2e-3, "normal", TABLE_1_AHRS)),
        (0.0, _limit("ε3", "rate-slow", "1", 2e-2, "normal", TABLE_1_AHRS)),
    ),
    position=_limit("α1", "table-angle", "rad", 10 * ARCSECOND, "normal", TABLE_1_AHRS),
    fixture=_limit("α4", "fixture", "rad", 5 * ARCSECOND, "rectangular", FIXTURE_1536),
    creeps=True,  # 1800 s at each position
)
POLLED = "the recording: longest exchange with the table"
COMMANDED = "the station file: how well the table holds a commanded rate"
RECOMMENDED = {TABLE_1, FIXTURE_2003, TABLE_1_AHRS, FIXTURE_1536}
TAKEN_TO_BE_MET = RECOMMENDED | {EXAMPLE}  # of limits that nobody stated of the equipment used
# What a reference may be off by of which nobody states anything: as far as a table of any class is,
# so that it shows which elements hang on it. Such a line is never the largest of a stated U.
NOBODY = "stated by nobody"
UNSTATED_RATE = _limit("ε1", "rate", "1", 5e-4, "rectangular", NOBODY)
# A unit turned by hand, on a pillar, or on a table that nobody describes.
UNKNOWN = Equipment(
    rates=((0.0, UNSTATED_RATE),),
    level=_limit("α5", "level", "rad", math.radians(0.1), "rectangular", NOBODY),
    position=_limit("α1", "position", "rad", math.radians(0.1), "rectangular", NOBODY),
    axes=_limit("α3", "axes", "rad", math.radians(0.1), "rectangular", NOBODY),
    fixture=_limit("α4", "fixture", "rad", math.radians(0.1), "rectangular", NOBODY),
)


def limit_of(name: LimitName) -> ErrorLimit:
    """The limit that a laboratory's own takes the place of; it keeps symbol, name and unit."""
    if name in UNSTATED:
        return UNSTATED[name]
    limit: ErrorLimit = RATE if name == "rate" else getattr(JJF2003, name)
    return limit


# Of the limits that a laboratory can state itself, by the symbol of a budget's line.
LIMIT_NAMES: dict[str, LimitName] = {limit_of(name).symbol: name for name in get_args(LimitName)}


def with_polled_encoders(
    equipment: Equipment, half_width_s: float, commanded: ErrorBound | None = None
) -> Equipment:
    """The equipment with a table whose angles are read at times known to ± half_width_s.

    commanded: how far the rates that it holds may be from those commanded, relative.
    """
    limit = _limit("τ", "encoder-time", "s", half_width_s, "rectangular", POLLED)
    timed = replace(equipment, encoder_time=limit)
    return timed if commanded is None else replace(timed, commanded_rate=_as_commanded(commanded))


def with_rates_by_label(equipment: Equipment, commanded: ErrorBound | None) -> Equipment:
    """The equipment where no encoder shows a rate: it is the one commanded, as far as is stated."""
    limit = UNSTATED_RATE if commanded is None else _as_commanded(commanded)
    return replace(equipment, rates=((0.0, limit),))


def _as_commanded(bound: ErrorBound) -> ErrorLimit:
    return _limit("ε5", "commanded-rate", "1", bound.half_width, bound.distribution, COMMANDED)


def with_limits(equipment: Equipment, own: Mapping[LimitName, EquipmentLimit]) -> Equipment:
    """The equipment with a laboratory's own limits in the place of the specification's."""
    changed: dict[str, object] = {}
    for name, stated in own.items():
        limit = replace(
            limit_of(name),
            half_width=stated.half_width,
            distribution=stated.distribution,
            clause=stated.source,
        )
        changed |= {"rates": _by_rate(limit, stated)} if name == "rate" else {name: limit}
    return replace(equipment, **changed)  # type: ignore[arg-type]


def _by_rate(limit: ErrorLimit, stated: EquipmentLimit) -> tuple[tuple[float, ErrorLimit], ...]:
    if not isinstance(stated, LimitByRate):
        return ((0.0, limit),)
    return tuple(
        (slowest, replace(limit, half_width=half_width))
        for slowest, half_width in reversed(stated.ranges)
    )


def standard_uncertainty(bound: ErrorBound) -> float:
    """Half-width over the divisor of the distribution, in the bound's unit."""
    return bound.half_width / DIVISORS[bound.distribution]


def stated_limits(
    standards: Iterable[MeasurementStandard], day: date | None
) -> dict[LimitName, EquipmentLimit]:
    """What the certificates of the standards state of a day, of two on one property the larger.

    day: of the measurement, None where it is not known. Raises Unusable for a drift since an
    unknown day.
    """
    found: dict[LimitName, EquipmentLimit] = {}
    for standard in standards:
        source = source_of(standard)
        limits = {
            name: EquipmentLimit(**bound.model_dump(), source=source)
            for name, bound in standard.limits.items()
        }
        for name in standard.functions:
            limits[name] = function_limit(standard, name, day)
        for name, limit in limits.items():
            if name not in found or _is_larger(limit, found[name]):
                found[name] = limit
    return found


def own_limits(
    standards: Iterable[MeasurementStandard],
    own: Mapping[LimitName, EquipmentLimit],
    day: date | None,
) -> dict[LimitName, EquipmentLimit]:
    """The limits that the budgets take: what a laboratory states itself, else its standards."""
    return stated_limits(standards, day) | dict(own)


def _is_larger(one: ErrorBound, other: ErrorBound) -> bool:
    return standard_uncertainty(one) > standard_uncertainty(other)
