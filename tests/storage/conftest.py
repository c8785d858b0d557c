"""A fresh home, small recordings and results, and processes that do a thing at the same time."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from datetime import date
from typing import Any

import numpy as np
import pytest

from schemas.calibration import Calibration, Item
from schemas.certificate import Certificate
from schemas.decision import Decision
from schemas.recording import ACCEL, GYRO, Recording, Stream
from storage.catalogue import database
from storage.catalogue.run_index import Run
from storage.home import Home
from tests import postgres
from tests.manifests import manifest_of

AT_ONCE = """
import json
import os
import sys
from contextlib import redirect_stdout
from datetime import date
from io import StringIO
from multiprocessing import get_context
from pathlib import Path

from storage.catalogue import certificates, results, runs
from storage.formats import recordings
from storage.home import Home

forked = get_context("fork")  # one import for all of them

def run(_):
    everybody.wait()
    with redirect_stdout(StringIO()) as printed:
        exec(script, globals())
    return printed.getvalue()

for line in sys.stdin:
    folder, script, processes, arguments, database = json.loads(line)
    home, everybody = Home(Path(folder)), forked.Barrier(processes)
    os.environ.pop("MIMUCAL_DATABASE", None)
    os.environ.update(database)
    with forked.Pool(processes) as pool:
        answers = pool.map(run, range(processes), chunksize=1)
    print(json.dumps(answers), flush=True)
"""


@pytest.fixture(scope="session")
def server() -> Iterator[str]:
    """The connection of a PostgreSQL."""
    with postgres.running() as connection:
        yield connection


@pytest.fixture(params=["sqlite", "postgresql"])
def either(request: pytest.FixtureRequest, fresh: Home, monkeypatch: pytest.MonkeyPatch) -> Home:
    """A fresh home whose catalogue is a file of its own, or an empty database on a server."""
    if request.param == "postgresql":
        server = request.getfixturevalue("server")
        monkeypatch.setenv("MIMUCAL_DATABASE", postgres.empty_database(server))
    return fresh


@pytest.fixture
def small() -> Callable[..., Recording]:
    """Builds a recording of three seconds; `start` makes its content another one."""

    def build(start: float = 0.0, name: str = "small", serial: str = "1") -> Recording:
        manifest = manifest_of(
            name, {"id": "T1"}, unit={"manufacturer": "Maker", "model": "U", "serial": serial}
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


@pytest.fixture(scope="session")
def forking() -> Iterator[subprocess.Popen[str]]:
    """A process that carries out AT_ONCE, with all of its imports."""
    with subprocess.Popen(
        [sys.executable, "-W", "error", "-c", AT_ONCE],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        yield process


@pytest.fixture
def at_once(forking: subprocess.Popen[str]) -> Callable[..., list[str]]:
    """Runs a script in several processes that all start it at the same moment.

    The script knows store, Home, Path, date, home and arguments; gives what each printed. The
    catalogue is there already, unless the processes are to make it.
    """

    def run(
        script: str, home: Home, *arguments: str, processes: int = 2, has_catalogue: bool = True
    ) -> list[str]:
        if has_catalogue:
            with database.changing(home):
                pass
        named = {k: v for k, v in os.environ.items() if k == "MIMUCAL_DATABASE"}
        assert forking.stdin is not None
        assert forking.stdout is not None
        order = [str(home.path), script, processes, arguments, named]
        print(json.dumps(order), file=forking.stdin, flush=True)
        printed = forking.stdout.readline()
        assert printed, "a process failed: see its messages"
        return list(json.loads(printed))

    return run
