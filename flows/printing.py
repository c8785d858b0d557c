"""Tables and JSON on standard output; apart from what they hold, so that a list is quick."""

import json
import sys
from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text


def stdout(markup: bool = True) -> Console:
    """Standard output; wide where it is no terminal, so that a pipe gets whole lines."""
    width = None if sys.stdout.isatty() else 160
    return Console(highlight=False, markup=markup, emoji=False, width=width)


def print_json(document: Any) -> None:
    """One JSON document on standard output."""
    print(json.dumps(document, ensure_ascii=False, indent=1))


def print_rows(title: str, columns: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> None:
    """A plain table."""
    table = Table()
    for number, name in enumerate(columns):
        table.add_column(name, overflow="fold", no_wrap=number == 0)
    for row in rows:
        table.add_row(*map(Text, row))
    print(title)
    stdout().print(table)
