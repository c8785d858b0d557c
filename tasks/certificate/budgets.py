"""The uncertainty budgets as rows of tables: JJF 1059.1-2012, 5.3.2 and 6.2.

For each item the lines of the element with the largest uncertainty, and u_c, degrees of freedom
and U of every element. A pair is (Chinese, English).
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from decimal import Decimal

from schemas.calibration import Calibration, Item
from schemas.uncertainty import Budget, BudgetInput
from tasks.certificate.equipment import half_width, limits_of, source
from tasks.certificate.names import KINDS, Pair, item_name, symbol
from tasks.words.rounding import MINUS, column, text
from tasks.words.units import unit_text

DISTRIBUTIONS = {
    "normal": ("正态", "normal"),
    "rectangular": ("均匀", "rectangular"),
    "triangular": ("三角", "triangular"),
    "arcsine": ("反正弦", "arcsine"),
    "t": ("t", "t"),
}
INTRODUCTION = {
    "GUM": (
        "各输入量相互独立；灵敏系数的单位为结果单位除以输入量单位。U = k·u；"
        "有效自由度均不小于 50 时 k = 2，否则取该项各元素中最大的 k。"
        "95 % 区间半宽由各分布的传播（JJF 1059.2）得到。",
        "The inputs are independent of each other; a sensitivity is in the unit of the result per "
        "that of the input. U = k·u with k = 2 where no element has fewer than 50 effective "
        "degrees of freedom, else with the largest k of the item's elements. The half width of the "
        "95 % interval follows from the propagation of the distributions (JCGM 101).",
    ),
    "as the specification's example": (
        "按规范附录 A 的示例：u1 和 u2 的灵敏系数取 1；u3 为各位置的标准不确定度之和，"
        "均以结果的单位表示；U = 2·u。",
        "As in Appendix A of the specification: u1 and u2 with sensitivity 1; u3 is the sum of the "
        "standard uncertainties of the positions, each in the unit of the result; U = 2·u.",
    ),
    "Monte Carlo": (
        "各输入量相互独立，按其分布抽样，经该项计算式传播（JJF 1059.2）；灵敏系数和贡献为线性近似。"
        "U 为概率对称包含区间的半宽，取该项各元素中最大的 k = U/u。",
        "The inputs are independent of each other, drawn from their distributions and propagated "
        "through the item's equation (JCGM 101); sensitivities and contributions are those of its "
        "linear form. U is half the probabilistically symmetric coverage interval, with the "
        "largest k = U/u of the item's elements.",
    ),
}
DIGITS = 3  # significant digits of a standard uncertainty inside a budget
PLAIN = (1e-3, 1e4)  # sizes written without a power of ten
INFINITE, MOST_DOF = "∞", 9999
FINEST_SHARE = 0.1  # %


@dataclass(frozen=True)
class Figure:
    """A number: its digits and its power of ten (0: none)."""

    digits: str
    exponent: int = 0


@dataclass(frozen=True)
class Line:
    """An input quantity: what it is, u(x), c = ∂y/∂x, |c|·u(x), share of the variance, dof."""

    name: Pair
    symbol: str
    kind: str
    distribution: Pair
    unit: str
    u: Figure
    sensitivity: Figure
    contribution: Figure
    share: str
    dof: str


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
    """One item: which element its lines are of, and every element's sum."""

    title: Pair
    kind: Pair
    unit: str
    k: str
    of: str
    lines: tuple[Line, ...]
    exponent: int
    elements: tuple[Element, ...]


@dataclass(frozen=True)
class LimitRow:
    """A limit of the equipment: what, symbol, half-width (U for normal), shape, who states it."""

    name: Pair
    symbol: str
    half_width: str
    distribution: Pair
    source: Pair


@dataclass(frozen=True)
class Budgets:
    """How the budgets are made, the limits that enter them, and those of every item."""

    said: tuple[Pair, ...]
    limits: tuple[LimitRow, ...]
    tables: tuple[BudgetTable, ...]


def budgets(calibration: Calibration) -> Budgets | None:
    """The budgets of every item that has any, in the order of the calibration; None without."""
    items = {name: item for name, item in calibration.items.items() if item.budgets}
    kinds = dict.fromkeys(item.uncertainty_kind for item in items.values())
    said = tuple(INTRODUCTION[kind] for kind in kinds if kind in INTRODUCTION)
    tables = tuple(_table(name, item) for name, item in items.items())
    limits = tuple(map(_limit, limits_of(calibration)))
    return Budgets(said, limits, tables) if tables else None


def _limit(line: BudgetInput) -> LimitRow:
    return LimitRow(
        name=(line.name_zh, line.name),
        symbol=line.symbol,
        half_width=half_width(line),
        distribution=DISTRIBUTIONS[line.distribution],
        source=source(line),
    )


def _table(name: str, item: Item) -> BudgetTable:
    budgets = item.budgets
    largest = max(budgets, key=lambda element: budgets[element].u_c)
    values = [budget.value for budget in budgets.values()]
    expanded = column(values, [budget.U for budget in budgets.values()], item.k)
    return BudgetTable(
        title=item_name(name),
        kind=KINDS[item.uncertainty_kind],
        unit=unit_text(item.unit),
        k=f"{item.k:g}",
        of=symbol(name, largest),
        lines=tuple(_line(line) for line in budgets[largest].inputs),
        exponent=expanded.exponent,
        elements=tuple(
            _element(name, element, budget, U, expanded.exponent)
            for (element, budget), U in zip(budgets.items(), expanded.uncertainties, strict=True)
        ),
    )


def _line(line: BudgetInput) -> Line:
    return Line(
        name=(line.name_zh, line.name),
        symbol=line.symbol,
        kind=line.kind,
        distribution=DISTRIBUTIONS[line.distribution],
        unit=unit_text(line.unit),
        u=figure(line.u),
        sensitivity=figure(line.sensitivity),
        contribution=figure(line.contribution),
        share=_share(100.0 * line.share),
        dof=_dof(line.dof),
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
    return f"> {MOST_DOF}" if dof > MOST_DOF else f"{math.floor(dof * (1.0 + 1e-9)):d}"


def _like(half_width: float, U: str | None, exponent: int) -> str:
    """The half width of an interval, to the last place of U."""
    places = len(U.partition(".")[2]) if U else 0
    return text(round(Decimal(repr(half_width)).scaleb(-exponent), places)) or ""
