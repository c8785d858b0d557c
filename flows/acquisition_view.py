"""Progress of an acquisition on standard error: a live view in a terminal, otherwise a line."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from flows.terminal import CONSOLE
from schemas.recording import RunStatus
from tasks.words import say

if TYPE_CHECKING:
    from rich.console import RenderableType

    from tasks.station.acquisition import Progress as AcquisitionProgress


PLAIN_EVERY_S = 30.0  # a short run that fails prints only its one sentence
UNITS = {"gyro": "°/s", "accel": "m/s²"}


@contextmanager
def acquisition_view() -> "Iterator[Callable[[AcquisitionProgress], None]]":
    """Yields the function that shows the status of a run."""
    if not CONSOLE.is_terminal:
        yield plain_lines()
        return
    with Live(Text("connecting"), console=CONSOLE, auto_refresh=False) as live:
        yield lambda progress: live.update(view(progress), refresh=True)


def plain_lines() -> "Callable[[AcquisitionProgress], None]":
    """A status line on standard error every PLAIN_EVERY_S of wall time."""
    printed_s = time.monotonic()

    def show(progress: "AcquisitionProgress") -> None:
        nonlocal printed_s
        if time.monotonic() - printed_s >= PLAIN_EVERY_S:
            printed_s = time.monotonic()
            fields = (f"{name} {value}" for name, value in facts(progress).items())
            print("; ".join(fields), file=sys.stderr, flush=True)

    return show


def view(progress: "AcquisitionProgress") -> Table:
    """A table of facts, with the alarms last."""
    table = Table.grid(padding=(0, 2))
    for name, value in facts(progress).items():
        shown: RenderableType = Text(value, style="bold red" if name == "alarms" else "")
        table.add_row(Text(name, style="dim"), shown)
        if name == "time":
            done, total = progress.station_s_done, max(progress.station_s_total, 1e-9)
            table.add_row("", ProgressBar(total=total, completed=done, width=50))
    return table


def facts(progress: "AcquisitionProgress | RunStatus") -> dict[str, str]:
    """State, segment, time, rates, noise and alarms in words; unknown ones are left out."""
    rates = ", ".join(f"{name} {hertz:.1f} Hz" for name, hertz in progress.rates_hz.items())
    noise = ", ".join(f"{name} {value:.2g} {UNITS[name]}" for name, value in progress.noise.items())
    state = progress.state.replace("_", " ")
    shown = {
        "state": state if progress.now == state else f"{state}: {progress.now}",
        "segment": f"{progress.segment} of {progress.segments}" if progress.segment else "",
        "time": f"{progress.station_s_done:.0f} of {progress.station_s_total:.0f} s station time, "
        f"{progress.wall_s_left:.0f} s left",
        "rates": rates,
        "noise": noise,
        "alarms": ", ".join(say(alarm) for alarm in progress.alarms),
    }
    return {name: value for name, value in shown.items() if value}
