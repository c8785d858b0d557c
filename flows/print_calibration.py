"""Prints a calibration."""

from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from flows.printing import stdout
from schemas.calibration import Calibration, Information, Item
from schemas.text import Validity, text_of, texts_of
from tasks.certificate.remarks import once_for_all
from tasks.specifications.items import item_title
from tasks.words import known, message, say
from tasks.words.quantities import unit_text
from tasks.words.rounding import column


def print_calibration(calibration: Calibration) -> None:
    """Print a table of every item, then what is unavailable and what the reader must know."""
    console = stdout()
    table = _results_table(f"{calibration.recording_id} · {calibration.procedure}", "item")
    for name, item in calibration.items.items():
        _add_item(table, say(item_title(name)), item)
    console.print(table)
    console.print(say(message(f"flows-run.{calibration.validity.verdict}")), style="bold")
    _print_information(console, calibration)
    for name in calibration.unavailable:
        console.print(f"[yellow]{say(message('flows-not-determined'))}[/] ", end="")
        why = say(calibration.why_unavailable(name) or "")
        console.print(f"{say(item_title(name))}: {why}", markup=False)
    for first, sentence in once_for_all(calibration.remarks):
        mark = "[red]![/]" if first.blocks_pass else "[dim]·[/]"
        console.print(f"{mark} ", end="")
        console.print(say(sentence), markup=False)


def _print_information(console: Console, calibration: Calibration) -> None:
    """Print a second table with the additional information, and its sentences."""
    if not calibration.information:
        return
    table = _results_table(say(message("flows-for-information")), "quantity")
    for shown in calibration.information.values():
        if any(value is not None for value in shown.value.values()):
            _add_item(table, say(text_of(shown, "title") or ""), shown)
    console.print(table)
    for shown in calibration.information.values():
        console.print(f"[dim]· {say(text_of(shown, 'title') or '')}:[/] ", end="")
        console.print(say(shown), markup=False)


def _results_table(title: str, of: str) -> Table:
    table = Table(title=Text(title))
    for name, justify in ((of, "left"), ("", "left"), ("value", "right"), ("U", "right"),
                          ("k", "right"), ("unit", "left")):  # fmt: skip
        table.add_column(column_title(name), justify=justify)  # type: ignore[arg-type]
    return table


def column_title(name: str) -> str:
    """The heading of a column; a symbol stays as it is."""
    return say(message(f"flows-column.{name}")) if known(f"flows-column.{name}") else name


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
        say(message(f"flows-run.{validity.verdict}")),
        *(f"  {say(reason)}" for reason in texts_of(validity, "reasons")),
    ]
