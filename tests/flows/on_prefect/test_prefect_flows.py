"""Orders as Prefect flows: on a server that a process starts for itself, and on one that is named.

One process acquires from a virtual station and carries out what follows; commands in processes of
their own are then given its server.
"""

import json
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import httpx
import pytest

from storage.home import Home
from tasks.station.virtual.config import VirtualStation, draw_unit
from tasks.station.virtual.servers import running
from tests.drafts import draft
from tests.earlier_results import newest, plant, two_calibrated

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
dwell_s = 6.0
[[steps]]
kind = "position"
name = "position_-z_000"
item = "twelve_position"
up = "-z"
turn_deg = 0
angles_deg = [0, 180, 0]
dwell_s = 6.0
[[steps]]
kind = "rate_run"
name = "rate_z"
item = "scale_factor"
axis = "z"
up = "+z"
spin_axis = 0
angles_deg = [0, 0, 0]
rates_deg_s = [-90, 90]
dwell_s = 6.0
"""

ORDERS = """
import asyncio, json, os, sqlite3, sys
from collections import Counter
from flows import execute as run_orders
from flows.carry_out import as_flow_run, carry_out
from flows.orders.production import produce
from schemas.orders import CheckOrder, IssueOrder, ProduceOrder
from schemas.orders import ApplyOrder, CalibrateOrder
from storage.catalogue import database
from storage.catalogue.database import Busy
from storage.home import home

station, procedure, out, key = sys.argv[1:]
(drafted,) = as_flow_run(produce, ProduceOrder(station=station, procedure=procedure))
run = drafted.certificate.calibration.run
as_flow_run(run_orders.apply, ApplyOrder(calibration=run, run=run, out=out))
states = [
    carry_out(run_orders.check, CheckOrder(certificate=key, by="Li"), key).state,
    carry_out(run_orders.issue, IssueOrder(certificate=key, by="Zhao"), key).state,
]

database.BUSY_S = 0.2
lock = sqlite3.connect(home().path / "catalog.sqlite", check_same_thread=False)
lock.execute("BEGIN IMMEDIATE")
busy = []
def released(self, *sentence):
    lock.rollback()
    busy.append(sentence)
    Exception.__init__(self, *sentence)
Busy.__init__ = released
again = as_flow_run(run_orders.calibrate, CalibrateOrder(run=run))

async def observed():
    from prefect.client.orchestration import get_client
    async with get_client() as client:
        runs, tasks = await client.read_flow_runs(), await client.read_task_runs()
        return {
            "flows": Counter(run.state_name for run in runs),
            "names": [run.name for run in runs],
            "tasks": sorted({task.name.rsplit("-", 1)[0] for task in tasks}),
            "artifacts": Counter(each.key for each in await client.read_artifacts()),
        }

print(json.dumps(asyncio.run(observed()) | {
    "verdict": drafted.certificate.decision.verdict, "states": states, "busy": len(busy),
    "calibrated again": again.run == run,
    "server": {name: os.environ[name] for name in ("PREFECT_API_URL", "PREFECT_API_AUTH_STRING")},
}), flush=True)
sys.stdin.read()
"""


def environment(home: Path, server: dict[str, str]) -> dict[str, str]:
    keep = {k: v for k, v in os.environ.items() if not k.startswith(("PREFECT_", "MIMUCAL_"))}
    return keep | {"MIMUCAL_HOME": str(home)} | server


def command(home: Path, server: dict[str, str], *arguments: object) -> tuple[dict[str, Any], str]:
    """Runs it in a process of its own with that server named; its document, and its errors."""
    done = subprocess.run(
        [sys.executable, "-m", "flows.cli", *map(str, arguments), "--json"],
        capture_output=True, text=True, timeout=600, env=environment(home, server),
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert not (home / "prefect").exists()  # it started no server of its own
    return json.loads(done.stdout), done.stderr


@contextmanager
def carried_out(home: Path, *arguments: object) -> Iterator[dict[str, Any]]:
    """What a process that carries out ORDERS reports; its server ends with the block."""
    with subprocess.Popen(
        [sys.executable, "-c", ORDERS, *map(str, arguments)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment(home, {}),
    ) as process:  # fmt: skip
        assert process.stdin is not None
        assert process.stdout is not None
        report = process.stdout.readline()
        assert report, "the process failed: see its messages"
        yield json.loads(report)
        process.stdin.close()
        assert process.wait(600) == 0


@pytest.fixture(scope="module")
def line(
    prefect_database: Path, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[SimpleNamespace]:
    """A process that carried out ORDERS on a station, and a command with its server named."""
    folder = tmp_path_factory.mktemp("line")
    station_file, procedure = folder / "station.json", folder / "short.toml"
    procedure.write_text(SHORT, encoding="utf-8")
    home = folder / "home"
    (home / "prefect").mkdir(parents=True)
    shutil.copy(prefect_database, home / "prefect")
    key = draft(Home(home)).certificate.number
    with ExitStack() as open_processes:
        with running(VirtualStation(unit=draw_unit(7)), speed=30.0) as station:
            station_file.write_text(station.model_dump_json(), encoding="utf-8")
            arguments = (station_file, procedure, folder / "corrected", key)
            report = open_processes.enter_context(carried_out(home, *arguments))
        yield SimpleNamespace(folder=folder, report=report, procedure=procedure)


def test_produce_and_apply_are_flows_whose_stages_and_artifacts_the_server_shows(line) -> None:
    report = line.report
    assert report["verdict"] == "inconclusive"
    assert report["flows"] == {"Completed": 5}
    stages = {"acquire", "store", "estimate", "decide and publish", "apply"}
    assert stages <= set(report["tasks"])
    made = {"calibration-v00007": 2, "certificate-v00007": 1}
    assert {key: report["artifacts"][key] for key in made} == made
    assert {"V00007 short", "calibrate V00007 short"} <= set(report["names"])
    assert (line.folder / "corrected/manifest.json").exists()
    assert list((line.folder / "home/certificates").glob("*.pdf"))


def test_nobody_orders_from_the_server_of_a_command_without_its_password(line) -> None:
    server = line.report["server"]
    asked = f"{server['PREFECT_API_URL']}/admin/version"
    name, password = server["PREFECT_API_AUTH_STRING"].split(":")
    assert httpx.get(asked, trust_env=False).status_code == 401
    assert httpx.get(asked, auth=(name, password), trust_env=False).status_code == 200


def test_the_steps_of_a_certificate_are_flow_runs_where_a_server_is_named(line) -> None:
    assert line.report["states"] == ["checked", "issued"]
    assert {"check certificate", "issue certificate"} <= set(line.report["tasks"])


def test_stage_is_tried_again_when_another_process_held_the_catalogue(line) -> None:
    assert (line.report["busy"], line.report["calibrated again"]) == (1, True)


@pytest.mark.rehearsal
def test_a_server_that_is_not_there_costs_the_record_and_nothing_else(home, ideal_run) -> None:
    store = two_calibrated(home, ideal_run)
    first, _ = newest(store)
    plant(first, store, "gyro_scale_factor", "x", 3.0)
    with socket.socket() as nobody:
        nobody.bind(("127.0.0.1", 0))  # nobody else listens there, and this does not
        url = f"http://127.0.0.1:{nobody.getsockname()[1]}/api"
        report, errors = command(home, {"PREFECT_API_URL": url}, "reprocess", "--workers", "1")
    assert [each["run"] for each in report["changed"]] == [first.run]
    assert "Warning" not in errors
