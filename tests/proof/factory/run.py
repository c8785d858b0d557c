"""The whole: two days of production, judged, written down, and nothing left running."""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

import psutil
import typer

from flows.terminal import counting, stdout, working
from tests.proof.factory import works as parts
from tests.proof.factory.close import closed, read
from tests.proof.factory.draw import FULL, OrderedUnit, ordered
from tests.proof.factory.judge import Row, judged, none_of
from tests.proof.factory.operators import WITHIN_S
from tests.proof.factory.play import OF_A_RUN, PARTS, Played, play
from tests.proof.factory.processes import Part, adopt, end_all, guarded, left
from tests.proof.factory.works import STATIONS, Works
from tests.proof.study import table

LONGEST_S = 900.0  # what the issue allows
HELD_S = 60.0  # once every part is up again
ENDS_WITHIN_S = 15.0  # a flow run whose worker is gone
SHARED = Path("/dev/shm")
LOOP = [sys.executable, "-c", "while True: pass"]
COLUMNS = ("promise", "expected", "got", "verdict")
ABOUT = """# The factory

`make factory ARGS="--units {units} --seed {seed}"`, {machine}: PostgreSQL, a Prefect server behind
authentication, two stations with a worker each, a worker for the line, a dask scheduler with two
workers, an S3 server, the pages and a mail server, each killed (SIGKILL) once while {units} units
were produced in {minutes:.1f} min. {full} units were measured by `jjf2003` as it is shipped, the
others by the same clauses with dwells of {dwell:g} s in place of 30 s, on which no unit passes: a
run of the shipped procedure alone costs two cores a minute. The stations' clocks ran up to
{speed:g} times as fast, so that these are {hours:.0f} h of each station, and their tables kept ten
encoder samples a second.
"""


@dataclass(frozen=True)
class Settings:
    """What is played, and where it is written down. longest_s: after which production ends.
    is_busy: whether other programs want every core meanwhile. parts: what is killed. within_s: what
    production may take. about: the text before the table.
    """

    units: int
    seed: int
    speed: float
    out: Path | None
    longest_s: float
    is_busy: bool
    parts: tuple[str, ...] = PARTS
    within_s: float = LONGEST_S
    about: str = ABOUT


def run(settings: Settings) -> int:
    """Exit code: 0 only if every promise holds."""
    adopt()
    folder = Path(tempfile.mkdtemp(prefix="mimucal-factory-"))
    shared = set(SHARED.glob("*"))
    works = Works(folder, settings.speed)
    units = ordered(settings.seed, settings.units, STATIONS)
    rows: list[Row] = []
    played: Played | None = None
    try:
        with working("the factory starts"):
            works.start()
            works.deploy()
            works.start_workers()
        others = busy(os.cpu_count() or 1) if settings.is_busy else nullcontext()
        with counting("orders") as report, others:
            played = play(works, units, settings.seed, settings.longest_s, report, settings.parts)
        rows += produced(played, units, settings)
        with working("the books are closed"):
            rows += closed(works)
            rows[:0] = judged(played.units, read(works))
    except BaseException as fault:
        rows.append(Row("The play ends", "at its end", f"{type(fault).__name__}: {fault}", False))
        if not isinstance(fault, Exception):
            raise
    finally:
        works.end()
        rows += nothing_left(works, shared)
        written(rows, played, works, settings)
    holds = all(each.holds for each in rows)
    if holds:
        shutil.rmtree(folder)
    else:
        print(f"logs and everything else: {folder}", file=sys.stderr)
    return 0 if holds else 1


def produced(played: Played, units: tuple[OrderedUnit, ...], settings: Settings) -> Iterator[Row]:
    """What is promised of the production itself."""
    minutes = settings.within_s / 60
    yield Row(
        f"{len(units)} units in at most {minutes:g} min", f"≤ {minutes:g} min",
        f"{played.seconds / 60:.1f} min", played.seconds <= settings.within_s,
    )  # fmt: skip
    back = Counter(each.part for each in played.happened)
    yield none_of(
        "Each part was killed as often as planned and came back", (Counter(settings.parts) - back)
    )
    yield Row(
        "No order is held by a dead process for longer than a minute", f"≤ {HELD_S:g} s",
        f"{played.held_s:.0f} s", played.held_s <= HELD_S,
    )  # fmt: skip
    refused = any(each.startswith(played.wrong) and "mount" in each for each in played.events)
    yield Row(
        "The wrong unit on the table is refused", "refused",
        "refused" if refused else "measured", refused,
    )  # fmt: skip
    stop = played.stop
    is_stopped = stop.is_at_rest and stop.seconds is not None and stop.seconds <= WITHIN_S
    got = f"{stop.seconds} s, at rest: {stop.is_at_rest} {'' if is_stopped else stop.answer}"
    yield Row(
        "A stop that is pressed brings the table to rest", f"≤ {WITHIN_S:g} s", got, is_stopped
    )


def nothing_left(works: Works, shared: set[Path]) -> Iterator[Row]:
    """Processes, ports and shared memory of the factory."""
    end_s = time.monotonic() + ENDS_WITHIN_S
    while (alive := left()) and time.monotonic() < end_s:
        time.sleep(0.5)
    yield none_of("No process is left", map(_named, alive))
    end_all(alive)
    yield none_of("No port is taken", (
        f"{name} {port}" for name, port in works.ports.items() if parts.listens(port)
    ))  # fmt: skip
    yield none_of("No shared memory is left", map(str, _forgotten(set(SHARED.glob("*")) - shared)))


def _forgotten(memory: set[Path]) -> set[Path]:
    """Shared memory that no process uses: what is in use is that of other programs."""
    used = set()
    for process in psutil.process_iter():
        try:
            used |= {Path(each.path) for each in process.memory_maps()}
        except psutil.Error:
            continue
    return {path for path in memory - used if path.exists()}


def _named(process: psutil.Process) -> str:
    try:
        return f"{process.pid} {' '.join(process.cmdline())[:120]}"
    except psutil.Error:
        return str(process.pid)


def written(rows: list[Row], played: Played | None, works: Works, settings: Settings) -> None:
    """The table, on standard output and where it is asked for."""
    about = settings.about.format(
        units=settings.units, seed=settings.seed, speed=settings.speed,
        machine=f"on a machine with {os.cpu_count()} cores",
        minutes=played.seconds / 60 if played else 0.0, full=min(FULL, settings.units),
        dwell=parts.DWELL_S, hours=(played.seconds if played else 0.0) * settings.speed / 3600,
    )  # fmt: skip
    stdout(markup=False).print(table_of(rows), highlight=False, soft_wrap=True)
    if settings.out is not None:
        settings.out.write_text(
            page(about, rows, played, list(works.parts.values())), encoding="utf-8"
        )


@contextmanager
def busy(cores: int) -> Iterator[None]:
    """Endless loops, one for each core, for the length of the block."""
    loops = [subprocess.Popen(LOOP) for _ in range(cores)]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


def table_of(rows: Sequence[Row]) -> str:
    """A row for each promise."""
    return "\n".join(table(COLUMNS, (
        (row.promise, row.expected, row.got, "holds" if row.holds else "**FAILS**") for row in rows
    )))  # fmt: skip


def page(
    about: str, rows: Sequence[Row], played: Played | None, parts: Sequence[Part]
) -> str:  # fmt: skip
    """about: the text before the table. parts: as they ended, with what they used."""
    text = [about, table_of(rows), ""]
    if played is not None:
        killed = ((each.part, each.after, f"{each.away_s:.1f}") for each in played.happened)
        text += table(("killed", "after orders", "answers again after (s)"), killed)
        if played.events:
            text += ["", "What the operators had to do:", ""]
            text += [f"- {' '.join(event.split())}" for event in played.events]
    used = sorted(parts, key=lambda part: -part.processor_s)
    text += ["", *table(("part, with what it started", "processor (s)"),
                        ((part.name, f"{part.processor_s:.0f}") for part in used))]  # fmt: skip
    return "\n".join((*text, ""))


# The commands: the factory for two days, and a line whose parts are killed again and again.

SPEED = 100.0
KILLED_AGAIN = """# A line whose parts are killed again and again

`make prove ARGS="line-kills --units {{units}} --each {each} --seed {{seed}}"`, {{machine}}:
[the factory](../../../deploy/factory.md), {{units}} units in {{minutes:.1f}} min, with SIGKILL
{each} times each for the database, Prefect's server, the process of a run, a station and its
worker, one kill at a time and at a random moment, the next once its part answers again.
"""
Units = Annotated[int, typer.Option(metavar="N", min=4, help="Units that are ordered.")]
Draws = Annotated[int, typer.Option("--seed", min=0, help="Draws units, faults and kills.")]
Longest = Annotated[
    float, typer.Option("--minutes", min=1.0, help="Production is broken off after so long.")
]
Table = Annotated[
    Path | None, typer.Option("--out", metavar="FILE", help="The table is written here.")
]


def factory(
    units: Units = 100, seed: Draws = 1,
    speed: Annotated[
        float, typer.Option(min=1.0, help="Station seconds in a second, at most.")
    ] = SPEED,
    minutes: Longest = 2 * LONGEST_S / 60,
    busy: Annotated[
        bool, typer.Option("--busy", help="Other programs want every core meanwhile.")
    ] = False,
    out: Table = None,
) -> None:  # fmt: skip
    """Two days of production with everything that it needs; exits with 1 if a promise broke."""
    sys.exit(guarded(partial(run, Settings(units, seed, speed, out, minutes * 60, busy))))


def line_kills(
    each: Annotated[int, typer.Option(min=1, help="Kills of each part.")] = 20,
    units: Units = 100, seed: Draws = 1, minutes: Longest = 120.0, out: Table = None,
) -> None:  # fmt: skip
    """Parts of a line killed again and again; exits with 1 if a promise broke.

    A kill takes as long as an order: with fewer units the last runs end before their kills.
    """
    station = STATIONS[0]
    parts = ("PostgreSQL", "Prefect server", OF_A_RUN, f"worker station-{station}", station)
    settings = Settings(
        units, seed, SPEED, out, minutes * 60, is_busy=False, parts=parts * each,
        within_s=minutes * 60, about=KILLED_AGAIN.format(each=each),
    )  # fmt: skip
    sys.exit(guarded(partial(run, settings)))
