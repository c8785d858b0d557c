"""What certificates of standards state as functions: errors of indication, their U and drift.

An error is linear between the rows of a certificate, or a polynomial. Corrected, U and drift alone
are left of it; budgeted, its size is added to U (GUM F.2.4.5).
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import date

import numpy as np

from schemas.base import Unusable
from schemas.equipment import (
    STATED_OVER,
    EquipmentLimit,
    ErrorFunction,
    ErrorPolynomial,
    LimitName,
    MeasurementStandard,
    StatedError,
)
from tasks.uncertainty.distributions import DIVISORS
from tasks.words.rounding import USUAL_K

YEAR_DAYS = 365.25
WRITTEN = re.compile(r"(.*): deviation (corrected|budgeted)(?:, drift over (\S+) a)?")
STEPS = 200  # of a polynomial's range: its largest value lies between two of them


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
        return np.linspace(polynomial.lowest, polynomial.highest, STEPS + 1).tolist()
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
