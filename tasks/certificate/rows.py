"""One element of an item as a row: its numbers, limits and verdicts."""

from dataclasses import dataclass

from schemas.tolerance import LimitDecision, Verdict
from tasks.certificate.fields import given
from tasks.certificate.numbers import Numbers
from tasks.conformity.limits import accepted_text, limits_text, probability_text, verdict_title
from tasks.specifications.items import ItemDefinition
from tasks.words import Message, Sayable


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
    limits AL.
    """

    name: Sayable
    letter: str
    sub: str
    value: str | None
    second: str | None
    U: str | None
    U_second: str | None
    limits: tuple[str, ...]
    marks: tuple[Mark, ...]


def row(
    definition: ItemDefinition | None,
    element: str,
    shown: Numbers,
    i: int,
    limits: list[LimitDecision],
    two: bool,
) -> Row:
    """The i-th element of an item. two: whether the item shows two values."""
    own = [limit for limit in limits if limit.element == element]
    return Row(
        name=definition.element_title(element) if definition else given(element),
        letter=definition.letter if definition else "",
        sub=definition.element_subscript(element) if definition else "",
        value=shown.values[i],
        second=shown.seconds[i],
        U=shown.U[i],
        U_second=shown.U_second[i],
        limits=tuple(line for limit in own for line in _limit_lines(limit, shown.exponent, two)),
        marks=tuple(map(_mark, own)),
    )


def _limit_lines(limit: LimitDecision, exponent: int, two: bool) -> tuple[str, ...]:
    """The limits and, where they differ, the acceptance limits AL, without a unit.

    two: whether the item shows two values; (a), (b) then name the column.
    """
    limits, accepted = limits_text(limit, exponent), accepted_text(limit, exponent)
    if two:
        limits = f"({'a' if limit.applied_to == 'value' else 'b'}) {limits}"
    return (limits, f"AL {accepted}") if accepted else (limits,)


def _mark(limit: LimitDecision) -> Mark:
    """The verdict as it stands beside a value; no probability where nothing was decided."""
    chance = limit.probability_of_conformity
    shown = None if chance is None else probability_text(chance)
    return Mark(limit.verdict, limit.marginal, verdict_title(limit), shown)
