"""What a command prints: tables, JSON, progress, questions. Imports nothing heavy."""

import asyncio
import json
import os
import sys
import termios
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.cells import cell_len
from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    ProgressColumn,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table
from rich.text import Text

from schemas.base import Unusable
from schemas.procedure import Refix
from schemas.text import text_of
from storage.dataframes import TABLES, records, written
from storage.home import home
from storage.whole_files import drafted, written_out
from tasks.words import message, texts

if TYPE_CHECKING:
    import pandas as pd

    from tasks.station.ports import Ask


# Prints tables and JSON on standard output; imports nothing heavy, so that listing is fast.

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


# Progress of long work on standard error: the current step and the remaining time.

CONSOLE = Console(stderr=True)
_spinners: list[Callable[[str, float], None]] = []  # of each `working` that is open
SOON = 0.05  # share of the work, below which the remaining time is not estimated


def _bar(*columns: ProgressColumn) -> Progress:
    return Progress(*columns, console=CONSOLE, transient=True, disable=not CONSOLE.is_terminal)


@contextmanager
def working(description: str) -> Iterator[None]:
    """A spinner with the elapsed time, for work of unknown duration."""
    text = TextColumn("{task.description}", markup=False)
    with _bar(SpinnerColumn(), text, TimeElapsedColumn()) as bar:
        shown, began = bar.add_task(description, total=None), time.monotonic()

        def show(now: str, behind: float) -> None:
            left = remaining(time.monotonic() - began, behind)
            bar.update(shown, description=f"{description}: {now}{left}")

        _spinners.append(show)
        try:
            yield
        finally:
            _spinners.pop()


def remaining(elapsed: float, behind: float) -> str:
    """The remaining time of work, from the share done and the seconds taken; early on, nothing."""
    return "" if behind < SOON else f", about {elapsed * (1.0 / behind - 1.0):.0f} s left"


def describe(now: str, behind: float) -> None:
    """Shows the current step and the remaining time beside the spinner, if there is one.

    behind: the share (0 to 1) of the work that is done.
    """
    for show in _spinners[-1:]:
        show(now, behind)


@contextmanager
def counting(description: str) -> Iterator[Callable[[int, int], None]]:
    """A progress bar over counted things, with the remaining time.

    Yields the function (done, total) that advances it.
    """
    count = TextColumn("{task.completed:.0f} of {task.total:.0f}")
    with _bar(TextColumn(description), BarColumn(), count, TimeRemainingColumn()) as bar:
        shown = bar.add_task(description, total=1)
        yield lambda done, total: bar.update(shown, completed=done, total=total)


# `mimucal table`: what the store holds, as CSV or Parquet.

PARTITIONS = ["station", "month"]


def print_table(what: str, form: str, out: Path | None) -> None:
    """Write a table as `write_table` does, and say so in one JSON document; without a file the
    document has the rows themselves.
    """
    if out is None and form != "csv":
        raise Unusable(f"--json shows no {form}; leave --as out, or give a file with --out")
    if out is not None or what not in TABLES:
        write_table(what, form, out)
        content: dict[str, Any] = {"as": form, "path": str(out)}
    else:
        content = {"rows": records(what, home())}
    document = {"format": "mimu-table/1", "table": what, **content}
    print(json.dumps(document, ensure_ascii=False, indent=1, default=str))


def write_table(what: str, form: str, out: Path | None) -> None:
    """Write a table to a file, to a folder of Parquet files, or to standard output."""
    if what not in TABLES:
        raise Unusable(f"{what!r} is not a table; choose one of {', '.join(TABLES)}.")
    if form not in ("csv", "parquet"):
        raise Unusable(f"--as {form}: choose one of csv, parquet")
    if form == "parquet" and out is None and sys.stdout.isatty():
        raise Unusable("--as parquet cannot be shown in a terminal; give a file with --out")
    if form == "csv" and out is None:
        written(what, home(), sys.stdout)
    elif form == "csv" and out is not None:
        with written_out(out) as draft, draft.open("w", encoding="utf-8", newline="") as file:
            written(what, home(), file)
    else:
        _to_parquet(TABLES[what](home()), out)


def _to_parquet(table: "pd.DataFrame", out: Path | None) -> None:
    if out is None:
        sys.stdout.buffer.write(table.to_parquet(index=False))
    elif not out.suffix:
        _to_folder(table, out)
    else:
        with written_out(out) as draft:
            table.to_parquet(draft, index=False)


def _to_folder(table: "pd.DataFrame", folder: Path) -> None:
    """One file for each station and month of recording, as pyarrow, duckdb and Spark read them."""
    month = table["recorded_on"].map(lambda day: f"{day:%Y-%m}" if day else "unknown")
    try:
        with drafted(folder) as draft:
            draft.mkdir(parents=True)  # of no rows no file is written
            table.assign(month=month).to_parquet(draft, index=False, partition_cols=PARTITIONS)
    except FileExistsError as error:
        raise Unusable(f"{folder} is already there; name a new folder with --out.") from error
    except OSError as error:
        raise Unusable(
            f"{folder} cannot be written ({error.strerror}); name another with --out."
        ) from error


# Asks the person at the terminal to turn the unit over where the station cannot, and who it is.


def at_terminal() -> "Ask | None":
    """The prompt for the person at the terminal; None if standard input is not a terminal."""
    return _ask if sys.stdin is not None and sys.stdin.isatty() else None


def ask_for_operator() -> str | None:
    """The name of the person at the terminal; None without one, or where nothing is answered."""
    if at_terminal() is None:
        return None
    CONSOLE.print(*texts(message("flows-who-operates")).values(), sep=" ", end=" ", markup=False)
    return sys.stdin.readline().strip() or None


async def _ask(refix: Refix) -> None:
    """Says what is to be done and waits for Enter; a key pressed earlier does not count.

    Acquisition continues meanwhile. Raises Unusable if the terminal is closed.
    """
    terminal = sys.stdin.fileno()
    termios.tcflush(terminal, termios.TCIFLUSH)
    if instruction := text_of(refix, "instruction"):
        CONSOLE.print(*instruction.words.values(), sep="\n", markup=False)
    CONSOLE.print(*texts(message("flows-press-enter")).values(), markup=False)
    loop, pressed = asyncio.get_running_loop(), asyncio.Event()
    loop.add_reader(terminal, pressed.set)
    try:
        await pressed.wait()
    finally:
        loop.remove_reader(terminal)
    if not os.read(terminal, 4096):
        raise Unusable("the terminal was closed before the unit was turned over: start again")
