"""The elements of an item as rows: their numbers, limits and verdicts."""

from dataclasses import dataclass

from schemas.calibration import Calibration
from schemas.decision import LimitDecision, Verdict
from tasks.certificate.fields import given
from tasks.conformity.limits import accepted_text, limits_text, probability_text, verdict_title
from tasks.specifications.items import ItemDefinition, second_value
from tasks.words import Message, Sayable, message
from tasks.words.rounding import USUAL_K, column

# Items whose numbers are written in one power of ten, so that they can be compared.
SAME_EXPONENT = {
    "gyro_cross_coupling": "accel_cross_coupling",
    "accel_cross_coupling": "gyro_cross_coupling",
}


@dataclass(frozen=True)
class Mark:
    """The verdict on one limit: its key and words, and the probability of conformity."""

    verdict: Verdict
    conditional: bool
    words: Message
    chance: str | None


@dataclass(frozen=True)
class Row:
    """One element: name, symbol, value, second value, U, limits and marks; None: no number.

    U_second: of the second value. limits: the limits and, where they differ, the acceptance
    limits.
    """

    name: Sayable
    letter: str
    sub: str
    value: str | None
    second: str | None
    U: str | None
    U_second: str | None
    limits: tuple[Sayable, ...]
    marks: tuple[Mark, ...]


def rows(
    calibration: Calibration,
    name: str,
    definition: ItemDefinition | None,
    elements: tuple[str, ...],
    limits: list[LimitDecision],
    two: bool,
) -> tuple[int, tuple[Row, ...]]:
    """The power of ten of an item's numbers, and a row for each of its elements.

    Cross couplings of both triads share the power of ten. two: whether the item shows two values.
    """
    items = calibration.items
    item, paired = items.get(name), items.get(SAME_EXPONENT.get(name, ""))
    second = getattr(item, second_value(name) or "", None) if two else None
    U = item.U if item else {}
    own = item.U_without_earth_rotation if item and second else None
    sources = ((item.value if item else {}, U), (second or {}, own or U))
    pairs = [(value.get(e), u.get(e)) for value, u in sources for e in elements]
    others = [(value, paired.U.get(e)) for e, value in paired.value.items()] if paired else []
    every, n = [*pairs, *others], len(elements)
    printed = column(
        [value for value, _ in every], [u for _, u in every], item.k if item else USUAL_K
    )
    return printed.exponent, tuple(
        Row(
            name=definition.element_title(element) if definition else given(element),
            letter=definition.letter if definition else "",
            sub=definition.element_subscript(element) if definition else "",
            value=printed.values[i],
            second=printed.values[n + i],
            U=printed.uncertainties[i],
            U_second=printed.uncertainties[n + i],
            limits=tuple(
                line
                for limit in limits
                if limit.element == element
                for line in _limit_lines(limit, printed.exponent, two)
            ),
            marks=tuple(mark(limit) for limit in limits if limit.element == element),
        )
        for i, element in enumerate(elements)
    )


def _limit_lines(limit: LimitDecision, exponent: int, two: bool) -> tuple[Sayable, ...]:
    """The limits and, where they differ, the acceptance limits, without a unit.

    two: whether the item shows two values; (a), (b) then name the column.
    """
    limits, accepted = limits_text(limit, exponent), accepted_text(limit, exponent)
    if two:
        limits = f"({'a' if limit.applied_to == 'value' else 'b'}) {limits}"
    if accepted is None:
        return (limits,)
    return limits, message("certificate-accepted", limits=accepted)


def mark(limit: LimitDecision) -> Mark:
    """The verdict as printed beside a value; without a probability if nothing was decided."""
    chance = limit.probability_of_conformity
    shown = None if chance is None else probability_text(chance)
    return Mark(limit.verdict, limit.marginal, verdict_title(limit), shown)
