"""The whole: two days of production, judged, written down, and nothing left running."""

import os
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

import psutil

from flows.terminal import counting, stdout, working
from tests.proof.factory import works as parts
from tests.proof.factory.close import closed, read
from tests.proof.factory.disturbances import PARTS
from tests.proof.factory.draw import FULL, OrderedUnit, ordered
from tests.proof.factory.guard import adopt, left
from tests.proof.factory.judge import Row, judged, none_of
from tests.proof.factory.page import ABOUT, page, table_of
from tests.proof.factory.part import end_all
from tests.proof.factory.play import Played, play
from tests.proof.factory.stop import WITHIN_S
from tests.proof.factory.works import STATIONS, Works
from tests.proof.load import busy

LONGEST_S = 900.0  # what the issue allows
HELD_S = 60.0  # once every part is up again
ENDS_WITHIN_S = 15.0  # a flow run whose worker is gone
SHARED = Path("/dev/shm")


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
