"""A store of many recordings: variations of a few, each another content."""

import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from schemas.recording import Recording
from storage.catalogue import run_index, runs
from storage.home import Home
from tests.bench.recordings import recording

ROWS = 150_000
BASES = 4  # recordings with noise of their own
STEP = 1e-6  # rad/s: by what a sample of each variation differs from that of the one before


def fill(home: Home, count: int, progress: Callable[[int, int], None]) -> None:
    """Takes recordings in until there are so many; raw ones are removed, which nothing here reads.

    A thousand raw recordings would take 11 GB beside the 8 GB of their columns.
    """
    there = len(run_index.all_runs(home))
    for number, each in enumerate(variations(count), start=1):
        if number > there:
            run, _ = runs.add(each, home)
            if not os.environ.get("MIMUCAL_STORE"):
                (home.raw / f"{run.digest}.mcap").unlink()
        progress(number, count)


def variations(count: int) -> Iterator[Recording]:
    """So many recordings, always the same ones."""
    bases = [recording(ROWS, seed) for seed in range(min(BASES, count))]
    for number in range(count):
        base = bases[number % BASES]
        first = base.imu.columns["gyro_x"].copy()
        first[0] += STEP * number
        imu = replace(base.imu, columns={**base.imu.columns, "gyro_x": first})
        yield replace(base, imu=imu)


def home_at(folder: Path) -> Home:
    """The home of a proof: MIMUCAL_HOME of what it starts, too."""
    os.environ["MIMUCAL_HOME"] = str(folder)
    return Home(folder)
