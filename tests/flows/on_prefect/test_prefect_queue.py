"""Orders on a real Prefect server: one flow run for each, named by unit and procedure."""

import os
from collections.abc import Callable
from datetime import timedelta
from pathlib import Path
from typing import Any

import httpx
import pytest
from prefect.settings import PREFECT_API_URL, temporary_settings

from flows.on_prefect import queue
from flows.on_prefect.queue import work_at_station, work_for_line
from flows.on_prefect.server import QUIET
from flows.orders.production import submit
from storage.catalogue import orders
from storage.home import Home
from tests.flows.order_homes import add_station

pytestmark = [pytest.mark.real_time, pytest.mark.rehearsal]  # a server of its own
TIMEOUT_S = 120.0


def asked(server: str, path: str, **document: Any) -> Any:
    answer = httpx.post(f"{server}/{path}", json=document, timeout=TIMEOUT_S)
    answer.raise_for_status()
    return answer.json()


def deploy(server: str, station: str, **further: Any) -> None:
    """A deployment `produce/STATION` in a pool of its own."""
    flow = asked(server, "flows/", name="produce")["id"]
    own = {"order": {"laboratory": "lab.toml"}}
    asked(server, "deployments/", flow_id=flow, name=station, parameters=own, **further)


def runs(server: str, station: str = "LINE-1") -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = asked(server, "flow_runs/filter", sort="START_TIME_ASC")
    return [run for run in found if station in run["tags"]]


@pytest.fixture
def order(mimucal, monkeypatch: pytest.MonkeyPatch) -> Callable[..., tuple[Any, str]]:
    """`mimucal order …` with the server at a URL; its document and what it says beside."""
    for name, quiet in QUIET.items():  # `connect` sets what is not set
        monkeypatch.setenv(name, quiet)
    monkeypatch.setenv("MIMUCAL_USER", "Li")

    def run(url: str, *arguments: str) -> tuple[Any, str]:
        monkeypatch.setenv("PREFECT_API_URL", url)
        with temporary_settings({PREFECT_API_URL: url}):
            done = mimucal("order", *arguments, "--json")
        assert done.code == 0, done.err
        return done.json, done.err

    return run


def test_each_order_is_one_flow_run_whatever_happens_to_the_server(
    home: Path, order, prefect_server: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    add_station(home)
    line = Home(home)
    add = ("add", "LINE-1", "--serial", "S1", "--number", "1")
    gone, notice = order("http://127.0.0.1:1/api", *add)
    assert gone["new"] == ["1"]
    assert "Prefect's server http://127.0.0.1:1/api did not answer" in notice
    _, notice = order(prefect_server, *add)
    assert "no deployment produce/LINE-1: add station LINE-1" in notice

    deploy(prefect_server, "LINE-1")
    order(prefect_server, "add", "LINE-1", "--serial", "S2", "--number", "2")
    order(prefect_server, *add)
    first, second = sorted(runs(prefect_server), key=lambda run: str(run["name"]))
    assert [run["name"] for run in (first, second)] == ["S1 jjf2003", "S2 jjf2003"]
    assert sorted(first["tags"]) == ["LINE-1", "S1"]
    assert first["idempotency_key"] == "1"
    assert first["parameters"]["order"] == {
        "station": "LINE-1", "number": "1", "laboratory": "lab.toml",
    }  # fmt: skip
    assert orders.find("1", line).flow_run == first["id"]

    # one that ended before it took its order is followed by another
    crashed = {"state": {"type": "CRASHED"}, "force": True}
    asked(prefect_server, f"flow_runs/{first['id']}/set_state", **crashed)
    order(prefect_server, *add)
    again = orders.find("1", line)
    assert again.flow_run not in (None, first["id"])
    assert (again.submissions, len(runs(prefect_server))) == (2, 3)

    # one whose worker died before it began holds the place of its pool no longer
    asked(prefect_server, f"flow_runs/{again.flow_run}/set_state", state={"type": "PENDING"})
    order(prefect_server, *add)
    assert orders.find("1", line).flow_run == again.flow_run
    monkeypatch.setattr(queue, "BEGINS_WITHIN", timedelta())
    order(prefect_server, *add)
    assert orders.find("1", line).flow_run not in (None, again.flow_run)
    states = {run["id"]: run["state_type"] for run in runs(prefect_server)}
    assert states[again.flow_run] == "CRASHED"

    order(prefect_server, "cancel", "2")
    states = {run["id"]: run["state_type"] for run in runs(prefect_server)}
    assert states[second["id"]] == "CANCELLED"
    order(prefect_server, "retry", "2")
    assert orders.find("2", line).flow_run not in (None, second["id"])


def test_a_worker_of_a_station_frees_the_place_of_what_the_one_before_it_did_not_begin(
    home: Path, order, prefect_server: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    add_station(home, "LINE-3")
    pool = {"name": "station-LINE-3", "type": "process", "base_job_template": {}}
    asked(prefect_server, "work_pools/", **pool)
    deploy(prefect_server, "LINE-3", work_pool_name="station-LINE-3")
    order(prefect_server, "add", "LINE-3", "--serial", "S7", "--number", "7")
    taken = orders.find("7", Home(home)).flow_run
    asked(prefect_server, f"flow_runs/{taken}/set_state", state={"type": "PENDING"})

    became: list[Any] = []
    monkeypatch.setattr(os, "execve", lambda *command: became.append(command))
    with temporary_settings({PREFECT_API_URL: prefect_server}):
        work_at_station("LINE-3", Home(home), submit)
    ((_, command, variables),) = became
    assert command[1:] == [
        "-m", "prefect", "worker", "start", "--pool", "station-LINE-3", "--type", "process",
        "--name", "LINE-3",
    ]  # fmt: skip
    assert variables["PREFECT_CLIENT_RETRY_EXTRA_CODES"] == "500"  # its database may be away
    states = {run["id"]: run["state_type"] for run in runs(prefect_server, "LINE-3")}
    assert states.pop(taken) == "CRASHED"
    assert orders.find("7", Home(home)).flow_run in states


def test_a_worker_is_of_the_line_or_of_a_station_that_is_there(
    home: Path, mimucal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PREFECT_API_URL", "http://127.0.0.1:1/api")
    assert "has no file of station LINE-9" in mimucal("station", "work", "LINE-9").err
    became: list[Any] = []
    monkeypatch.setattr(os, "execve", lambda *command: became.append(command))
    work_for_line(Home(home))
    assert became[0][1][-6:] == ["--pool", "line", "--type", "process", "--name", "line"]
    assert became[0][2]["PREFECT_HOME"] == str(home / "prefect")
    monkeypatch.delenv("PREFECT_API_URL")
    assert "no Prefect server is named" in mimucal("work").err
