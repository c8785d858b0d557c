"""Many recordings made again by the processes of this machine, beside one core's bare estimation.

A cluster, undisturbed and with a worker killed, makes the same results: `tests/flows` holds it.
"""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

from flows.terminal import counting
from schemas.orders import Estimation
from schemas.recording import Recording
from storage.catalogue import runs
from storage.catalogue.results import newest, of_run
from storage.home import Home
from tasks.stages.estimate import calibration_of
from tests.bench.recordings import recording
from tests.proof.study import Count, Out, Write, environment, folder_of, hold

ROWS = 150_000
BASES = 4  # recordings with noise of their own
STEP = 1e-6  # rad/s: by what a sample of each variation differs from that of the one before
BARE = 20  # runs that the bare estimation is measured on
WORKERS = 2
COMMAND = [sys.executable, "-c", "from flows.cli import main; main()", "reprocess", "--json"]
TEXT = """# History at scale

`make prove ARGS="history {count}"`, {cores} cores, load {load:.1f}: {count} recordings of {rows:,}
rows (variations of four) made again by {workers} processes in {seconds:.0f} s: {efficiency:.0%} of
so many times one core's bare estimation ({bare:.0f} ms of each). Failed: {failed}. Of {tried}
results made once more in one process {same} are the same, bit for bit.
"""


@dataclass(frozen=True)
class Made:
    """What one re-processing took (s), and what of it is the same when it is made once more."""

    done: int
    failed: int
    seconds: float
    bare_s: float
    tried: int
    same: int
    load: float


def history(count: Count = 1000, out: Out = None, write: Write = False) -> None:
    """Recordings made again: 8.4 MB each, in the folder, where they are gone on with."""
    home = Home(folder_of("history", out) / "home")
    hold("history", {f"{count}": count}, partial(_made, home), lambda found: page(found[0]), out,
         write=write, at_once=0, faults=_faults)  # fmt: skip


def page(made: Made) -> str:
    efficiency = made.done * made.bare_s / (WORKERS * made.seconds)
    return TEXT.format(
        count=made.done, cores=os.cpu_count(), load=made.load, rows=ROWS, workers=WORKERS,
        seconds=made.seconds, efficiency=efficiency, bare=1e3 * made.bare_s, failed=made.failed,
        tried=made.tried, same=made.same,
    )  # fmt: skip


def _faults(made: Made) -> Iterator[str]:
    if made.failed:
        yield f"{made.failed} failed"
    if made.same != made.tried:
        yield f"{made.tried - made.same} results differ"


def _made(home: Home, count: int) -> Made:
    there = len(runs.all_runs(home))
    with counting("recordings") as report:
        for number, each in enumerate(_variations(count), start=1):
            if number > there:
                runs.add(each, home)
            report(number, count)
    done = subprocess.run(
        [*COMMAND, "--workers", str(WORKERS)], env=environment(MIMUCAL_HOME=str(home.path)),
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    report_ = json.loads(done.stdout)
    some, began = runs.all_runs(home)[:BARE], time.perf_counter()
    again = [calibration_of(run, home, Estimation(), None) for run in some]
    bare_s = (time.perf_counter() - began) / len(some)
    kept = [one.calibration for run in some if (one := newest(of_run(run, home)))]
    same = sum(a == b for a, b in zip(again, kept, strict=True))
    return Made(report_["done"], report_["failed"], report_["seconds"], bare_s, len(some), same,
                os.getloadavg()[0])  # fmt: skip


def _variations(count: int) -> Iterator[Recording]:
    """So many recordings, always the same ones."""
    bases = [recording(ROWS, seed) for seed in range(min(BASES, count))]
    for number in range(count):
        base = bases[number % BASES]
        first = base.imu.columns["gyro_x"].copy()
        first[0] += STEP * number
        yield replace(base, imu=replace(base.imu, columns={**base.imu.columns, "gyro_x": first}))
