"""Signals that end an acquisition in a process of its own: what was recorded is kept."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from schemas.station import StationFile
from tasks.station import procedures
from tasks.station.virtual.config import VirtualStation, draw_unit
from tasks.station.virtual.servers import running
from tests.tasks.station.over_sockets import SPEED, table_and_watchdog

pytestmark = pytest.mark.real_time
ACQUIRE = """
import signal, sys
from flows import execute as run_orders
from schemas.base import BrokenOff
from schemas.orders import AcquireOrder
for ignored in (signal.SIGHUP, signal.SIGQUIT):
    signal.signal(ignored, signal.SIG_DFL)
try:
    run_orders.acquire(AcquireOrder(station=sys.argv[1], procedure=sys.argv[3], attended=False))
except BrokenOff as end:
    sys.exit(str(end))
"""
WITHOUT_PREFECT = ("-c", ACQUIRE)
COMMAND = ("-m", "flows.cli", "acquire")


@pytest.fixture(scope="module")
def station() -> Iterator[StationFile]:
    with running(VirtualStation(unit=draw_unit(7)), SPEED) as found:
        yield found


@pytest.fixture
def order(station: StationFile, tmp_path: Path) -> tuple[object, ...]:
    """A station file, and a procedure that soon turns the table for longer than any test."""
    whole = procedures.load("jjf2003")
    run = next(step for step in whole.steps if step.kind == "rate_run")
    longer = run.model_copy(update={"dwell_s": 3600.0})
    station_file, procedure = tmp_path / "station.json", tmp_path / "turning.json"
    changes = {"steps": (longer,), "warm_up_s": 1.0}
    procedure.write_text(whole.model_copy(update=changes).model_dump_json(), encoding="utf-8")
    station_file.write_text(station.model_dump_json(), encoding="utf-8")
    return station_file, "--procedure", procedure


def ended(home: Path, how: signal.Signals, *acquire: object) -> tuple[int, str, Path]:
    """Ends an acquisition by a signal when something is on the disk.

    The signal goes to the whole process group, as from a terminal. Gives the exit code, stderr and
    the recording.
    """
    keep = {k: v for k, v in os.environ.items() if not k.startswith(("PREFECT_", "MIMUCAL_"))}
    process = subprocess.Popen(
        [sys.executable, *map(str, acquire)],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        env=keep | {"MIMUCAL_HOME": str(home)}, start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    try:
        deadline = time.monotonic() + 500
        while not any(p.stat().st_size > 200_000 for p in (home / "acquiring").glob("*.mcap")):
            assert time.monotonic() < deadline
            assert process.poll() is None
            time.sleep(0.05)
        assert bool(servers_of(home, process.pid)) == (acquire[:2] == COMMAND[:2])
        os.killpg(process.pid, how)
        _, printed = process.communicate(timeout=300)
        while servers_of(home, process.pid):  # the kernel ends it after its parent
            assert time.monotonic() < deadline
            time.sleep(0.1)
    finally:
        process.kill()
    (found,) = (home / "acquiring").glob("*.mcap")
    return process.returncode, printed, found


def servers_of(home: Path, command: int) -> list[int]:
    """The processes with a session of their own that a command started for this home."""
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        try:
            session = os.getsid(int(place.name))
            owned = str(home).encode() in (place / "environ").read_bytes()
        except OSError:  # ended meanwhile, or of another user
            continue
        if owned and session == int(place.name) != command:
            found.append(int(place.name))
    return found


@pytest.mark.rehearsal
@pytest.mark.parametrize(
    "acquire", [WITHOUT_PREFECT, pytest.param(COMMAND, marks=pytest.mark.rehearsal)]
)
def test_what_was_recorded_survives_a_kill(
    own_home, order, acquire: tuple[str, ...], mimucal
) -> None:
    _, _, found = ended(own_home, signal.SIGKILL, *acquire, *order)
    refused = mimucal("import", found)
    assert refused.code == 2
    assert "--salvage" in refused.err
    saved = mimucal("import", found, "--salvage", "--json")
    assert saved.code == 0, saved.err
    document = mimucal("show", saved.json["runs"][0]["run"], "--json").json
    assert document["run"]["seconds"] > 10
    assert document["manifest"]["unit"]["serial"] == "V00007"


@pytest.mark.rehearsal
@pytest.mark.parametrize(
    "how", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.rehearsal)]
)
def test_stopping_is_one_sentence_that_says_where_the_recording_lies(
    own_home, order, how: signal.Signals, mimucal
) -> None:
    code, printed, found = ended(own_home, how, *COMMAND, *order)
    assert code == 1
    assert printed.strip().count("\n") == 0
    assert printed.startswith("stopped by the operator")
    assert str(found) in printed
    assert mimucal("import", "--salvage", found).code == 0


@pytest.mark.rehearsal
@pytest.mark.parametrize(
    "how", [signal.SIGHUP, pytest.param(signal.SIGQUIT, marks=pytest.mark.rehearsal)]
)
def test_the_table_comes_to_rest_and_the_recording_is_kept(
    tmp_path, station, order, how: signal.Signals
) -> None:
    _, printed, found = ended(tmp_path / "home", how, *WITHOUT_PREFECT, *order)
    assert printed.startswith("stopped by the operator; recorded so far: ")
    assert str(found) in printed
    state, watchdog = table_and_watchdog(station)
    assert [axis.rate_deg_s for axis in state.axes] == pytest.approx([0.0] * 3, abs=1e-6)
    assert watchdog == 0
