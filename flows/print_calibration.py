"""Prints a calibration."""

from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from flows.printing import stdout
from schemas.calibration import Calibration, Information, Item
from schemas.text import RunVerdict, Validity, texts_of
from tasks.specifications.items import item_title
from tasks.words import say
from tasks.words.quantities import unit_text
from tasks.words.rounding import column

WORDS: dict[RunVerdict, str] = {
    "valid": "the run is valid",
    "remarks": "the run is valid with remarks, on which no unit passes",
    "invalid": "the run is invalid, and nothing is decided on the unit",
}


def print_calibration(calibration: Calibration) -> None:
    """Print a table of every item, then what is unavailable and what the reader must know."""
    console = stdout()
    table = _results_table(f"{calibration.recording_id} · {calibration.procedure}", "item")
    for name, item in calibration.items.items():
        _add_item(table, say(item_title(name)), item)
    console.print(table)
    console.print(WORDS[calibration.validity.verdict], style="bold")
    _print_information(console, calibration)
    for name, reason in calibration.unavailable.items():
        console.print("[yellow]not determined[/] ", end="")
        console.print(f"{say(item_title(name))}: {reason}", markup=False)
    for remark in calibration.remarks:
        mark = "[red]![/]" if remark.blocks_pass else "[dim]·[/]"
        console.print(f"{mark} ", end="")
        console.print(say(remark), markup=False)


def _print_information(console: Console, calibration: Calibration) -> None:
    """Print a second table with the additional information, and its sentences."""
    if not calibration.information:
        return
    table = _results_table("for information, not decided on", "quantity")
    for shown in calibration.information.values():
        if any(value is not None for value in shown.value.values()):
            _add_item(table, shown.title, shown)
    console.print(table)
    for shown in calibration.information.values():
        console.print(f"[dim]· {shown.title}:[/] ", end="")
        console.print(say(shown), markup=False)


def _results_table(title: str, of: str) -> Table:
    table = Table(title=Text(title))
    for name, justify in ((of, "left"), ("", "left"), ("value", "right"), ("U", "right"),
                          ("k", "right"), ("unit", "left")):  # fmt: skip
        table.add_column(name, justify=justify)  # type: ignore[arg-type]
    return table


def _add_item(table: Table, name: str, item: Item | Information) -> None:
    U = item.U or {}
    texts = column(list(item.value.values()), [U.get(element) for element in item.value], item.k)
    power = f"×10^{texts.exponent} " if texts.exponent else ""
    rows = zip(item.value, texts.values, texts.uncertainties, strict=True)
    for row, (element, value, expanded) in enumerate(rows):
        table.add_row(
            name if row == 0 else "",
            Text(element),
            value or "–",
            expanded or "–",
            f"{item.k:g}",
            power + unit_text(item.unit),
            end_section=row == len(item.value) - 1,
        )


def summary(validity: Validity) -> dict[str, Any]:
    """The validity as in JSON."""
    return {"verdict": validity.verdict, "reasons": list(validity.reasons)}


def lines(validity: Validity) -> list[str]:
    """The validity, and a line for each reason."""
    return [
        WORDS[validity.verdict],
        *(f"  {say(reason)}" for reason in texts_of(validity, "reasons")),
    ]
