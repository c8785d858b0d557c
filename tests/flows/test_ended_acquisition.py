"""A signal that ends an acquisition in a process of its own leaves the table at rest."""

import os
import signal
import subprocess
import sys
import time

import pytest

from tasks.station import procedures
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.process import running
from tests.tasks.station.over_sockets import SPEED, table_and_watchdog

pytestmark = pytest.mark.real_time
ACQUIRE = """
import signal, sys
from flows import run_orders
from schemas.base import BrokenOff
from schemas.orders import (AcquireOrder)
for ignored in (signal.SIGHUP, signal.SIGQUIT):
    signal.signal(ignored, signal.SIG_DFL)
try:
    run_orders.acquire(AcquireOrder(station=sys.argv[1], procedure=sys.argv[2], attended=False))
except BrokenOff as end:
    print(end)
"""


@pytest.fixture
def turning(tmp_path):
    """A procedure that turns the table soon after its warm-up, for longer than any test."""
    whole = procedures.load("jjf2003")
    run = next(step for step in whole.steps if step.kind == "rate_run")
    longer = run.model_copy(update={"dwell_s": 3600.0})
    path = tmp_path / "turning.json"
    changes = {"steps": (longer,), "warm_up_s": 1.0}
    path.write_text(whole.model_copy(update=changes).model_dump_json())
    return path


def wait_until_it_turns(home, process):
    deadline = time.monotonic() + 300
    while not any(p.stat().st_size > 200_000 for p in (home / "acquiring").glob("*.mcap")):
        assert time.monotonic() < deadline
        assert process.poll() is None
        time.sleep(0.05)


@pytest.mark.parametrize("ending", [signal.SIGHUP, signal.SIGQUIT])
def test_the_table_comes_to_rest_and_the_recording_is_kept(ending, turning, tmp_path):
    home = tmp_path / "home"
    with running(VirtualStation(), SPEED) as station:
        file = tmp_path / "station.json"
        file.write_text(station.model_dump_json())
        with subprocess.Popen(
            [sys.executable, "-c", ACQUIRE, file, turning],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env=os.environ | {"MIMUCAL_HOME": str(home)},
        ) as process:  # fmt: skip
            try:
                wait_until_it_turns(home, process)
                process.send_signal(ending)
                printed, failure = process.communicate(timeout=600)
            finally:
                process.kill()
        state, watchdog = table_and_watchdog(station)
    assert failure == ""
    assert printed.startswith("stopped by the operator; recorded so far: ")
    assert [axis.rate_deg_s for axis in state.axes] == pytest.approx([0.0] * 3, abs=1e-6)
    assert watchdog == 0
