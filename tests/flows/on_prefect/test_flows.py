"""What Prefect's hooks do with a station whose run crashed."""

import json
import os
import subprocess
import sys
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from uuid import uuid4

import pytest
from prefect.client.schemas.objects import FlowRun, State, StateType
from prefect.context import FlowRunContext
from prefect.states import Crashed

from flows.on_prefect import artifacts, flows, queue
from flows.on_prefect.artifacts import PROGRESS_EVERY_S, UNANSWERED_S, ProgressArtifact
from flows.on_prefect.deployments import environment
from flows.on_prefect.flows import free_station
from flows.on_prefect.queue import one_of_those_due
from flows.orders.production import give
from schemas.orders import OrderRequest, ProduceOrder, ProductionOrder
from schemas.recording import RunStatus, Unit
from storage.catalogue import orders
from storage.home import Home
from storage.stations import one_run_on, write_status
from tasks.station.virtual import config
from tests.flows.order_homes import add_station

BOOTSTRAP = "_workspace_runtime_bootstrap.py"
CLAIM = "import sys; from storage.catalogue import orders; from storage.home import home; "
CLAIM += "orders.claim(sys.argv[1], home())"


@pytest.fixture
def station_file(tmp_path) -> Path:
    file = tmp_path / "station.json"
    station = config.virtual_station(1, False).model_copy(update={"id": "LAB-1"})
    made = config.station_file(station, 1.0, "127.0.0.1", 5020, 5021)
    file.write_text(made.model_dump_json(), encoding="utf-8")
    return file


@pytest.fixture
def stopped(monkeypatch) -> list[tuple[str, str]]:
    calls: list[tuple[str, str]] = []
    monkeypatch.setattr(
        "flows.on_prefect.flows.stop_station",
        lambda id_, by, _, **lockout: calls.append((id_, by)),
    )
    return calls


def crash(home: Home, file: Path) -> None:
    run: Any = SimpleNamespace(parameters={"order": {"station": str(file), "home": str(home.path)}})
    state: Any = SimpleNamespace(name="Crashed", message="its worker is gone")
    free_station(SimpleNamespace(name="produce"), run, state)


@pytest.fixture
def left(tmp_path, station_file) -> Home:
    """A home in which a run of the station began, and has not said how it ended."""
    home, now = Home(tmp_path / "home"), datetime.now(UTC)
    write_status(
        RunStatus(
            station="LAB-1", procedure="jjf2003", process=1, began_at=now, at=now,
            state="measuring", now="rate", segment=3, segments=9, station_s_done=1.0,
            station_s_total=2.0, wall_s_left=1.0,
        ),
        home,
    )  # fmt: skip
    return home


def test_a_crash_stops_the_table_of_a_run_whose_process_is_dead(left, station_file, stopped):
    crash(left, station_file)
    assert stopped == [("LAB-1", "Prefect (Crashed: its worker is gone)")]


def test_a_crash_leaves_another_run_of_the_station_alone(left, station_file, stopped):
    with one_run_on("LAB-1", left):
        crash(left, station_file)
    assert stopped == []


def test_a_crash_of_an_order_whose_station_is_not_known_does_nothing(left, stopped):
    crash(left, Path("nowhere.json"))
    assert stopped == []


def begun_and_died(number: str, home: Home) -> None:
    """An order that another process took, which is dead."""
    request = {"number": number, "station": "LINE-1", "units": [{"serial": "S1"}]}
    give(OrderRequest.model_validate(request), "Li", home)
    own = os.environ | {"MIMUCAL_HOME": str(home.path)}
    subprocess.run([sys.executable, "-c", CLAIM, number], check=True, env=own)


@pytest.mark.real_time
def test_prefect_finds_our_hook_by_the_import_path_that_it_gives_it(tmp_path, monkeypatch):
    home = Home(tmp_path / "home")
    add_station(home.path)
    monkeypatch.setattr("flows.orders.production.start_worker", lambda *_: None)
    begun_and_died("1", home)
    assert [each.state for each in orders.listed(home)] == ["running"]
    runner = Path(str(find_spec("prefect.runner").submodule_search_locations[0]))  # type: ignore[union-attr, index]
    manifest = {
        "working_directory": str(tmp_path),
        "runtime_entrypoint": "flows.on_prefect.flows.produce",
    }
    (tmp_path / "manifest").write_text(json.dumps(manifest), encoding="utf-8")
    run = FlowRun(
        id=uuid4(), flow_id=uuid4(), parameters={"order": {"station": "LINE-1", "number": "1"}}
    )
    (tmp_path / "run").write_text(run.model_dump_json(), encoding="utf-8")
    (tmp_path / "state").write_text(Crashed(message="killed").model_dump_json(), encoding="utf-8")
    away = {"PREFECT_API_URL": "http://127.0.0.1:1/api", "PREFECT_LOGGING_TO_API_ENABLED": "false"}
    files = [str(tmp_path / name) for name in ("manifest", "run", "state")]
    done = subprocess.run(
        [sys.executable, str(runner / BOOTSTRAP), "hook", "crashed", *files],
        capture_output=True, text=True, cwd=tmp_path,
        env=os.environ | environment(home) | away | {"PREFECT_CLIENT_MAX_RETRIES": "0"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "Error" not in done.stderr
    assert [each.state for each in orders.listed(home)] == ["waiting"]


# Of the runs that a schedule owes, the newest is carried out, whichever starts first.

DEPLOYMENT = uuid4()
BEGAN = datetime(2026, 11, 27, 8, tzinfo=UTC)


def run(minute: int, state: StateType = StateType.SCHEDULED, auto: bool = True) -> FlowRun:
    return FlowRun(
        id=uuid4(), flow_id=uuid4(), deployment_id=DEPLOYMENT, auto_scheduled=auto,
        expected_start_time=BEGAN + timedelta(minutes=minute), state_type=state,
        state=State(type=state),
    )  # fmt: skip


class Server:
    """What is due of the deployment, and what was cancelled of it."""

    def __init__(self, *due: FlowRun) -> None:
        self.due, self.cancelled = list(due), []

    def read_flow_runs(self, flow_run_filter: object) -> list[FlowRun]:
        return self.due

    def set_flow_run_state(self, run_id: object, state: State) -> None:
        assert state.type is StateType.CANCELLED
        self.cancelled.append(run_id)


@pytest.fixture
def carried_out(monkeypatch):
    """Starts a run of those that are due; gives what its body did."""

    def start(own: FlowRun, server: Server) -> object:
        @contextmanager
        def client(**_: object):
            yield server

        context = SimpleNamespace(flow_run=own)
        monkeypatch.setattr(FlowRunContext, "get", classmethod(lambda cls: context))
        monkeypatch.setattr(queue, "get_client", client)
        return one_of_those_due(lambda order: f"done {order}")("it")

    return start


def test_the_first_that_starts_is_carried_out_and_cancels_what_waits(carried_out):
    """Else a schedule that repeats faster than its runs begin is never carried out."""
    own, *others = (run(minute) for minute in (0, 10, 20, 30))
    server = Server(own, *others)
    assert carried_out(own, server) == "done it"
    assert server.cancelled == [each.id for each in others]


def test_the_newest_is_carried_out_and_cancels_what_still_waits(carried_out):
    early, own = run(0), run(30)
    server = Server(early, own)
    assert carried_out(own, server) == "done it"
    assert server.cancelled == [early.id]


def test_a_newer_one_that_another_worker_took_is_left_to_it(carried_out):
    own, taken = run(0), run(10, StateType.RUNNING)
    server = Server(own, taken)
    assert carried_out(own, server).type is StateType.CANCELLED
    assert server.cancelled == []


def test_what_somebody_ordered_is_neither_cancelled_nor_counted(carried_out):
    own, ordered = run(0), run(10, auto=False)
    server = Server(own, ordered)
    assert carried_out(own, server) == "done it"
    assert carried_out(ordered, Server(own, ordered)) == "done it"
    assert server.cancelled == []


# What flow runs are called.


def test_a_run_of_the_queue_is_called_by_the_unit_and_procedure_of_its_order(tmp_path, monkeypatch):
    """Not by the unit that the station file names, which was mounted when it was written."""
    made = ProductionOrder(
        number="1", station="A", units=(Unit(manufacturer="M", model="U", serial="S7"),),
        procedure="/lab/short.json", person="Wang", ordered_at=datetime.now(UTC),
    )  # fmt: skip
    orders.add([made], Home(tmp_path))
    order = ProduceOrder(home=str(tmp_path), station="A", number="1")
    monkeypatch.setattr(flows, "flow_run", SimpleNamespace(parameters={"order": order}))
    assert flows.of_acquisition() == "S7 short"


# Progress on Prefect's pages: rare updates, rarer ones while the server does not answer.


@pytest.mark.parametrize(("answers", "pause_s"), [(True, PROGRESS_EVERY_S), (False, UNANSWERED_S)])
def test_an_update_comes_after_a_pause_and_at_the_end(monkeypatch, answers, pause_s):
    updates: list[int] = []
    now = [0.0]
    monkeypatch.setattr(artifacts, "show", lambda update: updates.append(1) or answers)
    show = ProgressArtifact("reprocess", clock=lambda: now[0])
    for second in range(200):
        now[0] = float(second)
        show(second, 200)
    assert len(updates) == 1 + int(199 // pause_s)
    show(200, 200)
    assert len(updates) == 2 + int(199 // pause_s)
