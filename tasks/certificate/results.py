"""The results as rows: Appendix B of JJF 2003-2022, Appendix C of JJF 1536-2015.

A pair is (Chinese, English). Numbers are texts by JJF 1059.1, in units of 10^exponent.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from schemas.calibration import Calibration, Item
from schemas.tolerance import Decision, LimitDecision
from tasks.certificate.appendix import (
    COLUMNS,
    JOINT_COLUMNS,
    JOINT_SENTENCES,
    NOT_DECIDED_ON,
    ONE_COLUMN,
    OTHER,
    SECTIONS,
    SENTENCES,
)
from tasks.certificate.information import contained
from tasks.certificate.limits import Mark, limit_lines, mark, relative_text
from tasks.certificate.names import KINDS, QUANTITIES, Pair, item_name, pair_of
from tasks.certificate.notes import determined, identifiers
from tasks.certificate.numbers import Numbers, numbers
from tasks.certificate.typography import clause, pair
from tasks.specifications.items import ITEMS, MATRIX_ELEMENTS, OFF_DIAGONAL_ELEMENTS, second_value
from tasks.words.units import unit_text


@dataclass(frozen=True)
class Row:
    """One element: name, symbol, value, second value, U, limits and marks; None: no number.

    U_second: of the second value. limits: the limits and, where they differ, the acceptance
    limits AL.
    """

    name: Pair
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
    caption: Pair | None
    cells: tuple[tuple[str | None, ...], ...]


@dataclass(frozen=True)
class Group:
    """One item: its heading, unit and rows, and what has to be said about it.

    determined: whether there is any value; if not, there is nothing to tabulate. U_apart: whether
    the second values have a U of their own.
    """

    title: Pair
    determined: bool
    clause: Pair
    k: str
    kind: Pair | None
    unit: str
    exponent: int
    columns: tuple[Pair, ...]
    U_apart: bool
    rows: tuple[Row, ...]
    matrices: tuple[Matrix, ...]
    readings: tuple[str, ...]
    sentences: tuple[Pair, ...]


@dataclass(frozen=True)
class Section:
    """A numbered section of the appendix."""

    title: Pair
    groups: tuple[Group, ...]


def sections(
    calibration: Calibration, decision: Decision, specification: str
) -> tuple[Section, ...]:
    """Every section of the specification's appendix, also where nothing was determined."""
    order = SECTIONS[specification]
    known = {item for _, items in order for item in items}
    others = tuple(name for name in calibration.items if name not in known)
    every = (*order, (OTHER, others)) if others else order
    return tuple(
        Section(title, tuple(_group(calibration, decision, name, specification) for name in items))
        for title, items in every
    )


def _group(calibration: Calibration, decision: Decision, name: str, specification: str) -> Group:
    item = calibration.items.get(name)
    elements = _elements(item, name)
    joint = calibration.method == "joint"
    columns = (JOINT_COLUMNS if joint else COLUMNS).get(name, ONE_COLUMN)
    two = len(columns) > 1
    made = numbers(calibration, name, elements, two)
    limits = [made for made in decision.limits if made.item == name]
    shorts = identifiers(calibration)
    rows = tuple(_row(name, element, made, i, limits, two) for i, element in enumerate(elements))
    known = determined(item)
    return Group(
        title=item_name(name),
        determined=known,
        clause=clause(item.clause, specification) if item else ("", ""),
        k=f"{item.k:g}" if item else "",
        kind=KINDS[item.uncertainty_kind] if item else None,
        unit=unit_text(item.unit if item else ITEMS[name].unit),
        exponent=made.exponent,
        columns=columns,
        U_apart=made.separate,
        rows=rows,
        matrices=_matrices(name, elements, columns, (made.values, made.seconds)),
        readings=tuple(shorts[reading] for reading in item.readings) if item and known else (),
        sentences=(
            *(_about(name, limits, joint, two) if known else ()),
            *(contained(calibration, name) if known else ()),
            *_missing(calibration, name, two),
        ),
    )


def _elements(item: Item | None, name: str) -> tuple[str, ...]:
    named = ITEMS[name].elements if name in ITEMS else ()
    return tuple(dict.fromkeys((*named, *(item.value if item else ()))))


def _row(
    name: str, element: str, shown: Numbers, i: int, limits: list[LimitDecision], two: bool
) -> Row:
    printed = ITEMS.get(name)
    mine = [made for made in limits if made.element == element]
    return Row(
        name=pair_of(printed.element_title(element)) if printed else (element, element),
        letter=printed.letter if printed else "",
        sub=printed.element_subscript(element) if printed else "",
        value=shown.values[i],
        second=shown.seconds[i],
        U=shown.U[i],
        U_second=shown.U_second[i],
        limits=tuple(line for made in mine for line in limit_lines(made, shown.exponent, two)),
        marks=tuple(map(mark, mine)),
    )


def _about(name: str, limits: list[LimitDecision], joint: bool, two: bool) -> tuple[Pair, ...]:
    """What the reader of an item must know, and whether and on what it is decided."""
    undecided = () if limits or name not in NOT_DECIDED_ON else (NOT_DECIDED_ON[name],)
    said = (JOINT_SENTENCES if joint else SENTENCES).get(name, ())
    return (*undecided, *said, *(_applied(limits) if two else ()), *_relative(limits))


def _applied(limits: list[LimitDecision]) -> list[Pair]:
    """Which of two values was decided on."""
    if not limits:
        return []
    names = [QUANTITIES[quantity] for quantity in dict.fromkeys(m.applied_to for m in limits)]
    zh, en = "；".join(zh for zh, _ in names), "; ".join(en for _, en in names)
    return [(f"允许限适用于：{zh}。", f"The limits are applied to: {en}.")]


def _relative(limits: list[LimitDecision]) -> list[Pair]:
    """Relative limits as they were given."""
    given = dict.fromkeys(filter(None, map(relative_text, limits)))
    return [(f"相对允许限：{each}。", f"Relative limits: {each}.") for each in given]


def _missing(calibration: Calibration, name: str, two: bool) -> list[Pair]:
    """Why an element, or the whole item, has no number."""
    item = calibration.items.get(name)
    said = []
    if name in calibration.unavailable:
        why = calibration.unavailable[name]
        said.append((calibration.unavailable_zh.get(name) or why, why))
    elif item is None:
        said.append(("本次校准未包含此项", "this item is not part of this calibration"))
    elif any(item.value.get(element) is None for element in _elements(item, name)):
        said.append(("未说明原因", "no cause was given"))
    if item and two and getattr(item, second_value(name) or "") is None:
        said.append(("(b) 未能计算", "(b) could not be computed"))
    return [
        pair(f"未得：{zh.rstrip('。')}。", f"Not determined: {en.rstrip('.')}.") for zh, en in said
    ]


def _matrices(
    name: str,
    elements: tuple[str, ...],
    columns: tuple[Pair, ...],
    sources: Sequence[Sequence[str | None]],
) -> tuple[Matrix, ...]:
    """The matrix of each value that has numbers; a diagonal that is not an element is 0."""
    square = (set(MATRIX_ELEMENTS), set(OFF_DIAGONAL_ELEMENTS))
    if second_value(name) is None or set(elements) not in square:
        return ()
    diagonal = dict.fromkeys((axis * 2 for axis in "xyz"), "0")
    made = []
    for caption, texts in zip(columns, sources, strict=False):
        if not any(texts):
            continue
        cells = diagonal | dict(zip(elements, texts, strict=True))
        grid = tuple(tuple(cells[row + col] for col in "xyz") for row in "xyz")
        made.append(Matrix(ITEMS[name].letter, caption, grid))
    return tuple(made)
