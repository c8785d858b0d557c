"""Numbers with unit, expanded uncertainty and coverage factor, as D-SI writes them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

from tasks.certificate.dcc.units import DsiUnit
from tasks.certificate.dcc.xml import Element, contents, dcc, named, si
from tasks.words import Sayable, message


@dataclass(frozen=True)
class Coverage:
    """The coverage factor of an expanded uncertainty, and the probability that goes with it."""

    k: float
    probability: float


def ref_type(*parts: str) -> str:
    """A refType of this program's own: what a value is, down to its element."""
    return "_".join(("mimucal", *parts))


def coverage(k: float, probability: float | None = None) -> Coverage:
    """probability: None is that of a normal distribution."""
    return Coverage(k, math.erf(k / math.sqrt(2.0)) if probability is None else probability)


def quantity(
    name: Sayable,
    label: str,
    value: Decimal | None,
    unit: DsiUnit,
    U: Decimal | None,
    at: Coverage,
    more: Sequence[Element] = (),
) -> Element:
    """A result by its name, in its SI unit; where it is stated in another, in both, SI first.

    label: item and element for programs, in the refType too: of gyro_bias.x it is
    mimucal_gyro_bias_x. more: what else belongs to it.
    """
    own = ref_type(*label.split("."))
    if value is None:
        return dcc.quantity(named(name), _no_number(), *more, refType=own)
    numbers = [real(label, value, unit.name, U, at)]
    if unit.name != unit.si:
        in_si = None if U is None else unit.in_si(U)
        numbers.insert(0, real(label, unit.in_si(value), unit.si, in_si, at))
    content = si.hybrid(*numbers) if len(numbers) > 1 else numbers[0]
    return dcc.quantity(named(name), content, *more, refType=f"basic_measuredValue {own}")


def plain_quantity(
    name: Sayable, value: Decimal, unit: DsiUnit, tag: str = "quantity", **attributes: str
) -> Element:
    """A number without an uncertainty: a condition, a limit, a setting."""
    numbers = [real(None, value, unit.name)]
    if unit.name != unit.si:
        numbers.insert(0, real(None, unit.in_si(value), unit.si))
    content = si.hybrid(*numbers) if len(numbers) > 1 else numbers[0]
    return dcc(tag, named(name), content, **attributes)


def without_number(name: Sayable) -> Element:
    """That there is no number, where one would be looked for."""
    return dcc.quantity(named(name), _no_number())


def text_quantity(name: Sayable, text: Sayable, tag: str = "quantity") -> Element:
    """A property that is a text."""
    return dcc(tag, named(name), dcc.noQuantity(*contents(text)))


def real(
    label: str | None, value: Decimal, unit: str, U: Decimal | None = None,
    at: Coverage | None = None,
) -> Element:  # fmt: skip
    parts = [si.label(label)] if label else []
    parts += [si.value(str(value)), si.unit(unit)]
    if U is not None and at is not None:
        expanded = si.expandedMU(
            si.valueExpandedMU(str(U)),
            si.coverageFactor(f"{at.k:g}"),
            si.coverageProbability(f"{at.probability:.4g}"),
        )
        parts.append(si.measurementUncertaintyUnivariate(expanded))
    return si.real(*parts)


def _no_number() -> Element:
    return dcc.noQuantity(*contents(message("dcc-no-number")))
