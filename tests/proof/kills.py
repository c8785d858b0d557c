"""An acquisition killed (SIGKILL) at a random moment, and its file held against the unit's line."""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import astuple, dataclass
from functools import cache, partial
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np

from schemas.base import Unusable
from schemas.calibration import Calibration, Item
from schemas.procedure import Procedure
from schemas.recording import ACCEL, GYRO, MEASURED, Recording
from schemas.station import StationFile
from storage.catalogue import runs
from storage.catalogue.run_index import Run
from storage.formats.mcap.reader import read_mcap
from storage.home import Home
from tasks.calibrate.calibrate import calibrate
from tasks.calibrate.evaluation import evaluation_for
from tasks.specifications.register import specification_for
from tasks.stages.acquire import acquire_run
from tasks.stages.left_run import left_runs
from tasks.station import procedures
from tasks.station.acquisition import Acquired
from tasks.station.run_manifest import interrupted
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.process import running
from tests.proof.study import Count, Out, Seed, Write, folder_of, hold, table
from tests.proof.virtual_runs import Sent, Tap, comes_to_rest, run_in_memory, short_procedure
from tests.tasks.station.over_sockets import ignore

BOUND_S = 2.0  # wall time: what a kill or a power cut may cost
SPEED = 5.0
LONGEST_S = 4.0  # a kill comes so long after the first bytes of the file at the latest
START_S = 120.0
Moments = tuple[float, float]
ACQUIRE = """
import sys
from flows import run_orders
from schemas.orders import (AcquireOrder)
run_orders.acquire(AcquireOrder(station=sys.argv[1], procedure=sys.argv[2], attended=False))
"""


@dataclass(frozen=True)
class Killed:
    """What one kill left: when it came after the file's first bytes (s), readings that were sent
    and recovered, by how much the last one recovered is older than the kill (s), and what is wrong.
    """

    seed: int
    after_s: float
    sent: int
    recovered: int
    lost_s: float
    faults: tuple[str, ...]


def kill(seed: int, folder: Path) -> Killed:
    """Acquire in a new folder from a virtual station of its own, and kill at a random moment."""
    config = VirtualStation()
    after_s = random.Random(seed).uniform(0.0, LONGEST_S)
    folder = folder / f"{seed:03d}"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    procedure = folder / "procedure.json"
    procedure.write_text(procedures.load("jjf2003").model_dump_json(), encoding="utf-8")
    with running(config, SPEED) as station:
        unit = urlsplit(station.unit_link.url)
        tap = Tap((str(unit.hostname), int(unit.port or 0)))
        # the tap passes nothing on to the unit
        link = station.unit_link.model_copy(update={"url": tap.url, "identify": None})
        file = folder / "station.json"
        tapped = station.model_copy(update={"unit_link": link})
        file.write_text(tapped.model_dump_json(), encoding="utf-8")
        moments = acquire_and_kill(file, procedure, folder, after_s)
        tap.close()
    counts = np.array([config.unit.gyro.lsb] * 3 + [config.unit.accel.lsb] * 3)
    return judged(seed, after_s, folder, tap.sent(), moments, counts)


def acquire_and_kill(station: Path, procedure: Path, home: Path, after_s: float) -> Moments:
    """When its file had its first bytes, and when it was killed, s (monotonic)."""
    with subprocess.Popen(
        [sys.executable, "-c", ACQUIRE, station, procedure],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"MIMUCAL_HOME": str(home)},
    ) as process:
        try:
            end = time.monotonic() + START_S
            while not any(path.stat().st_size for path in (home / "acquiring").glob("*.mcap")):
                if process.poll() is not None or time.monotonic() > end:
                    raise Unusable(f"seed {home.name}: the acquisition did not start")
                time.sleep(0.01)
            began_s = time.monotonic()
            time.sleep(after_s)
            if process.poll() is not None:
                raise Unusable(f"seed {home.name}: the acquisition ended before it was killed")
        finally:
            killed_s = time.monotonic()
            process.send_signal(signal.SIGKILL)
    return began_s, killed_s


def judged(
    seed: int, after_s: float, folder: Path, sent: Sent, moments: Moments, scale: np.ndarray
) -> Killed:
    """The file of a killed acquisition against what was sent.

    moments: when the file had its first bytes, which are the manifest of a run that begins, and
    when the kill came; scale: (6,) of the counts, in SI. What was sent before the run is not due.
    """
    began_s, killed_s = moments
    due = int(np.searchsorted(sent.passed_s, killed_s - BOUND_S))
    is_due = due > np.searchsorted(sent.passed_s, began_s)
    (file,) = (folder / "acquiring").glob("*.mcap")
    try:
        saved = read_mcap(file, salvage=True)
    except Unusable as nothing:
        lost = (str(nothing),) if is_due else ()
        return Killed(seed, after_s, len(sent.stamps), 0, 0.0, lost)
    place, faults = _compared(saved, sent, scale)
    end = place + len(saved.imu)
    if is_due and end < due:
        faults.append(f"{due - end} readings sent {BOUND_S:g} s before the kill are lost")
    lost_s = killed_s - float(sent.passed_s[min(end, len(sent.stamps)) - 1])
    return Killed(seed, after_s, len(sent.stamps), len(saved.imu), lost_s, tuple(faults))


def _compared(saved: Recording, sent: Sent, scale: np.ndarray) -> tuple[int, list[str]]:
    """Which frame the first reading is, and in what the readings are not those that were sent."""
    counts = np.rint(saved.imu.stack(GYRO + ACCEL) / scale).astype(np.int64)
    alike = np.flatnonzero((sent.counts == counts[0]).all(axis=1))
    if not len(alike):
        return 0, ["the first reading was never sent"]
    place = int(alike[0])
    theirs = slice(place, place + len(counts))
    faults = []
    if not np.array_equal(sent.counts[theirs], counts):
        faults.append("readings are not those that were sent")
    steps = np.rint(np.diff(saved.imu.t) * 1e6).astype(np.int64)
    if not np.array_equal(np.diff(sent.stamps[theirs]), steps):
        faults.append("times are not those that were sent")
    if saved.table is not None and len(saved.table) > 2:
        periods = np.diff(saved.table.t)
        if not np.allclose(periods, periods[0], atol=2e-9):
            faults.append("captured encoders are missing between others")
    if (saved.manifest.model_extra or {}).get("acquired_at") is None:
        faults.append("the recording has no day")
    return place, faults


# Many kills, and the page of them.

AT_ONCE = 3
COLUMNS = ("seed", "kill after (s)", "sent", "recovered", "lost (s)", "wrong")


def kills(count: Count = 100, seed: Seed = 1, out: Out = None, write: Write = False) -> None:
    """Acquisitions killed at random moments: what is recovered is what the unit sent."""
    folder = folder_of("kills", out)
    hold("kills", seeds(count, seed), partial(kill, folder=folder), kills_page, out, write=write,
         at_once=AT_ONCE, faults=lambda one: one.faults)  # fmt: skip


def seeds(count: int, first: int) -> dict[str, int]:
    return {f"{seed:04d}": seed for seed in range(first, first + count)}


def kills_summary(killed: Sequence[Killed]) -> str:
    """One sentence."""
    wrong = sum(bool(each.faults) for each in killed)
    with_rows = [each.lost_s for each in killed if each.recovered]
    return (
        f"{len(killed)} acquisitions killed at random moments: {wrong} against the bound of "
        f"{BOUND_S:g} s; of the {len(with_rows)} that had readings on the disk the last one was "
        f"at most {max(with_rows, default=0.0):.2f} s older than the kill"
    )


def kills_page(killed: Sequence[Killed]) -> str:
    """The summary, how it was held, and a row for each kill."""
    rows = [
        (seed, f"{after:.2f}", sent, recovered, f"{lost:.2f}", "; ".join(wrong))
        for seed, after, sent, recovered, lost, wrong in map(astuple, killed)
    ]
    return "\n".join([
        "# Kills",
        "",
        f"{kills_summary(killed)}.",
        "",
        f"Each on a virtual station of its own at {SPEED:g} times the clock, with a log of the",
        "unit's line beside it. What is recovered must be what was sent, reading by reading and",
        f"stamp by stamp, and hold all that was sent {BOUND_S:g} s before the kill.",
        "",
        *table(COLUMNS, rows),
        "",
    ])  # fmt: skip


# An acquisition that is killed and then goes on with `--resume`.

RESUMES_SPEED = 40.0
ATTEMPTS = 5  # to go on: a computer that is too busy stops a run, too


def killed_and_resumed(
    station: StationFile, procedure: Procedure, home: Home, after_s: float
) -> tuple[Run, Acquired, int]:
    """A run that is killed so long (s) after its first bytes, and then goes on; and how many of
    its measured segments stood after the kill.

    Where the kill left no reading, it begins anew. Raises Unusable where the table did not come to
    rest after the kill, and as `acquire_run` does.
    """
    acquire_and_kill(*_files(station, procedure, home.path), home.path, after_s)
    if not comes_to_rest(station, VirtualStation().unit.gyro.lsb):
        raise Unusable("the table still turns, long after the acquisition was killed")
    stood = _standing(station, procedure, home) or 0
    for _ in range(ATTEMPTS):
        resume = _standing(station, procedure, home) is not None
        try:
            (kept,) = acquire_run(station, procedure, home, ignore, resume=resume).kept
        except Unusable as stop:
            last = stop
        else:
            return *kept, stood
    raise last


def _files(station: StationFile, procedure: Procedure, folder: Path) -> tuple[Path, Path]:
    folder.mkdir(parents=True, exist_ok=True)
    files = folder / "station.json", folder / "procedure.json"
    for file, content in zip(files, (station, procedure), strict=True):
        file.write_text(content.model_dump_json(), encoding="utf-8")
    return files


def _standing(station: StationFile, procedure: Procedure, home: Home) -> int | None:
    """How many measured segments of the interrupted run stand; None where there is none."""
    try:
        (left,) = left_runs(station, procedure, home).values()
    except Unusable:
        return None
    return len(interrupted(left.recording, station.unit_link).measured())


# An acquisition that is killed and goes on: its values against those of an uninterrupted run.

DWELL_S = 31.0  # what the specification asks, and a little more
LATEST = 0.9  # of the time that an uninterrupted run takes at least
WARM_UP_S = 600.0  # of JJF 2003: a unit that is still cold has other biases
RESUMES_COLUMNS = (
    "seed", "kill after (s)", "segments kept", "measured then", "run", "largest difference (U)",
    "of",
)  # fmt: skip


@dataclass(frozen=True)
class Resumed:
    """One run that was killed and went on.

    kept: measured segments that stood after the kill; again: those that were then measured.
    validity: the verdict on the run. worst: its largest difference from the uninterrupted run, by
    the U of that difference, and of which element.
    """

    seed: int
    after_s: float
    kept: int
    again: int
    validity: str
    worst: float = 0.0
    element: str = ""

    @property
    def holds(self) -> bool:
        return self.worst <= 1.0


def resumes(count: Count = 10, seed: Seed = 1, out: Out = None, write: Write = False) -> None:
    """Acquisitions that are killed and go on, against an uninterrupted run."""
    folder = folder_of("resumes", out)
    hold("resumes", seeds(count, seed), partial(_resumed, folder=folder), resumes_page, out,
         write=write, at_once=AT_ONCE,
         faults=lambda one: [] if one.holds else [f"seed {one.seed}: {one.element}"])  # fmt: skip


@cache
def _uninterrupted() -> tuple[Calibration, float, Procedure]:
    """The values of a whole run, how long it takes (s of the wall clock), and its procedure."""
    procedure = short_procedure(DWELL_S, "x", WARM_UP_S)
    whole = run_in_memory(procedure, VirtualStation()).recording
    assert whole is not None
    return _calibrated(whole), float(whole.imu.t[-1]) / RESUMES_SPEED, procedure


def _resumed(seed: int, folder: Path) -> Resumed:
    whole, whole_s, procedure = _uninterrupted()
    after_s = random.Random(seed).uniform(WARM_UP_S / RESUMES_SPEED, LATEST * whole_s)
    home = Home(folder / f"{seed:03d}")
    with running(VirtualStation(), RESUMES_SPEED) as station:
        run, acquired, kept = killed_and_resumed(station, procedure, home, after_s)
    resumed = _calibrated(runs.load(run, home))
    segments = sum(each.kind in MEASURED for each in acquired.manifest.segments or ())
    validity = resumed.validity.verdict
    worst, element = worst_difference(resumed, whole)
    return Resumed(seed, after_s, kept, segments - kept, validity, worst, element)


def _calibrated(recording: Recording) -> Calibration:
    return calibrate(
        specification_for(recording.manifest.standard), recording, run="", code_version="",
        evaluation=evaluation_for(recording),
    )  # fmt: skip


def worst_difference(one: Calibration, other: Calibration) -> tuple[float, str]:
    """The largest difference of a value in units of that of its two U, and of which element it is.

    A value that only one of them has differs without bound.
    """
    worst, where = 0.0, ""
    for name, item in one.items.items():
        for element, value in item.value.items():
            against, reach = (
                other.items[name].value[element],
                _reach(item, other.items[name], element),
            )
            if (value is None) != (against is None):
                return float("inf"), f"{name}.{element}"
            if value is not None and against is not None and reach:
                worst, where = max(
                    (worst, where), (abs(value - against) / reach, f"{name}.{element}")
                )
    return worst, where


def _reach(one: Item, other: Item, element: str) -> float:
    """Expanded uncertainty of the difference of two independent values, as in E_n."""
    return float(np.hypot(one.U.get(element) or 0.0, other.U.get(element) or 0.0))


def resumes_summary(found: Sequence[Resumed]) -> str:
    """One sentence."""
    return (
        f"{len(found)} acquisitions killed at random moments and gone on with: "
        f"{sum(each.holds for each in found)} have the values of an uninterrupted run within "
        f"U; the largest difference is {max(each.worst for each in found):.2f} U"
    )


def resumes_page(found: Sequence[Resumed]) -> str:
    """The summary, how it was held, and a row for each run."""
    rows = [
        (seed, f"{after:.1f}", kept, again, validity, f"{worst:.2f}", element)
        for seed, after, kept, again, validity, worst, element in map(
            astuple, sorted(found, key=lambda each: each.seed)
        )
    ]
    return "\n".join([
        "# Runs that were killed and went on",
        "",
        f"{resumes_summary(found)}.",
        "",
        f"Each on a virtual station of its own, with the same unit, at {RESUMES_SPEED:g} times the",
        f"clock: after the warm-up of {WARM_UP_S:g} s the acquisition is killed (SIGKILL), the",
        "watchdog brings the table to rest, and `acquire --resume` warms up and measures what is",
        "missing.",
        "The uninterrupted run is of the same procedure, in simulated time. Differences are",
        "counted in the expanded uncertainty U of a difference of two such values,",
        "√(U₁² + U₂²), as E_n does.",
        "",
        *table(RESUMES_COLUMNS, rows),
        "",
    ])  # fmt: skip
