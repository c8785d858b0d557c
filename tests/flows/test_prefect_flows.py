"""The line as Prefect flows on a virtual station, with the embedded server; and a kill."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from schemas.station import StationFile
from storage.home import Home
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.process import running
from tasks.station.virtual.unit import draw_unit
from tests.drafts import draft

pytestmark = pytest.mark.real_time

SHORT = """
format = "mimu-procedure/1"
name = "short"
title = "two positions and two rates"
title_zh = "两位置两速率"
standard = "JJF 2003-2022"
warm_up_s = 1.0
settle_s = 0.5
move_rate_deg_s = 90.0
acceleration_deg_s2 = 120.0
[environment]
temperature_degc = [15.0, 25.0]
humidity_percent = [20.0, 85.0]
[[steps]]
kind = "position"
name = "position_+z_000"
item = "twelve_position"
up = "+z"
turn_deg = 0
angles_deg = [0, 0, 0]
dwell_s = {dwell}
[[steps]]
kind = "position"
name = "position_-z_000"
item = "twelve_position"
up = "-z"
turn_deg = 0
angles_deg = [0, 180, 0]
dwell_s = {dwell}
[[steps]]
kind = "rate_run"
name = "rate_z"
item = "scale_factor"
axis = "z"
up = "+z"
spin_axis = 0
angles_deg = [0, 0, 0]
rates_deg_s = [-90, 90]
dwell_s = {dwell}
"""


@pytest.fixture(scope="module")
def station() -> Iterator[StationFile]:
    with running(VirtualStation(unit=draw_unit(7)), speed=30.0) as found:
        yield found


@pytest.fixture
def papers(tmp_path: Path, station: StationFile) -> tuple[Path, Path]:
    """A station file and a short procedure."""
    station_file, procedure = tmp_path / "station.json", tmp_path / "short.toml"
    station_file.write_text(station.model_dump_json(), encoding="utf-8")
    procedure.write_text(SHORT.format(dwell=6.0), encoding="utf-8")
    return station_file, procedure


def command(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "flows.cli", *map(str, arguments)]


def environment(home: Path, **more: str) -> dict[str, str]:
    keep = {k: v for k, v in os.environ.items() if not k.startswith(("PREFECT_", "MIMUCAL_"))}
    return keep | {"MIMUCAL_HOME": str(home)} | more


ARTIFACTS = """
import asyncio, json
from prefect.client.orchestration import get_client
async def main():
    async with get_client() as client:
        runs = await client.read_flow_runs()
        artifacts = await client.read_artifacts()
        tasks = await client.read_task_runs()
        print(json.dumps({
            "flows": sorted((r.name, r.state_name) for r in runs),
            "tasks": sorted({t.name.rsplit("-", 1)[0] for t in tasks}),
            "artifacts": sorted(a.key for a in artifacts),
        }))
asyncio.run(main())
"""


def test_produce_and_apply_are_flows_whose_stages_and_artifacts_the_server_shows(
    own_home, papers, tmp_path
) -> None:
    home, (station_file, procedure) = own_home, papers
    order = (
        "from flows.carry_out import as_flow_run\n"
        "from schemas.certificate_orders import ProduceOrder\n"
        "from schemas.orders import ApplyOrder\n"
        f"order = ProduceOrder(station={str(station_file)!r}, procedure={str(procedure)!r})\n"
        "(issued,) = as_flow_run('produce', order)\n"
        "print('VERDICT', issued.certificate.decision.verdict)\n"
        "run = issued.certificate.calibration.run\n"
        f"apply = ApplyOrder(calibration=run, run=run, out={str(tmp_path / 'corrected')!r})\n"
        "print('ROWS', as_flow_run('apply', apply).rows)\n" + ARTIFACTS
    )
    done = subprocess.run(
        [sys.executable, "-c", order],
        capture_output=True, text=True, timeout=600, env=environment(home),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "VERDICT inconclusive" in done.stdout
    observed = json.loads(done.stdout.splitlines()[-1])
    assert [state for _, state in observed["flows"]] == ["Completed"] * 4
    assert observed["tasks"] == ["acquire", "apply", "certify", "decide and publish", "estimate"]
    assert (tmp_path / "corrected/manifest.json").exists()
    assert observed["artifacts"] == ["calibration-items", "certificate"]
    assert list((home / "certificates").glob("*.pdf"))


def test_acquire_prints_the_run_and_the_run_can_be_calibrated(
    home, papers, mimucal, prefect_server
) -> None:
    station_file, procedure = papers
    done = subprocess.run(
        command("acquire", station_file, "--procedure", procedure, "--json"),
        capture_output=True, text=True, timeout=600,
        env=environment(home, PREFECT_API_URL=prefect_server),
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    acquired = json.loads(done.stdout)
    assert acquired["lost_samples"] == 0
    scale = mimucal("calibrate", acquired["run"], "--json").json["items"]["gyro_scale_factor"]
    assert scale["value"]["z"] == pytest.approx(draw_unit(7).gyro.scale[2][2], abs=2e-4)
    assert scale["value"]["x"] is None


def broken_off(home: Path, papers: tuple[Path, Path], how: signal.Signals) -> tuple[int, str]:
    """Ends an acquisition by a signal when something is on the disk; exit code and stderr.

    The signal goes to the whole process group, as from a terminal.
    """
    station_file, procedure = papers
    procedure.write_text(SHORT.format(dwell=60.0), encoding="utf-8")
    started = subprocess.Popen(
        command("acquire", station_file, "--procedure", procedure),
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=environment(home),
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    try:
        deadline = time.monotonic() + 500
        while not any(p.stat().st_size > 200_000 for p in (home / "acquiring").glob("*.mcap")):
            assert time.monotonic() < deadline
            assert started.poll() is None
            time.sleep(0.1)
        assert servers_of(home)
        os.killpg(started.pid, how)
        _, printed = started.communicate(timeout=300)
        while servers_of(home):  # the kernel ends it after its parent
            assert time.monotonic() < deadline
            time.sleep(0.1)
    finally:
        started.kill()
    return started.returncode, printed


def servers_of(home: Path) -> list[int]:
    """The processes of Prefect servers that a command started for this home."""
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        try:
            name = (place / "comm").read_bytes()
            owned = str(home).encode() in (place / "environ").read_bytes()
        except OSError:  # ended meanwhile, or of another user
            continue
        if owned and name == b"prefect-server\n":
            found.append(int(place.name))
    return found


def test_what_was_recorded_survives_a_kill(own_home, papers, mimucal) -> None:
    broken_off(own_home, papers, signal.SIGKILL)
    (found,) = (own_home / "acquiring").glob("*.mcap")
    refused = mimucal("import", found)
    assert refused.code == 2
    assert "--salvage" in refused.err
    saved = mimucal("import", found, "--salvage", "--json")
    assert saved.code == 0, saved.err
    document = mimucal("show", saved.json["runs"][0]["run"], "--json").json
    assert document["run"]["seconds"] > 10
    assert document["manifest"]["unit"]["serial"] == "V00007"


@pytest.mark.parametrize(
    "how", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.rehearsal)]
)
def test_stopping_is_one_sentence_that_says_where_the_recording_lies(
    own_home, papers, how: signal.Signals, mimucal
) -> None:
    code, printed = broken_off(own_home, papers, how)
    (found,) = (own_home / "acquiring").glob("*.mcap")
    assert code == 1
    assert printed.strip().count("\n") == 0
    assert printed.startswith("stopped by the operator")
    assert str(found) in printed
    assert mimucal("import", "--salvage", found).code == 0


RETRIED = """
import sqlite3, sys
from pathlib import Path
from flows.carry_out import as_flow_run
from schemas.orders import CalibrateOrder
from storage.catalogue import database
from storage.catalogue.connection import Busy
from storage.home import home
database.BUSY_S = 0.2
with database.changing(home()):
    pass
lock = sqlite3.connect(home().path / "catalog.sqlite", check_same_thread=False)
lock.execute("BEGIN IMMEDIATE")
busy = []
def released(self, *sentence):
    lock.rollback()
    busy.append(sentence)
    Exception.__init__(self, *sentence)
Busy.__init__ = released
calibration = as_flow_run("calibrate", CalibrateOrder(run=sys.argv[1]))
print("BUSY", len(busy), calibration.run)
"""


def test_stage_is_tried_again_when_another_process_held_the_catalogue(
    home, shared, prefect_server
) -> None:
    done = subprocess.run(
        [sys.executable, "-c", RETRIED, str(shared / "real/ferraris_session")],
        capture_output=True, text=True, timeout=600,
        env=environment(home, PREFECT_API_URL=prefect_server),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "BUSY 1 r" in done.stdout


def test_the_steps_of_a_certificate_are_flow_runs_where_a_server_is_named(
    own_home, prefect_server
) -> None:
    key = draft(Home(own_home)).certificate.number
    steps = (
        "from flows.carry_out import carry_out\n"
        "from schemas.certificate_orders import CheckOrder, IssueOrder\n"
        f"key = {key!r}\n"
        "print(carry_out('check', CheckOrder(certificate=key, by='Li'), key).state)\n"
        "print(carry_out('issue', IssueOrder(certificate=key, by='Zhao'), key).state)\n" + ARTIFACTS
    )
    done = subprocess.run(
        [sys.executable, "-c", steps],
        capture_output=True, text=True, timeout=600,
        env=environment(own_home, PREFECT_API_URL=prefect_server),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[:2] == ["checked", "issued"]
    observed = json.loads(done.stdout.splitlines()[-1])
    assert {"check certificate", "issue certificate"} <= set(observed["tasks"])
