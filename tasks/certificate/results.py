"""The results as rows, in the order of the specification's appendix.

Numbers are texts by JJF 1059.1, in units of 10^exponent.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from schemas.calibration import Calibration, Elements, Information
from schemas.text import Statement, text_of
from schemas.tolerance import Decision, LimitDecision, Verdict
from tasks.certificate.fields import first_known, given, quoted, slug
from tasks.certificate.statements import determined
from tasks.conformity.limits import (
    accepted_text,
    limits_text,
    probability_text,
    quantity_title,
    relative_text,
    verdict_title,
)
from tasks.specifications.estimate import (
    MATRIX_ELEMENTS,
    OFF_DIAGONAL_ELEMENTS,
    ItemDefinition,
    Specification,
    item_title,
    second_value,
)
from tasks.words import Message, Sayable, clauses, message, say, statement
from tasks.words.numbers import (
    FULL_STOPS,
    PREFIXED,
    PREFIXES,
    USUAL_K,
    clause,
    column,
    quantity_text,
    round_up,
    text,
    unit_text,
)

# Additional information beside the clauses' results, as printed rows; no decision uses it.
#
# Numbers are texts by JJF 1059.1, in units of 10^exponent.


# Which value of an item contains what the separated one does not.
EARTH = "gyro_g_sensitivity_without_earth_rotation"
SEPARATED = (EARTH, "accel_rate_sensitivity_without_lever_arm")
WITHOUT_U = 3  # significant digits of a value
# Remarks by which the data do not show that Earth's rotation is in them.
EARTH_NOT_SHOWN = {"earth_rotation_not_visible", "earth_rotation_not_shown", "earth_rotation_odd"}


@dataclass(frozen=True)
class Cell:
    """One element: its name, value and U; None: no number."""

    element: str
    value: str | None
    U: str | None


@dataclass(frozen=True)
class InformationRow:
    """One quantity: title, unit, lines of up to three cells (None: no such element), sentences.

    lines: empty where no element has a value.
    """

    title: Sayable
    unit: str
    exponent: int
    lines: tuple[tuple[Cell | None, ...], ...]
    sentences: Message


def information_rows(calibration: Calibration) -> tuple[InformationRow, ...]:
    """Everything the result shows beside its items."""
    return tuple(map(_row, calibration.information.values()))


def contained(
    calibration: Calibration, item: str, specification: Specification
) -> tuple[Message, ...]:
    """What the clause's value of an item contains, where that is more than its U; how much.

    By the element at which the difference is largest against U.
    """
    clause = calibration.items[item]
    not_shown = EARTH_NOT_SHOWN & {remark.code for remark in calibration.remarks}
    sentences = []
    for name, separated in calibration.information.items():
        if name not in SEPARATED or separated.about != item or (name == EARTH and not_shown):
            continue
        difference = {
            element: value - other
            for element, other in separated.value.items()
            if other is not None and (value := clause.value.get(element)) is not None
        }
        ratios = {e: abs(d) / U for e, d in difference.items() if (U := clause.U.get(e))}
        worst = max(ratios, key=lambda element: ratios[element], default=None)
        if worst is not None and ratios[worst] > 1.0:
            ids = (f"certificate-value-of.{key}" for key in (specification.method, slug(name)))
            sentences.append(
                message(
                    "certificate-contained",
                    value=first_known(*ids) or "",
                    part=message(f"certificate-contained.{slug(name)}"),
                    element=worst,
                    size=quantity_text(str(text(round_up(abs(difference[worst])))), clause.unit),
                    times=f"{float(f'{ratios[worst]:.2g}'):g}",
                )
            )
    return tuple(sentences)


def _row(shown: Information) -> InformationRow:
    U: Elements = shown.U or {}
    elements = tuple(shown.value)
    printed = column(
        [shown.value[e] for e in elements], [U.get(e) for e in elements], shown.k, WITHOUT_U
    )
    cells = {
        e: Cell(e, printed.values[i], printed.uncertainties[i]) for i, e in enumerate(elements)
    }
    known = any(value is not None for value in printed.values)
    prefix = PREFIXES.get(printed.exponent, "") if shown.unit in PREFIXED else ""
    return InformationRow(
        title=text_of(shown, "title") or "",
        unit=unit_text(prefix + shown.unit),
        exponent=0 if prefix else printed.exponent,
        lines=tuple(_lines(cells)) if known else (),
        sentences=quoted(shown),
    )


def _lines(cells: dict[str, Cell]) -> Iterator[tuple[Cell | None, ...]]:
    """Three cells a line; elements like xy stand where a matrix has them."""
    if all(len(e) == 2 and set(e) <= set("xyz") for e in cells):
        for reads in "xyz":
            line = tuple(cells.get(reads + given) for given in "xyz")
            if any(line):
                yield line
        return
    every: list[Cell | None] = list(cells.values())
    for start in range(0, len(every), 3):
        yield tuple([*every[start : start + 3], None, None][:3])


# The elements of an item as rows: their numbers, limits and verdicts.

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
    sentences: tuple[Message, ...]


@dataclass(frozen=True)
class PrintedSection:
    """A numbered section of the appendix."""

    title: Message
    groups: tuple[Group, ...]


def sections(
    calibration: Calibration, decision: Decision, specification: Specification
) -> tuple[PrintedSection, ...]:
    """Every section of the specification's appendix, also where nothing was determined."""
    layout = [(section.title, section.items) for section in specification.layout]
    known = {item for _, items in layout for item in items}
    others = tuple(name for name in calibration.items if name not in known)
    if others:
        layout.append((message("certificate-other-results"), others))
    return tuple(
        PrintedSection(
            title, tuple(_group(calibration, decision, name, specification) for name in items)
        )
        for title, items in layout
    )


def _group(
    calibration: Calibration, decision: Decision, name: str, specification: Specification
) -> Group:
    item, definition = calibration.items.get(name), specification.definitions.get(name)
    named = definition.elements if definition else ()
    elements = tuple(dict.fromkeys((*named, *(item.value if item else ()))))
    columns = _columns(definition, specification)
    two = len(columns) > 1
    limits = [limit for limit in decision.limits if limit.item == name]
    exponent, listed = rows(calibration, name, definition, elements, limits, two)
    known = determined(item)
    at = clause(item.clause, specification.standard) if item else None
    return Group(
        title=item_title(name),
        determined=known,
        clause=at if at and say(at) else None,
        k=f"{item.k:g}" if item else "",
        kind=message(f"certificate-kind.{slug(item.uncertainty_kind)}") if item else None,
        unit=unit_text(item.unit if item else definition.unit if definition else ""),
        exponent=exponent,
        columns=columns,
        U_apart=any(row.U_second and row.U_second != row.U for row in listed),
        rows=listed,
        matrices=_matrices(definition, elements, columns, listed),
        sentences=(
            *(_about(name, limits, specification, two) if known else ()),
            *(contained(calibration, name, specification) if known else ()),
            *_missing(calibration, name, elements, definition, two),
        ),
    )


def _columns(
    definition: ItemDefinition | None, specification: Specification
) -> tuple[Message, ...]:
    """The headings of the values: one, or those of both values."""
    once = specification.printed_once
    if definition is None or definition.second_value is None or definition.key in once:
        return (message("certificate-column"),)
    key = slug(definition.key)
    first = first_known(
        f"certificate-column.{key}-{specification.method}", f"certificate-column.{key}"
    )
    return first or message("certificate-column"), message(f"certificate-column.{key}-second")


def _about(
    name: str, limits: list[LimitDecision], specification: Specification, two: bool
) -> tuple[Message, ...]:
    """What the reader of an item must know, and whether and on what it is decided."""
    key = slug(name)
    remarks = (
        None if limits else first_known(f"certificate-not-decided.{key}"),
        first_known(f"certificate-about.{key}-{specification.method}", f"certificate-about.{key}"),
    )
    applied = dict.fromkeys(map(quantity_title, limits)) if two else {}
    relative = dict.fromkeys(filter(None, map(relative_text, limits)))
    return (
        *filter(None, remarks),
        *([message("certificate-applied", quantities=clauses(tuple(applied)))] if applied else ()),
        *(message("certificate-relative", limits=text) for text in relative),
    )


def _missing(
    calibration: Calibration,
    name: str,
    elements: tuple[str, ...],
    definition: ItemDefinition | None,
    two: bool,
) -> list[Message]:
    """Why an element, or the whole item, has no number."""
    item, causes = calibration.items.get(name), list[Sayable]()
    if name in calibration.unavailable:
        why = calibration.why_unavailable(name)
        causes.append(_without_stop(why) if why else "")
    elif item is None:
        causes.append(message("certificate-missing.item"))
    elif any(item.value.get(element) is None for element in elements):
        causes.append(message("conformity-no-cause"))
    second = definition.second_value if definition and two else None
    if item and second and getattr(item, second) is None:
        causes.append(message("certificate-missing.second"))
    return [message("certificate-missing", cause=cause) for cause in causes]


def _without_stop(why: Statement) -> Statement:
    bare: dict[str, Any] = {
        name: words.rstrip(FULL_STOPS) for name, words in statement(why).words.items()
    }
    return Statement(**bare)


def _matrices(
    definition: ItemDefinition | None,
    elements: tuple[str, ...],
    columns: tuple[Message, ...],
    rows: tuple[Row, ...],
) -> tuple[Matrix, ...]:
    """The matrix of each value of an item that is listed row by row; its diagonal may be 0."""
    if definition is None or elements not in (MATRIX_ELEMENTS, OFF_DIAGONAL_ELEMENTS):
        return ()
    diagonal = dict.fromkeys((axis * 2 for axis in "xyz"), "0")
    matrices = []
    values = ([row.value for row in rows], [row.second for row in rows])
    for caption, printed in zip(columns, values, strict=False):
        if any(printed):
            cells = diagonal | dict(zip(elements, printed, strict=True))
            grid = tuple(tuple(cells[row + col] for col in "xyz") for row in "xyz")
            matrices.append(Matrix(definition.letter, caption, grid))
    return tuple(matrices)
