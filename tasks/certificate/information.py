"""Additional information beside the clauses' results, as printed rows; no decision uses it.

Numbers are texts by JJF 1059.1, in units of 10^exponent.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from schemas.calibration import Calibration, Elements, Information
from schemas.text import text_of
from tasks.certificate.fields import first_known, quoted, slug
from tasks.specifications.estimate import Specification
from tasks.words import Message, Sayable, message
from tasks.words.numbers import PREFIXED, PREFIXES, column, quantity_text, round_up, text, unit_text

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
