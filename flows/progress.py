"""Progress of long work on standard error: the current step and the remaining time."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

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
