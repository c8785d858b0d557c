"""Prints tables and JSON on standard output; imports nothing heavy, so that listing is fast."""

import json
import sys
from collections.abc import Sequence
from typing import Any

from rich.cells import cell_len
from rich.console import Console
from rich.table import Table
from rich.text import Text

FRAMED = 500  # rows of a table with lines: rich takes 0.4 ms for each


def stdout(markup: bool = True) -> Console:
    """Standard output; wide if it is not a terminal, so that a pipe gets whole lines."""
    width = None if sys.stdout.isatty() else 160
    return Console(highlight=False, markup=markup, emoji=False, width=width)


def print_json(document: Any) -> None:
    """One JSON document on standard output."""
    print(json.dumps(document, ensure_ascii=False, indent=1))


def print_rows(title: str, columns: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> None:
    """Print a plain table; thousands of rows as columns without lines, which is fast."""
    if len(rows) > FRAMED:
        lines = [columns, *rows]
        widths = [max(map(cell_len, column)) for column in zip(*lines, strict=True)]
        print(title)
        for line in lines:
            padded = (
                text + " " * (w - cell_len(text)) for text, w in zip(line, widths, strict=True)
            )
            print("  ".join(padded).rstrip())
        return
    table = Table()
    for number, name in enumerate(columns):
        table.add_column(name, overflow="fold", no_wrap=number == 0)
    for row in rows:
        table.add_row(*map(Text, row))
    print(title)
    stdout().print(table)
