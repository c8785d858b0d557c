"""What the pages of the studies share: tables, shares, and where a page goes."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TypeVar

import typer

T = TypeVar("T")
EVIDENCE = Path(__file__).parent / "evidence"


def line(cells: Iterable[object]) -> str:
    """A row of a table in Markdown."""
    return f"| {' | '.join(' '.join(str(each).replace('|', '/').split()) for each in cells)} |"


def table(columns: Sequence[str], rows: Iterable[Iterable[object]]) -> list[str]:
    """The lines of a table."""
    return [line(columns), f"|{'---|' * len(columns)}", *map(line, rows)]


def share(what: str, asked: str, some: Sequence[T], holds: Callable[[T], bool]) -> str:
    """A row: what was asked, of how many, and of how many of them it holds."""
    count = sum(map(holds, some))
    held = f"{100.0 * count / len(some):.0f} % ({count} of {len(some)})" if some else "–"
    return line((what, asked, len(some), held))


def publish(name: str, page: str, write: bool, wrong: bool) -> None:
    """Print a page; write: into the evidence. Exit 1 where something is wrong."""
    print(page)
    if write:
        (EVIDENCE / name).write_text(page, encoding="utf-8")
    if wrong:
        raise typer.Exit(1)
