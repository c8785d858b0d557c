"""The results as rows, in the order of the specification's appendix.

Numbers are texts by JJF 1059.1, in units of 10^exponent.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from schemas.calibration import Calibration, Item
from schemas.discrepancy import Statement
from schemas.tolerance import Decision, LimitDecision, Verdict
from tasks.certificate.fields import first_known, given, slug
from tasks.certificate.information import contained
from tasks.certificate.numbers import Numbers, numbers
from tasks.certificate.statements import determined, identifiers
from tasks.conformity.limits import (
    accepted_text,
    limits_text,
    probability_text,
    quantity_title,
    relative_text,
    verdict_title,
)
from tasks.conformity.reasons import unavailable
from tasks.specifications.items import (
    ITEMS,
    MATRIX_ELEMENTS,
    OFF_DIAGONAL_ELEMENTS,
    item_title,
    second_value,
)
from tasks.specifications.specification import Specification
from tasks.words import Message, Sayable, clauses, message
from tasks.words.typography import FULL_STOPS, clause
from tasks.words.units import unit_text


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


@dataclass(frozen=True)
class Matrix:
    """A coefficient matrix as Appendix B of JJF 2003-2022 shows it; rows: the axis that reads."""

    letter: str
    caption: Sayable
    cells: tuple[tuple[str | None, ...], ...]


@dataclass(frozen=True)
class Group:
    """One item: its heading, unit and rows, and what has to be said about it.

    determined: whether there is any value; if not, there is nothing to tabulate. U_apart: whether
    the second values have a U of their own.
    """

    title: Sayable
    determined: bool
    clause: Statement | None
    k: str
    kind: Message | None
    unit: str
    exponent: int
    columns: tuple[Message, ...]
    U_apart: bool
    rows: tuple[Row, ...]
    matrices: tuple[Matrix, ...]
    readings: tuple[str, ...]
    sentences: tuple[Message, ...]


@dataclass(frozen=True)
class Section:
    """A numbered section of the appendix."""

    title: Message
    groups: tuple[Group, ...]


def sections(
    calibration: Calibration, decision: Decision, specification: Specification
) -> tuple[Section, ...]:
    """Every section of the specification's appendix, also where nothing was determined."""
    layout = [(section.title, section.items) for section in specification.layout]
    known = {item for _, items in layout for item in items}
    others = tuple(name for name in calibration.items if name not in known)
    if others:
        layout.append((message("certificate-other-results"), others))
    return tuple(
        Section(title, tuple(_group(calibration, decision, name, specification) for name in items))
        for title, items in layout
    )


def _group(
    calibration: Calibration, decision: Decision, name: str, specification: Specification
) -> Group:
    item = calibration.items.get(name)
    elements = _elements(item, name)
    columns = _columns(name, specification)
    two = len(columns) > 1
    made = numbers(calibration, name, elements, two)
    limits = [limit for limit in decision.limits if limit.item == name]
    shorts = identifiers(calibration)
    known = determined(item)
    at = clause(item.clause, specification.standard) if item else None
    return Group(
        title=item_title(name),
        determined=known,
        clause=at if at and at.en else None,
        k=f"{item.k:g}" if item else "",
        kind=message(f"certificate-kind.{slug(item.uncertainty_kind)}") if item else None,
        unit=unit_text(item.unit if item else ITEMS[name].unit),
        exponent=made.exponent,
        columns=columns,
        U_apart=made.separate,
        rows=tuple(_row(name, element, made, i, limits, two) for i, element in enumerate(elements)),
        matrices=_matrices(name, elements, columns, (made.values, made.seconds)),
        readings=tuple(shorts[reading] for reading in item.readings) if item and known else (),
        sentences=(
            *(_about(name, limits, specification, two) if known else ()),
            *(contained(calibration, name, specification) if known else ()),
            *_missing(calibration, name, two),
        ),
    )  # fmt: skip


def _columns(name: str, specification: Specification) -> tuple[Message, ...]:
    """The headings of the values: one, or those of both values."""
    item = specification.definitions.get(name)
    if item is None or item.second_value is None:
        return (message("certificate-column"),)
    key = slug(name)
    first = first_known(
        f"certificate-column.{key}-{specification.method}", f"certificate-column.{key}"
    )
    return first or message("certificate-column"), message(f"certificate-column.{key}-second")


def _elements(item: Item | None, name: str) -> tuple[str, ...]:
    named = ITEMS[name].elements if name in ITEMS else ()
    return tuple(dict.fromkeys((*named, *(item.value if item else ()))))


def _row(
    name: str, element: str, shown: Numbers, i: int, limits: list[LimitDecision], two: bool
) -> Row:
    item = ITEMS.get(name)
    own = [limit for limit in limits if limit.element == element]
    return Row(
        name=item.element_title(element) if item else given(element),
        letter=item.letter if item else "",
        sub=item.element_subscript(element) if item else "",
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


def _about(
    name: str, limits: list[LimitDecision], specification: Specification, two: bool
) -> tuple[Message, ...]:
    """What the reader of an item must know, and whether and on what it is decided."""
    key = slug(name)
    said = (
        None if limits else first_known(f"certificate-not-decided.{key}"),
        first_known(f"certificate-about.{key}-{specification.method}", f"certificate-about.{key}"),
    )
    applied = dict.fromkeys(map(quantity_title, limits)) if two else {}
    relative = dict.fromkeys(filter(None, map(relative_text, limits)))
    return (
        *filter(None, said),
        *([message("certificate-applied", quantities=clauses(tuple(applied)))] if applied else ()),
        *(message("certificate-relative", limits=text) for text in relative),
    )


def _missing(calibration: Calibration, name: str, two: bool) -> list[Message]:
    """Why an element, or the whole item, has no number."""
    item, why = calibration.items.get(name), unavailable(calibration, name)
    causes: list[Sayable] = []
    if name in calibration.unavailable:
        causes.append(_without_stop(why) if why else "")
    elif item is None:
        causes.append(message("certificate-missing.item"))
    elif any(item.value.get(element) is None for element in _elements(item, name)):
        causes.append(message("conformity-no-cause"))
    second = second_value(name)
    if item and two and second and getattr(item, second) is None:
        causes.append(message("certificate-missing.second"))
    return [message("certificate-missing", cause=cause) for cause in causes]


def _without_stop(why: Statement) -> Statement:
    return Statement(en=why.en.rstrip(FULL_STOPS), zh=why.zh.rstrip(FULL_STOPS))


def _matrices(
    name: str,
    elements: tuple[str, ...],
    columns: tuple[Message, ...],
    sources: Sequence[Sequence[str | None]],
) -> tuple[Matrix, ...]:
    """The matrix of each value that has numbers; a diagonal that is not an element is 0."""
    matrix = set(elements) in (set(MATRIX_ELEMENTS), set(OFF_DIAGONAL_ELEMENTS))
    if second_value(name) is None or not matrix:
        return ()
    diagonal = dict.fromkeys((axis * 2 for axis in "xyz"), "0")
    made = []
    for caption, texts in zip(columns, sources, strict=False):
        if any(texts):
            cells = diagonal | dict(zip(elements, texts, strict=True))
            grid = tuple(tuple(cells[row + col] for col in "xyz") for row in "xyz")
            made.append(Matrix(ITEMS[name].letter, caption, grid))
    return tuple(made)
