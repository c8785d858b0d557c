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
from functools import partial
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np

from schemas.base import Unusable
from schemas.procedure import Procedure
from schemas.recording import ACCEL, GYRO, Recording
from schemas.station import StationFile
from storage.catalogue.runs import Run
from storage.formats.mcap.reader import read_mcap
from storage.home import Home
from tasks.stages.acquire import acquire_run, left_runs
from tasks.station import procedures
from tasks.station.acquisition import Acquired
from tasks.station.run_manifest import interrupted
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.servers import running
from tests.proof.study import Count, Out, Seed, Write, folder_of, hold, table
from tests.proof.virtual_runs import Sent, Tap, comes_to_rest
from tests.tasks.station.over_sockets import ignore

BOUND_S = 2.0  # wall time: what a kill or a power cut may cost
SPEED = 5.0
LONGEST_S = 4.0  # a kill comes so long after the first bytes of the file at the latest
START_S = 120.0
Moments = tuple[float, float]
ACQUIRE = """
import sys
from flows import execute as run_orders
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
    hold("kills", seeds(count, seed), partial(kill, folder=folder), as_markdown, out, write=write,
         at_once=AT_ONCE, faults=lambda one: one.faults)  # fmt: skip


def seeds(count: int, first: int) -> dict[str, int]:
    return {f"{seed:04d}": seed for seed in range(first, first + count)}


def summary(killed: Sequence[Killed]) -> str:
    """One sentence."""
    wrong = sum(bool(each.faults) for each in killed)
    with_rows = [each.lost_s for each in killed if each.recovered]
    return (
        f"{len(killed)} acquisitions killed at random moments: {wrong} against the bound of "
        f"{BOUND_S:g} s; of the {len(with_rows)} that had readings on the disk the last one was "
        f"at most {max(with_rows, default=0.0):.2f} s older than the kill"
    )


def as_markdown(killed: Sequence[Killed]) -> str:
    """The summary, how it was held, and a row for each kill."""
    rows = [
        (seed, f"{after:.2f}", sent, recovered, f"{lost:.2f}", "; ".join(wrong))
        for seed, after, sent, recovered, lost, wrong in map(astuple, killed)
    ]
    return "\n".join([
        "# Kills",
        "",
        f"{summary(killed)}.",
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
