"""The source of the equipment limits in the budgets, and what no budget includes."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from schemas.calibration import BudgetInput, Calibration
from schemas.laboratory import ErrorBound, ErrorFunction, LimitName, MeasurementStandard
from schemas.text import text_of
from tasks.certificate.cover import by_document
from tasks.certificate.fields import NOT_GIVEN, first_known, given, literal, slug
from tasks.conformity.capabilities import bound_text, name_of
from tasks.specifications.estimate import Specification
from tasks.uncertainty.equipment import (
    GRAVITY,
    LATITUDE,
    LEVELLED,
    RECOMMENDED,
    TAKEN_TO_BE_MET,
    FunctionSource,
    error_at,
    extent,
    limit_of,
    stated_at,
)
from tasks.words import Message, Sayable, clauses, message
from tasks.words.numbers import as_given, clause, plain, quantity_text

ASSUMED = {
    GRAVITY.clause: message("certificate-assumed.gravity"),
    LATITUDE.clause: message("certificate-assumed.latitude"),
    LEVELLED: message("certificate-assumed.level"),
}
EARTH = "WGS 84"  # the source of what Earth's rotation contributes, which nobody states
DIGITS = 3  # significant, of a half-width as it is printed
FUNCTION_UNITS: dict[LimitName, str] = {"rate": "deg/s", "position": "deg"}


def limits_of(calibration: Calibration) -> tuple[BudgetInput, ...]:
    """Every limit of the equipment that stands in a budget, once."""
    lines = (
        line
        for item in calibration.items.values()
        for budget in item.budgets.values()
        for line in budget.inputs
        if line.source is not None and line.half_width is not None
    )
    return tuple({(line.symbol, line.source): line for line in lines}.values())


def source(line: BudgetInput) -> Sayable:
    """Who states a limit: the specification that recommends it, the laboratory, or nobody."""
    return stated_by(line.source or "")


def stated_by(source: str) -> Sayable:
    """The source of a limit, and of a function whether its deviation is corrected or budgeted."""
    function = FunctionSource.read(source)
    if function is None:
        return ASSUMED.get(source) or clause(source)
    by = message(f"certificate-by-function.{function.deviation}", paper=given(function.paper))
    if not function.years:
        return by
    return message("certificate-by-function.drift", source=by, years=function.years)


def half_width(line: BudgetInput) -> str | None:
    """The half-width of a limit with ± and its unit, angles in arcseconds and the latitude in
    degrees; of a normal distribution U instead (k = 2).
    """
    if line.half_width is None:
        return None
    shown = size(line.half_width, line.unit, line.symbol == LATITUDE.symbol)
    return f"U = {shown}" if line.distribution == "normal" else f"±{shown}"


def size(half_width: float, unit: str, is_latitude: bool) -> str:
    """A half-width with its unit."""
    if unit != "rad":
        return quantity_text(plain(half_width, DIGITS), unit)
    degrees = math.degrees(half_width)
    return f"{degrees:g}°" if is_latitude else f"{plain(3600 * degrees, DIGITS)}″"


def accuracy(standard: MeasurementStandard) -> Sayable:
    """What a standard may be off by: the limits that go into the budgets, else as it was given."""
    if not standard.limits and not standard.functions:
        return given(text_of(standard, "accuracy"))
    limits = [_limit(name, bound) for name, bound in standard.limits.items()]
    functions = [_function(name, function) for name, function in standard.functions.items()]
    return clauses([*limits, *functions])


def _limit(name: LimitName, bound: ErrorBound) -> Message:
    """A limit as ± its half-width, with the distribution unless it is rectangular; U (k = 2) of a
    normal one, U_rel of a ratio.
    """
    limit = limit_of(name)
    known = bound_text(bound.half_width, limit.unit)
    if bound.distribution == "normal":
        symbol = "U_rel" if limit.unit == "1" else "U"
        U = f"{symbol} = {known.removeprefix('±')}"
        return message("certificate-limit-of-standard.uncertainty", limit=limit.name, U=U)
    if bound.distribution == "rectangular":
        return message("certificate-limit-of-standard", limit=limit.name, half_width=known)
    shape = message(f"certificate-distribution.{bound.distribution}")
    return message(
        "certificate-limit-of-standard.shaped", limit=limit.name, half_width=known, shape=shape
    )


def _function(name: LimitName, function: ErrorFunction) -> Message:
    """The extent of a stated function, its largest deviation and U, and what is done with it."""
    limit, unit = limit_of(name), FUNCTION_UNITS.get(name)
    extents = [extent(function, axis) or (0.0, 0.0) for axis in function.axes]
    low, high = min(e[0] for e in extents), max(e[1] for e in extents)
    largest = max(
        float(np.abs(error_at(function, axis, np.array(stated_at(function, axis)))).max())
        for axis in function.axes
    )
    stated = [row.U for row in function.rows] + [part.U for part in function.polynomials]
    return message(
        f"certificate-function-of-standard.{function.deviation}",
        limit=limit.name,
        range=f" {' … '.join(quantity_text(plain(x), unit) for x in (low, high))}" if unit else "",
        deviation=bound_text(largest, limit.unit),
        U=bound_text(max(stated), limit.unit).removeprefix("±"),
        k=f"{function.k:g}",
    )


def whose_limits(calibration: Calibration) -> tuple[Message, ...]:
    """What the type B contributions rest on, and what is not in them; nothing without limits."""
    limits = limits_of(calibration)
    if not limits:
        return ()
    assumed = [line for line in limits if line.source in ASSUMED]
    recommended = [line for line in limits if line.source in RECOMMENDED]
    others = {EARTH, *ASSUMED, *RECOMMENDED}
    own = [line for line in limits if line.source not in others]
    parts = []
    if own:
        parts.append(message("certificate-limits.own", limits=tuple(map(name_of, own))))
    if recommended:
        parts.append(
            message(
                "certificate-limits.recommended",
                limits=tuple(map(name_of, recommended)),
                sources=tuple(dict.fromkeys(map(source, recommended))),
            )
        )
    parts += [_assumed(name_of(line), half_width(line) or "") for line in assumed]
    if _latitude_of_second_values(calibration, limits):
        parts.append(_assumed(LATITUDE.name, f"±{math.degrees(LATITUDE.half_width):g}°"))
    return (message("certificate-limits", parts=clauses(parts)),)


def axes_of_results(calibration: Calibration) -> Message:
    """About which axes the results are, and whether the tilt of the unit's base is in a budget."""
    return message(f"certificate-axes.{_axes(calibration)}")


def flatness(calibration: Calibration, specification: Specification) -> Iterator[Message]:
    """That no budget includes the flatness of table and fixture, unless one has the mounting.

    The plate tilts with the unit's base, whose length nobody states.
    """
    if limits_of(calibration) and _axes(calibration) != "mounting-plane":
        yield message(by_document("flatness", specification))


def _axes(calibration: Calibration) -> str:
    """The axes of the results: "fixture", "unit", "mounting-plane", "mounting-unknown".

    Results of earlier versions do not say it: they are about the axes of the fixture unless a
    budget has the limit of the mounting.
    """
    counted = any(line.symbol == limit_of("mounting").symbol for line in limits_of(calibration))
    axes = calibration.settings.get("axes") or ("mounting plane" if counted else "fixture")
    if axes == "mounting plane" and counted:
        return "mounting-plane"
    return "mounting-unknown" if axes == "mounting plane" else str(axes)


def _assumed(name: Sayable, known: str) -> Message:
    return message("certificate-limits.assumed", limit=name, known=known)


def _latitude_of_second_values(calibration: Calibration, limits: tuple[BudgetInput, ...]) -> bool:
    """Whether the assumed latitude enters by a second value alone, which has no budget."""
    stated = "limit of latitude" in calibration.settings
    if stated or any(line.symbol == LATITUDE.symbol for line in limits):
        return False
    values = (item.U_without_earth_rotation or {} for item in calibration.items.values())
    return any(U is not None for elements in values for U in elements.values())


# The settings of a calibration with their printed names and units.

UNITS = {"gravity_m_s2": "m/s2", "latitude_deg": "deg", "mount": "deg"}
LIMIT = "limit of "
RECOMMENDED_BY = "limits"  # the document that recommends those of the others
LIMIT_UNITS = {"rate": "1", "ripple": "1", "gravity": "m/s2"}  # of the others: rad
BY_EXAMPLE = " (the example's)"
OF_UNIT = " (the unit's)"


@dataclass(frozen=True)
class Setting:
    """One setting: its name, its value as printed; number and unit where it is a number."""

    name: Sayable
    value: Sayable
    number: float | None = None
    unit: str = "1"

    @property
    def printed(self) -> Message:
        """Name and value."""
        return message("certificate-setting-with", name=self.name, value=self.value)


def settings(calibration: Calibration) -> Iterator[Setting]:
    """Every setting that the calibration was made with.

    Without the document that recommends limits, if every limit in the budgets is another's.
    """
    limits = limits_of(calibration)
    none_recommended = bool(limits) and not any(each.source in TAKEN_TO_BE_MET for each in limits)
    for name, value in calibration.settings.items():
        if not (name == RECOMMENDED_BY and none_recommended):
            yield setting(name, value)


def setting(name: str, value: float | str | None) -> Setting:
    """A setting as results carry it."""
    if not isinstance(value, int | float):
        return Setting(_name(name), _printed_value(name, value))
    unit = UNITS.get(name, "1")
    return Setting(_name(name), given(quantity_text(as_given(value), unit)), value, unit)


def _name(name: str) -> Sayable:
    if name.startswith(LIMIT):
        limit = first_known(f"uncertainty-{name.removeprefix(LIMIT)}")
        return message("certificate-setting-limit", limit=limit or given(name))
    return first_known(f"certificate-setting.{slug(name)}") or given(name)


def _printed_value(name: str, value: str | None) -> Sayable:
    if value is None:
        return NOT_GIVEN
    for ending, origin in ((BY_EXAMPLE, "by-example"), (OF_UNIT, "of-unit")):
        if value.endswith(ending):
            number = literal(value.removesuffix(ending))
            return message(f"certificate-setting-{origin}", number=number)
    if name.startswith(LIMIT):
        limit = name.removeprefix(LIMIT)
        number, _, source = value.partition(" ")
        shown = size(float(number), LIMIT_UNITS.get(limit, "rad"), limit == "latitude")
        by = stated_by(source.removeprefix("(").removesuffix(")"))
        return message("certificate-setting-stated", half_width=shown, source=by)
    worded = {"uncertainty": "kind", "axes": "axes-setting"}.get(name)
    kind = first_known(f"certificate-{worded}.{slug(value)}") if worded else None
    return kind or (clause(value) if value.startswith("JJF") else given(value))
