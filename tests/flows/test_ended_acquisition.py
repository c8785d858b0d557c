"""Acquisitions in a process of their own that a signal ends: what was recorded is kept."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from schemas.recording import MEASURED
from schemas.station import StationFile
from storage.catalogue import runs
from storage.formats.mcap.reader import read_mcap
from storage.home import Home
from tasks.stages.acquire import acquire_run
from tasks.stages.store import ready_to_acquire
from tasks.station import procedures
from tasks.station.virtual.config import VirtualStation, draw_unit
from tests.tasks.station.over_sockets import SPEED, ignore, serving, table_and_watchdog

pytestmark = pytest.mark.real_time
ACQUIRE = """
import signal, sys
from flows import execute
from schemas.base import BrokenOff
from schemas.orders import AcquireOrder
for ignored in (signal.SIGHUP, signal.SIGQUIT):
    signal.signal(ignored, signal.SIG_DFL)
try:
    execute.acquire(AcquireOrder(station=sys.argv[1], procedure=sys.argv[3], attended=False))
except BrokenOff as end:
    sys.exit(str(end))
"""
WITHOUT_PREFECT = ("-c", ACQUIRE)
COMMAND = ("-m", "flows.cli", "acquire")


@pytest.fixture(scope="module")
def station() -> Iterator[StationFile]:
    with serving(VirtualStation(unit=draw_unit(7)), SPEED) as found:
        yield found


def ended(
    home: Home, how: signal.Signals, station: StationFile, kind: str, acquire: tuple[str, ...]
) -> tuple[int, str, Path]:
    """Ends an acquisition of steps of a kind by a signal, when something is on the disk.

    The signal goes to the whole process group, as from a terminal. Gives the exit code, stderr and
    the recording.
    """
    ready_to_acquire(station.station.id, home)
    files = home.path / "station.json", home.path / "procedure.json"
    for file, content in zip(files, (station, procedure(kind)), strict=True):
        file.write_text(content.model_dump_json(), encoding="utf-8")
    with subprocess.Popen(
        [sys.executable, *acquire, files[0], "--procedure", files[1]],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as process:  # fmt: skip
        try:
            deadline = time.monotonic() + 500
            while not any(p.stat().st_size > 150_000 for p in home.acquiring.glob("*.mcap")):
                assert time.monotonic() < deadline
                assert process.poll() is None
                time.sleep(0.02)
            time.sleep(0.2)  # between two flushes
            os.killpg(process.pid, how)
            _, printed = process.communicate(timeout=300)
        finally:
            process.kill()
    (found,) = home.acquiring.glob("*.mcap")
    return process.returncode, printed, found


def procedure(kind: str):
    """Two steps of this kind; 30 s each of rest, or a rate that lasts longer than any test."""
    whole = procedures.load("jjf2003")
    steps = [step for step in whole.steps if step.kind == kind][:2]
    dwell_s = {"position": 30.0, "rate_run": 3600.0}[kind]
    changed = tuple(step.model_copy(update={"dwell_s": dwell_s}) for step in steps)
    return whole.model_copy(update={"steps": changed, "warm_up_s": 1.0})


def test_what_was_recorded_survives_a_kill_and_the_run_goes_on(home, station, mimucal):
    own = Home(home)
    _, _, left = ended(own, signal.SIGKILL, station, "position", WITHOUT_PREFECT)
    refused = mimucal("import", left)
    assert refused.code == 2
    assert "--salvage" in refused.err
    first = read_mcap(left, salvage=True).imu
    assert first.t[-1] > 5.0
    table_and_watchdog(station)  # its watchdog brings the table to rest
    made = acquire_run(station, procedure("position"), own, ignore, resume=True)
    ((run, _),) = made.kept
    whole = runs.load(run, own)
    names = [step.name for step in procedure("position").steps]
    assert [each.name for each in whole.manifest.segments if each.kind in MEASURED] == names
    assert (whole.imu.t[: len(first)] == first.t).all()
    assert (np.diff(whole.imu.t) > 0).all()
    assert len(whole.manifest.model_extra["parts"]) == 2
    assert not left.exists()


def in_rehearsal(acquire: tuple[str, ...], how: signal.Signals) -> object:
    return pytest.param(acquire, how, marks=pytest.mark.rehearsal)


@pytest.mark.parametrize(
    ("acquire", "how"),
    [
        (WITHOUT_PREFECT, signal.SIGHUP),
        in_rehearsal(WITHOUT_PREFECT, signal.SIGQUIT),
        in_rehearsal(COMMAND, signal.SIGINT),
        in_rehearsal(COMMAND, signal.SIGTERM),
    ],
)
def test_a_signal_ends_a_run_in_one_sentence_with_the_table_at_rest(
    home, station, mimucal, acquire, how
):
    code, printed, left = ended(Home(home), how, station, "rate_run", acquire)
    assert code == 1
    assert printed.strip().count("\n") == 0
    assert printed.startswith("stopped by the operator")
    assert str(left) in printed
    state, watchdog = table_and_watchdog(station)
    assert [axis.rate_deg_s for axis in state.axes] == pytest.approx([0.0] * 3, abs=1e-6)
    assert watchdog == 0
    assert mimucal("import", "--salvage", left).code == 0
