"""The uncertainty budgets as rows of tables: JJF 1059.1-2012, 5.3.2 and 6.2.

For each item the lines of the element with the largest uncertainty, and u_c, degrees of freedom
and U of every element.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from decimal import Decimal

from schemas.calibration import Budget, BudgetInput, Calibration, Item
from tasks.certificate.equipment import half_width, limits_of, source
from tasks.certificate.fields import first_known, slug
from tasks.conformity.capabilities import name_of
from tasks.specifications.estimate import item_title, symbol
from tasks.words import Message, Sayable, message
from tasks.words.numbers import MINUS, column, text, unit_text

DIGITS = 3  # significant digits of a standard uncertainty inside a budget
PLAIN = (1e-3, 1e4)  # sizes written without a power of ten
INFINITE, MAX_DOF = "∞", 9999
FINEST_SHARE = 0.1  # %


@dataclass(frozen=True)
class Figure:
    """A number: its digits and its power of ten (0: none)."""

    digits: str
    exponent: int = 0


@dataclass(frozen=True)
class BudgetLine:
    """An input quantity: what it is, u(x), c = ∂y/∂x, |c|·u(x), share of the variance, dof.

    Of a limit of the equipment also its half-width (U for normal) and who states it.
    """

    name: Sayable
    symbol: str
    kind: str
    distribution: Message
    unit: str
    u: Figure
    sensitivity: Figure
    contribution: Figure
    share: str
    dof: str
    half_width: str | None
    source: Sayable


@dataclass(frozen=True)
class Element:
    """One element: type A and type B parts, u_c, effective dof, U, half width of its interval."""

    name: str
    of_data: Figure
    of_equipment: Figure
    u_c: Figure
    dof: str
    U: str
    half_width: str | None


@dataclass(frozen=True)
class BudgetTable:
    """One item: which element its lines are of, its heading, and every element's sum."""

    title: Sayable
    kind: Message
    unit: str
    k: str
    of: str
    heading: Message
    lines: tuple[BudgetLine, ...]
    exponent: int
    elements: tuple[Element, ...]


@dataclass(frozen=True)
class Budgets:
    """How the budgets are made, the limits that enter them, and those of every item."""

    introductions: tuple[Message, ...]
    limits: tuple[BudgetLine, ...]
    tables: tuple[BudgetTable, ...]


def budgets(calibration: Calibration) -> Budgets | None:
    """The budgets of every item that has any, in the order of the calibration; None without."""
    items = {name: item for name, item in calibration.items.items() if item.budgets}
    kinds = dict.fromkeys(item.uncertainty_kind for item in items.values())
    introductions = tuple(
        filter(None, (first_known(f"certificate-budgets.{slug(kind)}") for kind in kinds))
    )
    tables = tuple(_table(name, item) for name, item in items.items())
    limits = tuple(map(_line, limits_of(calibration)))
    return Budgets(introductions, limits, tables) if tables else None


def _table(name: str, item: Item) -> BudgetTable:
    budgets = item.budgets
    largest = max(budgets, key=lambda element: budgets[element].u_c)
    values = [budget.value for budget in budgets.values()]
    expanded = column(values, [budget.U for budget in budgets.values()], item.k)
    return BudgetTable(
        title=item_title(name),
        kind=message(f"certificate-kind.{slug(item.uncertainty_kind)}"),
        unit=unit_text(item.unit),
        k=f"{item.k:g}",
        of=symbol(name, largest),
        heading=message("certificate-budget-of", symbol=symbol(name, largest)),
        lines=tuple(_line(line) for line in budgets[largest].inputs),
        exponent=expanded.exponent,
        elements=tuple(
            _element(name, element, budget, U, expanded.exponent)
            for (element, budget), U in zip(budgets.items(), expanded.uncertainties, strict=True)
        ),
    )


def _line(line: BudgetInput) -> BudgetLine:
    return BudgetLine(
        name=name_of(line),
        symbol=line.symbol,
        kind=line.kind,
        distribution=message(f"certificate-distribution.{line.distribution}"),
        unit=unit_text(line.unit),
        u=figure(line.u),
        sensitivity=figure(line.sensitivity),
        contribution=figure(line.contribution),
        share=_share(100.0 * line.share),
        dof=_dof(line.dof),
        half_width=half_width(line),
        source=source(line),
    )


def _element(name: str, element: str, budget: Budget, U: str | None, exponent: int) -> Element:
    half = budget.half_width_95
    return Element(
        name=symbol(name, element),
        of_data=figure(_together(budget.inputs, "A")),
        of_equipment=figure(_together(budget.inputs, "B")),
        u_c=figure(budget.u_c),
        dof=_dof(budget.dof),
        U=U or "",
        half_width=None if half is None else _like(half, U, exponent),
    )


def _together(lines: Iterable[BudgetInput], kind: str) -> float:
    return math.hypot(*(line.contribution for line in lines if line.kind == kind))


def figure(value: float) -> Figure:
    """A number with three significant digits."""
    if value == 0.0:
        return Figure("0")
    rounded = float(f"{value:.{DIGITS - 1}e}")
    exponent = math.floor(math.log10(abs(rounded)) + 1e-12)
    if PLAIN[0] <= abs(rounded) < PLAIN[1]:
        return Figure(f"{rounded:.{max(DIGITS - 1 - exponent, 0)}f}".replace("-", MINUS))
    return Figure(f"{rounded / 10.0**exponent:.{DIGITS - 1}f}".replace("-", MINUS), exponent)


def _share(percent: float) -> str:
    if 0.0 < percent < FINEST_SHARE:
        return f"< {FINEST_SHARE:g}"
    return f"{percent:.1f}".replace("-", MINUS)


def _dof(dof: float) -> str:
    """Whole degrees of freedom, as they are used (GUM G.4.1)."""
    if math.isinf(dof):
        return INFINITE
    return f"> {MAX_DOF}" if dof > MAX_DOF else f"{math.floor(dof * (1.0 + 1e-9)):d}"


def _like(half_width: float, U: str | None, exponent: int) -> str:
    """The half width of an interval, to the last place of U."""
    places = len(U.partition(".")[2]) if U else 0
    return text(round(Decimal(repr(half_width)).scaleb(-exponent), places)) or ""
