"""A line on a real server with real workers: what its clock orders, and what its loss costs."""

import os
import signal
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack
from datetime import datetime, timedelta
from itertools import pairwise

import pytest
from prefect.client.orchestration import get_client
from prefect.client.schemas.actions import DeploymentScheduleCreate
from prefect.client.schemas.schedules import CronSchedule
from prefect.settings import PREFECT_API_AUTH_STRING, PREFECT_API_URL, temporary_settings
from prefect.states import Cancelling

from schemas.orders import ProductionOrder
from storage.catalogue import certificates, orders, runs
from storage.home import Home
from storage.stations import statuses
from tasks.station.virtual.config import VirtualStation, draw_unit
from tasks.station.virtual.servers import running
from tests.flows.on_prefect.test_prefect_flows import SHORT
from tests.prefect_line import PASSWORD, PrefectLine, flow_runs, prefect_line, wait_for

pytestmark = [pytest.mark.real_time, pytest.mark.rehearsal]
STATIONS = ("S-1", "S-2")
SERIALS = {"S-1": "V00007", "S-2": "V00008"}
LONG_S = 900.0  # of a machine that does other work
SPEED = 20.0
UNFINISHED = ("SCHEDULED", "PENDING", "RUNNING")
TERMINAL = ("COMPLETED", "FAILED", "CRASHED", "CANCELLED")


@pytest.fixture(scope="module")
def line(prefect_database, tmp_path_factory) -> Iterator[PrefectLine]:
    """Two stations, each with its unit, its pool and its worker."""
    with ExitStack() as open_:
        line = open_.enter_context(prefect_line(tmp_path_factory.mktemp("line"), prefect_database))
        (line.folder / "short.toml").write_text(SHORT, encoding="utf-8")
        longer = SHORT.replace("dwell_s = 6.0", "dwell_s = 90.0")
        (line.folder / "longer.toml").write_text(longer, encoding="utf-8")
        for seed, station in enumerate(STATIONS, 7):
            virtual = VirtualStation(unit=draw_unit(seed))
            found = open_.enter_context(running(virtual, speed=SPEED))
            named = found.station.model_copy(update={"id": station})
            file = line.folder / f"{station}.json"
            document = found.model_copy(update={"station": named})
            file.write_text(document.model_dump_json(), encoding="utf-8")
            line.mimucal("station", "add", file)
            line.work(f"station-{station}")
        yield line


@pytest.fixture
def client(line):
    with (
        temporary_settings({PREFECT_API_URL: line.url, PREFECT_API_AUTH_STRING: PASSWORD}),
        get_client(sync_client=True) as client,
    ):
        yield client


def order(line: PrefectLine, station: str, procedure: str = "short") -> dict[str, object]:
    return {
        "order": {
            "station": str(line.home / f"stations/{station}.json"),
            "procedure": str(line.folder / f"{procedure}.toml"),
        }
    }


def ended(deployment: str, count: int) -> list[dict]:
    runs = flow_runs(deployment, *TERMINAL)
    return runs if len(runs) >= count else []


def begin(line: PrefectLine, client, station: str) -> str:
    """A run that measures: it has written readings."""
    deployment = client.read_deployment_by_name(f"produce/{station}")
    asked = order(line, station, "longer")
    run = client.create_flow_run_from_deployment(deployment.id, parameters=asked)
    left = line.home / "acquiring"
    before = set(left.glob("*.mcap"))

    def is_written() -> bool:
        new = set(left.glob("*.mcap")) - before
        return any(path.stat().st_size > 50_000 for path in new)

    wait_for(is_written, LONG_S)
    return str(run.id)


def state_of(client, run: str) -> str:
    return str(client.read_flow_run(run).state_name)


def settled(client, run: str) -> str:
    return str(wait_for(lambda: client.read_flow_run(run).state.is_final() and run, LONG_S))


def test_ten_runs_that_nobody_ordered_end_in_a_draft_each_none_twice_and_none_missing(line, client):
    every_minute = CronSchedule(cron="* * * * *", timezone="Asia/Shanghai")
    schedules = {}
    for station in STATIONS:
        deployment = client.read_deployment_by_name(f"produce/{station}")
        schedule = DeploymentScheduleCreate(
            schedule=every_minute, active=True, parameters=order(line, station)
        )
        (made,) = client.create_deployment_schedules(deployment.id, [schedule])
        schedules[deployment.id] = made.id
    for station in STATIONS:
        wait_for(lambda s=station: ended(f"produce/{s}", 5), LONG_S)
    for deployment_id, schedule_id in schedules.items():
        client.delete_deployment_schedule(deployment_id, schedule_id)
    for station in STATIONS:
        wait_for(lambda s=station: not flow_runs(f"produce/{s}", *UNFINISHED), LONG_S)
    home = Home(line.home)
    for station in STATIONS:
        ended_ones = [
            run for run in flow_runs(f"produce/{station}", *TERMINAL) if run["auto_scheduled"]
        ]
        times = [datetime.fromisoformat(run["expected_start_time"]) for run in ended_ones]
        assert len(times) >= 5
        minutes = {later - earlier for earlier, later in pairwise(times)}
        assert minutes == {timedelta(minutes=1)}  # none twice, none missing
        done = [run for run in ended_ones if run["state_type"] == "COMPLETED"]
        late = [run for run in ended_ones if run["state_type"] == "CANCELLED"]
        assert len(done) + len(late) == len(ended_ones)
        assert all("a newer run" in run["state"]["message"] for run in late)
        stored = [run for run in runs.all_runs(home) if run.station == station]
        assert len(stored) == len(done)
    drafts = Counter(entry.run for entry in certificates.register(home))
    assert sorted(drafts) == sorted(run.id for run in runs.all_runs(home))
    assert set(drafts.values()) == {1}


def test_a_server_that_is_killed_and_comes_back_costs_neither_recording_nor_draft(line, client):
    before = {run.id for run in runs.all_runs(Home(line.home))}
    left = set((line.home / "acquiring").rglob("*.mcap"))  # of runs that others stopped
    run = begin(line, client, "S-1")
    line.kill_server()
    stored = wait_for(
        lambda: {each.run for each in certificates.register(Home(line.home))} - before, LONG_S
    )
    line.start()
    settled(client, run)
    assert state_of(client, run) == "Completed"
    assert len(stored) == 1
    assert set((line.home / "acquiring").rglob("*.mcap")) <= left


def test_a_worker_that_is_killed_stops_the_table_and_the_recording_is_kept(line, client):
    run = begin(line, client, "S-2")
    os.kill(line.workers[1].pid, signal.SIGKILL)
    ((status, is_dead),) = wait_for(lambda: stopped(line, "S-2"), LONG_S)
    assert not is_dead
    assert "stopped by the loss of its Prefect worker; recorded so far" in status.cause
    assert settled(client, run)
    assert state_of(client, run) in ("Failed", "Crashed")
    line.work("station-S-2")


def stopped(line: PrefectLine, station: str) -> list:
    found = statuses(Home(line.home))
    return [each for each in found if each[0].station == station and each[0].state == "stopped"]


def order_that_measures(line: PrefectLine, station: str, number: str) -> ProductionOrder:
    """An order of the queue whose process writes readings."""
    procedure, left = line.folder / "longer.toml", line.home / "acquiring"
    before = set(left.glob("*.mcap"))
    line.mimucal(
        "order", "add", station, "--serial", SERIALS[station], "--number", number,
        "--procedure", procedure, "--by", "Li",
    )  # fmt: skip
    wait_for(
        lambda: any(each.stat().st_size > 50_000 for each in set(left.glob("*.mcap")) - before),
        LONG_S,
    )
    return orders.find(number, Home(line.home))


def hooks_that_failed(line: PrefectLine) -> list[str]:
    logs = (log.read_text(encoding="utf-8") for log in line.folder.glob("worker-*.log"))
    return [
        text for text in logs if "failed to retrieve flow" in text or "is not a package" in text
    ]


def test_an_order_whose_own_process_is_killed_goes_on_within_a_minute(line):
    home, order = Home(line.home), order_that_measures(line, "S-1", "killed")
    os.kill(order.process, signal.SIGKILL)
    wait_for(lambda: orders.find("killed", home).attempts == 2, 60.0)
    wait_for(lambda: orders.find("killed", home).state == "done", LONG_S)
    assert len(orders.find("killed", home).runs) == 1
    assert hooks_that_failed(line) == []


def test_an_order_that_is_cancelled_in_prefect_failed_and_does_not_begin_again(line, client):
    home, order = Home(line.home), order_that_measures(line, "S-1", "cancelled")
    client.set_flow_run_state(order.flow_run, Cancelling(), force=True)
    wait_for(lambda: orders.find("cancelled", home).state == "failed", 60.0)
    wait_for(lambda: state_of(client, order.flow_run) == "Cancelled", 60.0)
    ended = orders.find("cancelled", home)
    assert (ended.state, ended.attempts) == ("failed", 1)
    assert ended.cause is not None
    assert hooks_that_failed(line) == []


def test_a_cancellation_stops_the_table_though_the_worker_no_longer_looks(line, client):
    run = begin(line, client, "S-1")
    worker = line.workers[0]
    os.kill(worker.pid, signal.SIGSTOP)  # it neither sees the cancellation nor ends
    try:
        client.set_flow_run_state(run, Cancelling(), force=True)
        ((status, _),) = wait_for(lambda: stopped(line, "S-1"), LONG_S)
        assert "stopped by a cancellation in Prefect; recorded so far" in status.cause
    finally:
        os.kill(worker.pid, signal.SIGCONT)
