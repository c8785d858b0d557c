"""`calibrate` and `certify` on runs in store, beside the limit of the machine and a pandas script.

The limit: pyarrow reads the same columns, and numpy takes means and 6 × 6 covariances of every
segment in one pass.
"""

import sys
import tempfile
import tracemalloc
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq

from schemas.recording import ACCEL, GYRO, Segment
from storage.catalogue import runs
from storage.formats.folder import memory_bytes
from storage.home import Home
from tasks.calibrate.calibrate import calibrate
from tasks.specifications.jjf2003 import JJF2003
from tasks.stages.estimate import estimate
from tasks.validation.record import is_of_this_text, shipped
from tests.bench.measure import Figure, Section, processor_s, processor_s_of
from tests.bench.recordings import RATE_HZ, recording

READINGS = [*GYRO, *ACCEL]
SAMPLES = (100_000, 1_000_000, 10_000_000, 100_000_000)
BYTES = 100  # of memory that a row takes: its seven columns, and while they are made
ASKED = 2.0  # times the limit
SHORT = 25  # runs of what takes a tenth of a second: the system's share varies, most at first


def in_store(rows: int) -> Section:
    """One run in store, calibrated in process and by commands."""
    with tempfile.TemporaryDirectory() as folder:
        home = Home(Path(folder))
        run, _ = runs.add(recording(rows), home)
        columns = home.columns / run.digest / "imu.parquet"
        segments = runs.load(run, home).manifest.segments or ()
        figures = (
            Figure("the limit: pyarrow, means and covariances", processor_s(
                partial(_limit, columns, segments), SHORT
            )),
            Figure("pandas groupby: means and deviations", processor_s(
                partial(_by_pandas, columns, segments), SHORT
            )),
            Figure("`estimate`: read, check, calibrate, keep", processor_s(
                partial(estimate, run, home), SHORT
            ), ASKED),
        )  # fmt: skip
    return Section(f"A run of {run.rows:,} rows in store", figures)


def commands(rows: int = 150_000) -> Section:
    """Whole processes of commands, on an ordinary run, and what importing Prefect would add."""
    with tempfile.TemporaryDirectory() as folder:
        home = Home(Path(folder))
        run, _ = runs.add(recording(rows), home)
        ordered = (
            ("runs", ()), ("remind", ()), ("calibrate", (run.id,)), ("show", (run.id,)),
            ("table", ("results", "--as", "csv")), ("verify", ()), ("certify", (run.id,)),
        )  # fmt: skip
        figures = [
            Figure(f"mimucal {' '.join((name, *words)).replace(run.id, 'RUN')}",
                   _command(home, "-m", "flows.cli", name, *words))
            for name, words in ordered
        ]  # fmt: skip
        figures.append(Figure("python -c 'import prefect'", _command(home, "-c", "import prefect")))
    note = (
        "Asked are 0.5 s of commands that need no flow, and 1.5 s of `certify`. `calibrate` and "
        "`certify` run without Prefect where no server is named; `verify` reads all that is kept. "
        f"`certify` found the validation record {_record_is()}."
    )
    return Section(f"Commands, a store with a run of {rows:,} rows", tuple(figures), note)


def by_samples(samples: Sequence[int] = SAMPLES) -> Section:
    """The calibration of longer and longer recordings in memory, for each million samples."""
    samples = [rows for rows in samples if rows * BYTES < memory_bytes()]
    figures, taken = [], []
    for rows in samples:
        made = recording(rows)
        work = partial(calibrate, JJF2003, made, run="bench", code_version="bench")
        # A short one more often: what is looked at is the difference of two lengths.
        seconds = processor_s(work, SHORT if rows < 10_000_000 else 3)
        taken.append(_taken_by(work))
        figures.append(Figure(f"{rows:.0e} samples, for each million", seconds * 1e6 / rows))
        del made, work  # before the next one is made
    whole = [figure.seconds * rows for figure, rows in zip(figures, samples, strict=True)]
    growth = np.diff(whole) / np.diff(samples)
    listed = ", ".join(f"{1e3 * each:.0f} ms" for each in growth)
    memory = ", ".join(f"{each / 2**20:.0f} MiB" for each in taken)
    note = (
        f"From one length to the next, every further million costs {listed}; the rest is budgets, "
        f"once for each recording. Beside the readings it takes {memory} of memory."
    )
    return Section("Scaling with samples (in memory)", tuple(figures), note)


def _limit(columns: Path, segments: Sequence[Segment]) -> None:
    table = pq.read_table(columns, columns=["t", *READINGS])
    readings = np.array([table[name].to_numpy() for name in READINGS])
    for segment in segments:
        rows = slice(round(segment.t_start * RATE_HZ), round(segment.t_end * RATE_HZ))
        readings[:, rows].mean(axis=1)
        np.cov(readings[:, rows])


def _by_pandas(columns: Path, segments: Sequence[Segment]) -> None:
    frame = pd.read_parquet(columns, columns=["t", *READINGS])
    edges = [segment.t_end for segment in segments]
    number = np.searchsorted(edges, frame["t"], side="right")
    frame.groupby(number)[READINGS].agg(["mean", "std"])


def _command(home: Home, *words: str) -> float:
    return processor_s_of([sys.executable, *words], {"MIMUCAL_HOME": str(home.path)}, runs=3)


def _record_is() -> str:
    """Whether certify has to parse the sources to find whether the record is of this code."""
    record = shipped()
    if record is None:
        return "missing"
    if all(is_of_this_text(record, method) for method in record.methods):
        return "of this very text of the methods"
    return "of another text of the program, and parsed its sources to compare what they compute"


def _taken_by(work: Callable[[], object]) -> int:
    """The most bytes of memory that something takes at once beside what is already there."""
    tracemalloc.start()
    work()
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return most
