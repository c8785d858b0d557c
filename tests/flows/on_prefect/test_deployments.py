"""What `mimucal deploy` and `mimucal station add` make on a real server, behind its password."""

import os
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from zoneinfo import ZoneInfo

import httpx
import pytest
from prefect.settings import PREFECT_API_AUTH_STRING, PREFECT_API_URL, temporary_settings

from flows.on_prefect import flows
from flows.on_prefect.deployments import (
    OF_THE_LINE,
    deploy_line,
    deploy_station,
    environment,
    remove_station,
)
from storage.home import Home
from tasks.stages.doctor import examine_prefect
from tasks.stages.prefect_api import get, post
from tasks.station.virtual.config import VirtualStation, station_file
from tests.prefect_line import PASSWORD, PrefectLine, flow_runs, prefect_line, wait_for

pytestmark = pytest.mark.real_time
ZONE, CRON = "Europe/Berlin", "0 8 * * 1-5"
SCHEDULED_S = 60.0  # of a busy machine; the server looks every 2 s


@pytest.fixture(scope="module")
def line(prefect_database, tmp_path_factory) -> Iterator[PrefectLine]:
    """A server with the deployments of the line and of a station, made twice."""
    with prefect_line(tmp_path_factory.mktemp("deployed"), prefect_database) as line:
        file = line.folder / "station.json"
        virtual = station_file(VirtualStation(), 1.0, "127.0.0.1", 1, 2)
        file.write_text(virtual.model_dump_json(), encoding="utf-8")
        line.mimucal("station", "add", file, "--schedule", CRON, "--timezone", ZONE)
        own = {PREFECT_API_URL: line.url, PREFECT_API_AUTH_STRING: PASSWORD}
        with temporary_settings(own):  # once more changes nothing
            for _ in range(2):
                deploy_line(Home(line.home), ZONE)
            deploy_station("VIRTUAL-1", str(kept_file(line)), Home(line.home), CRON, ZONE)
        yield line


def kept_file(line: PrefectLine) -> Path:
    return line.home / "stations/VIRTUAL-1.json"


def deployment(name: str) -> dict:
    return get(f"/deployments/name/{name}")


def test_every_active_schedule_has_runs_to_come(line):
    """With Prefect 3.8.8 and SQLAlchemy 2.1.9 none ever came."""
    for name in ("remind/remind", "submit/submit", "review/review", "produce/VIRTUAL-1"):
        runs = wait_for(lambda name=name: flow_runs(name, "SCHEDULED"), SCHEDULED_S)
        assert all(run["auto_scheduled"] for run in runs)


def test_what_is_scheduled_keeps_the_hour_of_its_zone(line):
    runs = wait_for(lambda: flow_runs("produce/VIRTUAL-1", "SCHEDULED"), SCHEDULED_S)
    there = [datetime.fromisoformat(run["expected_start_time"]) for run in runs]
    local = [moment.astimezone(ZoneInfo(ZONE)) for moment in there]
    assert {(moment.hour, moment.minute) for moment in local} == {(8, 0)}
    assert {moment.weekday() for moment in local} <= set(range(5))


def test_a_station_has_a_pool_of_one_run_at_a_time_and_the_line_another(line):
    assert get("/work_pools/station-VIRTUAL-1")["concurrency_limit"] == 1
    assert get("/work_pools/line")["concurrency_limit"] is None
    made = deployment("produce/VIRTUAL-1")
    assert made["work_pool_name"] == "station-VIRTUAL-1"
    assert made["global_concurrency_limit"] is None
    kept = kept_file(line)
    assert made["parameters"] == {"order": {"station": str(kept)}}
    assert kept.stat().st_mode & 0o777 == 0o600
    unit = line.home / "systemd/home-station-VIRTUAL-1.service"
    assert "mimucal station work VIRTUAL-1" in unit.read_text(encoding="utf-8")


def test_no_deployment_names_the_checkout_or_a_password(line, monkeypatch):
    for each in post("/deployments/filter", {}):
        assert each["path"] is None
        assert each["pull_steps"] in (None, [])
        assert each["entrypoint"].startswith("flows.on_prefect.flows.")
        assert os.getcwd() not in str(each["job_variables"])
    monkeypatch.setenv("MIMUCAL_DATABASE", "postgresql://me:secret@host/mimucal")
    assert "secret" not in str(environment(Home(line.home)))


def test_each_deployment_is_a_flow_that_takes_its_parameters(line):
    for each in OF_THE_LINE:
        made = deployment(f"{each.flow}/{each.flow}")
        flow = getattr(flows, each.flow)
        if made["parameters"]:
            flow.validate_parameters(made["parameters"])
        assert set(made["parameter_openapi_schema"]["properties"]) == {"order"}
        assert (made["global_concurrency_limit"] is not None) == each.alone


def test_late_crashed_and_silent_are_watched_once_each(line):
    names = [each["name"] for each in post("/automations/filter", {})]
    assert sorted(names) == sorted(set(names))
    for what in ("late", "crashed", "silent", "worker", "invalid", "reminder"):
        assert any(what in name for name in names)


def test_nobody_without_the_password_reaches_the_server(line):
    for path in ("/deployments/filter", "/flow_runs/filter"):
        answer = httpx.post(f"{line.url}{path}", json={}, timeout=30)
        assert answer.status_code == 401


def test_the_doctor_sees_schedules_workers_leases_and_the_door(line):
    wait_for(lambda: flow_runs("produce/VIRTUAL-1", "SCHEDULED"), SCHEDULED_S)
    found = {each.what: each for each in examine_prefect()}
    for what in ("Prefect", "Prefect's door", "Prefect's leases", "Prefect's schedules"):
        assert found[what].remedy is None, found[what]
    assert found["Prefect's schedules"].found == "4 produce runs"
    workers = found["Prefect's workers"]
    assert workers.found == "none lives of line, station-VIRTUAL-1"
    assert workers.remedy is not None


def test_a_station_that_is_removed_leaves_nothing_on_the_server(line):
    with temporary_settings({PREFECT_API_URL: line.url, PREFECT_API_AUTH_STRING: PASSWORD}):
        deploy_station("B-2", "b.json", Home(line.home), None, ZONE)
        assert deployment("produce/B-2")["schedules"] == []
        for _ in range(2):
            remove_station("B-2")
    names = {each["name"] for each in post("/deployments/filter", {})}
    assert "B-2" not in names
    assert "station-B-2" not in {each["name"] for each in post("/work_pools/filter", {})}
