"""What a measurement costs in processor time, and sections of figures that go beside each other.

Processor time (user and system) of one thread, because it depends little on what else the machine
does; the ratios of a section are of one run, one after the other.
"""

import os
import resource
import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median

RUNS = 5


@dataclass(frozen=True)
class Figure:
    """Seconds that something takes; asked: the ratio to the section's first figure to keep to."""

    name: str
    seconds: float
    asked: float | None = None


@dataclass(frozen=True)
class Section:
    """Figures of the same work; ratios are to the first. faster: they are ratios of speed."""

    title: str
    figures: tuple[Figure, ...]
    note: str = ""
    faster: bool = False

    def ratio(self, figure: Figure) -> float:
        """How many times as long as the first figure; with `faster`, how many times as fast."""
        ratio = figure.seconds / self.figures[0].seconds
        return 1.0 / ratio if self.faster else ratio


def processor_s(work: Callable[[], object], runs: int = RUNS) -> float:
    """Median processor time of some runs in this process, after one that is not counted."""
    work()
    return median(_timed(work, time.process_time) for _ in range(runs))


def processor_s_of(command: Sequence[str], environment: dict[str, str], runs: int = RUNS) -> float:
    """The same of a command and what it starts."""

    def children_s() -> float:
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    # With its byte code kept, as it is for a user.
    variables = {n: v for n, v in os.environ.items() if n != "PYTHONDONTWRITEBYTECODE"}

    def run() -> None:
        subprocess.run(command, env=variables | environment, check=True, capture_output=True)

    run()
    return median(_timed(run, children_s) for _ in range(runs))


def wall_s(work: Callable[[], object]) -> float:
    """Seconds that pass, once."""
    return _timed(work, time.perf_counter)


def _timed(work: Callable[[], object], clock: Callable[[], float]) -> float:
    began = clock()
    work()
    return clock() - began
