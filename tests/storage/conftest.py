"""A fresh home, small recordings and results, and processes that do a thing at the same time."""

import json
import subprocess
import sys
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from schemas.calibration import Calibration, Item
from schemas.certificate import Certificate
from schemas.decision import Decision
from schemas.recording import ACCEL, FORMAT, GYRO, Manifest, Recording, Stream
from storage.catalogue.run_index import Run
from storage.home import Home

AT_ONCE = """
import json
import sys
from contextlib import redirect_stdout
from datetime import date
from io import StringIO
from multiprocessing import get_context
from pathlib import Path

from storage.catalogue import certificates, results, runs
from storage.formats import recordings
from storage.home import Home

home, script, processes = Home(Path(sys.argv[1])), sys.argv[2], int(sys.argv[3])
arguments = sys.argv[4:]
forked = get_context("fork")  # one import for all of them
everybody = forked.Barrier(processes)

def run(_):
    everybody.wait()
    with redirect_stdout(StringIO()) as printed:
        exec(script, globals())
    return printed.getvalue()

with forked.Pool(processes) as pool:
    said = pool.map(run, range(processes), chunksize=1)
print(json.dumps(said))
"""


@pytest.fixture
def fresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Home:
    """A home in which nothing was kept yet; its folder does not exist."""
    monkeypatch.delenv("MIMUCAL_DATABASE", raising=False)
    return Home(tmp_path / "home")


@pytest.fixture
def small() -> Callable[..., Recording]:
    """Builds a recording of three seconds; `start` makes its content another one."""

    def build(start: float = 0.0, name: str = "small", serial: str = "1") -> Recording:
        manifest = Manifest.model_validate(
            {
                "format": FORMAT,
                "recording_id": name,
                "unit": {"manufacturer": "Maker", "model": "U", "serial": serial},
                "station": {"id": "T1"},
            }
        )
        t = np.round(np.arange(300) / 100, 9)
        values = {n: np.sin(start + t + k) for k, n in enumerate(GYRO + ACCEL)}
        return Recording(manifest, Stream(t, values))

    return build


@pytest.fixture
def calibrated() -> Callable[..., Calibration]:
    """Builds the result of a run; `bias` makes it another one."""

    def build(run: Run, bias: float = 0.25, **changes: Any) -> Calibration:
        item = Item(
            unit="deg/s",
            clause="7.2.2",
            value={"x": bias, "y": None},
            u={"x": 0.01, "y": None},
            U={"x": 0.02, "y": None},
        )
        fields = {
            "recording_id": run.recording_id,
            "run": run.id,
            "digest": run.digest,
            "method": "jjf2003",
            "code_version": "1",
            "procedure": "jjf2003",
            "settings": {},
            "items": {"gyro_bias": item},
            "unavailable": {"gyro_bias.y": "no run about y"},
        }
        return Calibration.model_validate(fields | changes)

    return build


@pytest.fixture
def certified() -> Callable[..., Certificate]:
    """Builds a certificate of a result."""

    def build(
        recording: Recording, calibration: Calibration, number: str, **changes: Any
    ) -> Certificate:
        fields = {
            "number": number,
            "state": "issued",
            "calibrated_on": date(2026, 11, 21),
            "issued_on": date(2026, 11, 22),
            "due": date(2027, 11, 21),
            "laboratory": None,
            "order": None,
            "manifest": recording.manifest,
            "calibration": calibration,
            "decision": Decision(verdict="pass", rule="simple", document=None, limits=()),
        }
        return Certificate.model_validate(fields | changes)

    return build


@pytest.fixture
def at_once() -> Callable[..., list[str]]:
    """Runs a script in several processes that all start it at the same moment.

    The script knows store, Home, Path, date, home and arguments; gives what each printed.
    """

    def run(script: str, home: Home, *arguments: str, processes: int = 2) -> list[str]:
        command = [sys.executable, "-W", "error", "-c", AT_ONCE, str(home.path), script]
        done = subprocess.run(
            [*command, str(processes), *arguments], stdout=subprocess.PIPE, timeout=600, check=True
        )
        return list(json.loads(done.stdout))

    return run
