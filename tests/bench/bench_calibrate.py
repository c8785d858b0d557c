"""`calibrate` on 1.44 million rows beside pyarrow reading the same columns, in one run."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import numpy as np
import pyarrow.parquet as pq

from schemas.recording import ACCEL, GYRO, Manifest, Recording, Stream
from storage.catalogue import runs
from storage.home import Home
from tasks.stages.estimate import estimate

RATE_HZ = 1000.0
DWELL_S = 30.0
GRAVITY = 9.8
RUNS = 5


def recording() -> Recording:
    """A JJF 2003 run at 1 kHz: twelve positions, ten rates and two rests about each axis."""
    rng = np.random.default_rng(0)
    rows, segments = [], []
    count = round(RATE_HZ * DWELL_S)

    def hold(name: str, rate: np.ndarray, upward: np.ndarray, **label: object) -> None:
        level = np.concatenate([rate, upward * GRAVITY])
        rows.append(level + rng.normal(0.0, [1e-3] * 3 + [1e-2] * 3, (count, 6)))
        start = DWELL_S * len(segments)
        segments.append({"name": name, "t_start": start, "t_end": start + DWELL_S, **label})

    still = np.zeros(3)
    for axis, letter in enumerate("xyz"):
        up = np.eye(3)[axis]
        for sign, mark in ((1, "+"), (-1, "-")):
            for turn in (0, 180):
                hold(f"{mark}{letter}{turn}", still, sign * up, kind="static",
                     item="twelve_position", up=mark + letter, turn_deg=turn)  # fmt: skip
    for axis, letter in enumerate("xyz"):
        up = np.eye(3)[axis]
        rest = {"kind": "static", "item": "rate_sensitivity", "up": "+" + letter}
        hold(f"rest_{letter}", still, up, **rest)
        for rate in (-300, -200, -100, -50, -10, 10, 50, 100, 200, 300):
            hold(f"{letter}{rate}", up * np.radians(rate), up, kind="rate", item="scale_factor",
                 axis=letter, up="+" + letter, rate_deg_s=rate)  # fmt: skip
        hold(f"rest2_{letter}", still, up, **rest)
    values = np.concatenate(rows)
    manifest = Manifest.model_validate({
        "format": "mimu-recording/1", "recording_id": "bench", "standard": "JJF 2003-2022",
        "unit": {"manufacturer": "b", "model": "b", "serial": "1"},
        "station": {"id": "b", "latitude_deg": 40.0, "gravity_m_s2": GRAVITY},
        "segments": segments,
    })  # fmt: skip
    t = np.round(np.arange(len(values)) / RATE_HZ, 9)
    return Recording(manifest, Stream(t, dict(zip(GYRO + ACCEL, values.T.copy(), strict=True))))


def timed(work: Callable[[], object]) -> float:
    """Median wall seconds of five runs after a first one that is not counted."""
    work()
    seconds = []
    for _ in range(RUNS):
        began = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - began)
    return median(seconds)


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        home = Home(Path(folder))
        began = time.perf_counter()
        run, _ = runs.add(recording(), home)
        taken_in = time.perf_counter() - began
        columns = home.columns / run.digest / "imu.parquet"
        names = ["t", *GYRO, *ACCEL]

        def read() -> None:
            table = pq.read_table(columns, columns=names)
            [table[name].to_numpy() for name in names]

        reading = timed(read)
        calibrating = timed(lambda: estimate(run, home))
        command = [sys.executable, "-m", "flows.cli", "calibrate", run.id, "--json"]
        environment = os.environ | {"MIMUCAL_HOME": folder}
        whole = timed(lambda: subprocess.run(
            command, env=environment, check=True, capture_output=True
        ))  # fmt: skip
    print(f"calibrate, {run.rows} rows")
    print(f"  pyarrow reads the columns          {reading * 1e3:8.1f} ms")
    print(f"  calibrate (load, estimate, keep)   {calibrating * 1e3:8.1f} ms"
          f"   {calibrating / reading:6.1f} × the reading")  # fmt: skip
    print(f"  mimucal calibrate, whole process   {whole * 1e3:8.1f} ms"
          f"   {whole / reading:6.1f} × the reading")  # fmt: skip
    print(f"  taking it in (raw MCAP + columns)  {taken_in * 1e3:8.1f} ms")


if __name__ == "__main__":
    main()
