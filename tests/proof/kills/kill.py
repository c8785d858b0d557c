"""An acquisition killed (SIGKILL) at a random moment, and its file held against the unit's line."""

import os
import random
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np

from schemas.base import Unusable
from schemas.recording import ACCEL, GYRO, Recording
from storage.formats.mcap.reader import read_mcap
from tasks.station import procedures
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.process import running
from tests.proof.kills.tap import Sent, Tap

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
    folder.mkdir(parents=True)
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
