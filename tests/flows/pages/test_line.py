"""The line as it is now: stations, alarms, orders, the day, and what Prefect holds."""

import json
import time
from collections.abc import Callable, Iterator
from datetime import UTC, date, datetime, timedelta
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from threading import Thread
from typing import Any

import pytest

from flows.pages import line_data, login, parts
from flows.pages.app import make_app
from flows.pages.line import KINDS, PAGE, card
from flows.pages.line_data import (
    SILENT,
    AlarmPressed,
    LineNow,
    LineQuestion,
    StationNow,
    acknowledge,
    output,
)
from flows.pages.parts import View, seen_by
from schemas.access import ROLES, Visitor
from schemas.base import Unusable
from schemas.orders import ProductionOrder
from schemas.recording import Alarm, RunStatus, Unit
from schemas.station import StopAnswer, StopRequest
from storage.catalogue import database, equipment, orders, runs
from storage.catalogue.database import Busy
from storage.home import Home
from storage.stations import answer_stop, lock_out, one_run_on, write_status
from tasks.station import monitor
from tasks.words import identifiers, known
from tests.drafts import draft
from tests.tasks.station.sample_stations import sample

OPERATOR = Visitor(name="Wang", role="operator")


def status(**changes: object) -> RunStatus:
    now = datetime.now(UTC)
    fields = {
        "station": "T1", "procedure": "jjf2003", "units": ("V1",), "process": 1, "began_at": now,
        "at": now, "state": "measuring", "now": "rate x", "segment": 3, "segments": 48,
        "station_s_done": 10.0, "station_s_total": 40.0, "wall_s_left": 90.0,
    }  # fmt: skip
    return RunStatus.model_validate(fields | changes)


def line_of(home: Home) -> LineNow:
    return PAGE.data(LineQuestion(), home)


def only(home: Home) -> StationNow:
    (found,) = line_of(home).stations
    return found


VIEW = View("en", visitor=OPERATOR)


def shown(home: Home, view: View = VIEW) -> str:
    laid_out = seen_by(view, PAGE.layout, line_of(home), LineQuestion())
    return json.dumps(
        laid_out.to_plotly_json(), default=lambda part: part.to_plotly_json(), ensure_ascii=False
    )


def ordered(number: str, station: str = "T1", serial: str = "V7") -> ProductionOrder:
    unit = Unit(manufacturer="Maker", model="U", serial=serial)
    return ProductionOrder(
        number=number, station=station, units=(unit,), procedure="jjf2003", person="Wang",
        ordered_at=datetime.now(UTC),
    )  # fmt: skip


@pytest.fixture
def station_file(tmp_path: Path) -> Path:
    """The file of station S9 in the home, whose devices do not answer."""
    fields = sample("mimucal")
    for device in ("table", "chamber", "fixture", "unit_link"):
        fields[device]["url"] = "socket://127.0.0.1:1"
    fields["station"]["id"] = "S9"
    file = tmp_path / "stations" / "s9.json"
    file.parent.mkdir(parents=True)
    file.write_text(json.dumps(fields), encoding="utf-8")
    return file


def test_a_station_of_the_home_that_never_ran_has_a_card_with_a_stop(
    tmp_path: Path, station_file: Path
) -> None:
    now = only(Home(tmp_path))
    assert (now.station, now.state, now.run) == ("S9", "free", None)
    assert "No run yet" in shown(Home(tmp_path))
    assert '"data-stop": "S9"' in shown(Home(tmp_path))


def test_a_station_file_that_cannot_be_used_is_an_alarm_and_hides_no_other(
    tmp_path: Path, station_file: Path
) -> None:
    station_file.with_name("broken.toml").write_text("format = 1", encoding="utf-8")
    line = line_of(Home(tmp_path))
    assert [each.station for each in line.stations] == ["S9"]
    (alarm,) = line.alarms
    assert alarm.about == "broken.toml"
    assert "correct" in alarm.cause.en


def test_a_station_is_alive_while_its_process_holds_it_and_lost_after(tmp_path: Path) -> None:
    home = Home(tmp_path)
    write_status(status(), home)
    with one_run_on("T1", home):
        assert only(home).state == "measuring"
    lost = only(home)
    assert lost.state == "lost"
    assert KINDS[lost.state] == "bad"
    assert lost.alarm is not None
    assert "Press Stop" in lost.alarm.todo.en


def test_a_run_of_which_nothing_is_heard_is_not_said_to_measure(tmp_path: Path) -> None:
    home = Home(tmp_path)
    write_status(status(at=datetime.now(UTC) - SILENT - timedelta(seconds=1)), home)
    with one_run_on("T1", home):
        assert only(home).state == "silent"
        write_status(status(at=datetime.now(UTC) - SILENT * 2, state="finishing"), home)
        assert only(home).state == "finishing"  # which writes nothing while it stores


@pytest.mark.parametrize(("state", "seen"), [("done", "free"), ("stopped", "stopped")])
def test_a_run_that_ended_leaves_the_station_free_or_stopped(
    tmp_path: Path, state: str, seen: str
) -> None:
    write_status(status(state=state, cause="the table tripped"), Home(tmp_path))
    assert only(Home(tmp_path)).state == seen


def test_a_card_says_state_unit_segment_time_alarm_and_next_unit(tmp_path: Path) -> None:
    home = Home(tmp_path)
    noticed = Alarm(code="spikes", at=datetime.now(UTC), en="spikes (2×)", zh="野值（2 次）")
    write_status(status(wall_s_left=4321.0, alarms=(noticed,)), home)
    orders.add([ordered("A-1", serial="V8")], home)
    with one_run_on("T1", home):
        page = shown(home)
        for part in ("Measuring", "V1", "3 / 48", "1 h 13 min", "spikes (2", "reject it", "V8"):
            assert part in page
        assert "剔除" in shown(home, View("zh"))


def test_every_state_has_a_colour_and_a_word() -> None:
    for state, kind in KINDS.items():
        assert kind in ("good", "open", "bad", "none")
        assert state == "done" or known(f"pages-line-state.{state.replace('_', '-')}")


def test_every_kind_of_alarm_says_what_to_do() -> None:
    kinds = [name.removeprefix("station-alarm-") for name in identifiers("station-alarm-")]
    assert {each.replace("_", "-") for each in (*monitor.FAILURES, *monitor.CONDITIONS)} <= {*kinds}
    assert [kind for kind in (*kinds, "given-up") if not known(f"station-todo.{kind}")] == []


def test_the_queue_is_by_station_unit_and_procedure(tmp_path: Path) -> None:
    home = Home(tmp_path)
    orders.add([ordered("A-1"), ordered("A-2", "T2", "V8"), ordered("A-3")], home)
    orders.claim("A-1", home)
    line = line_of(home)
    assert [each.station for each in line.stations] == ["T1", "T2"]
    first, second = line.stations
    assert [(each.number, each.state) for each in first.waiting] == [
        ("A-1", "running"), ("A-3", "waiting"),
    ]  # fmt: skip
    assert [each.serials for each in second.waiting] == [("V8",)]
    assert "jjf2003" in shown(home)


def test_a_card_says_what_keeps_the_next_order_from_beginning(tmp_path: Path) -> None:
    home = Home(tmp_path)
    orders.add([ordered("A-1")], home)
    orders.note("A-1", home, fault="the unit says that it is V9: mount V7")
    assert "the unit says that it is V9: mount V7" in shown(home)
    orders.claim("A-1", home)
    assert "mount V7" not in shown(home)


def test_failed_orders_and_reminders_are_alarms(tmp_path: Path) -> None:
    home, now = Home(tmp_path), datetime.now(UTC)
    orders.add([ordered("A-1")], home)
    orders.claim("A-1", home)
    orders.finish("A-1", "failed", home, "another unit is mounted")
    number = draft(home, "9").certificate.number
    key = (number, -30, "mail")
    equipment.claim(home, key, now, lambda tries: timedelta(hours=1))
    equipment.note(home, key, now, "mailbox full")
    unsent, failed = line_of(home).alarms
    assert (failed.station, failed.about) == ("T1", "V7")
    assert "another unit is mounted" in failed.cause.en
    assert (unsent.about, unsent.at) == (number, None)
    assert "mailbox full" in unsent.cause.en
    assert "mailbox" not in unsent.cause.zh  # which is no Chinese


def test_without_the_catalogue_stations_are_shown_and_can_be_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = Home(tmp_path)
    write_status(status(), home)

    def rows(*_: object) -> None:
        raise Busy("The catalogue cannot be used (it was stopped).")

    monkeypatch.setattr(database, "rows", rows)
    line = line_of(home)
    assert line.catalogue
    assert line.today is None
    assert '"data-stop": "T1"' in shown(home)


@pytest.fixture
def clock_of(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], None]]:
    """Sets the time zone of this process."""

    def put(zone: str) -> None:
        monkeypatch.setenv("TZ", zone)
        time.tzset()

    yield put
    monkeypatch.undo()
    time.tzset()


def test_today_is_the_day_where_the_pages_are_served(
    tmp_path: Path, clock_of: Callable[[str], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    evening = datetime(2026, 11, 27, 17, 30, tzinfo=UTC)  # half past one of the next day there

    class Clock(datetime):
        @classmethod
        def now(cls, tz: Any = None) -> datetime:
            return evening.astimezone(tz)

    monkeypatch.setattr(runs, "datetime", Clock)
    clock_of("Asia/Shanghai")
    home = Home(tmp_path)
    draft(home, "1")
    made = output(date(2026, 11, 28), home)
    assert (made.runs, made.valid, made.passed, made.issued) == (1, 1, 1, 0)
    assert made.by_station == {"T1": 1}
    assert output(date(2026, 11, 27), home).runs == 0
    monkeypatch.setattr(parts, "datetime", Clock)
    assert parts.today() == date(2026, 11, 28)
    assert parts.hour_of(evening) == "01:30"
    assert parts.hour_of(evening - timedelta(days=1)) == "2026-11-27 01:30"
    assert dict(parts.zone().arguments) == {"zone": "CST", "offset": "+08:00"}


def press(home: Home, station: str, visitor: Visitor = OPERATOR) -> Any:
    """The answer to a press of Stop."""
    server = make_app(home).server
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(login, "_identified", lambda *_: visitor)
        patch.setattr(login.CSRFProtect, "protect", lambda _: None)
        return server.test_client().post("/api/v1/stop", json={"station": station})


@pytest.mark.parametrize("role", ROLES)
def test_operators_and_administrators_stop_a_station_and_nobody_else(
    tmp_path: Path, role: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    home, visitor = Home(tmp_path), Visitor.model_validate({"name": "Li", "role": role})
    asked: list[tuple[str, str]] = []

    def stop(station: str, by: str, _: Home) -> None:
        asked.append((station, by))
        raise Unusable("the table does not answer")

    monkeypatch.setattr("flows.pages.line_data.stop_station", stop)
    answer = press(home, "T1", visitor)
    may = role in ("operator", "administrator")
    assert asked == ([("T1", "Li")] if may else [])
    assert answer.status_code == (200 if may else 403)
    assert may or "may not do this" in answer.json["error"]
    write_status(status(began_at=datetime.now(UTC) - timedelta(hours=1)), home)
    assert ('"data-stop": "T1"' in shown(home, View(visitor=visitor))) == may


def test_without_a_token_of_the_page_nothing_is_stopped(tmp_path: Path) -> None:
    client = make_app(Home(tmp_path)).server.test_client()
    assert client.post("/api/v1/stop", json={"station": "T1"}).status_code == 400


def test_a_table_that_may_still_turn_is_said_so_until_a_later_run_begins(
    tmp_path: Path, station_file: Path
) -> None:
    home = Home(tmp_path)
    became = press(home, "S9").json  # nobody listens where its table is said to be
    assert not became["is_at_rest"]
    assert became["fault"]
    assert "emergency stop (Wang" in shown(home)
    write_status(status(station="S9"), home)
    assert "emergency stop (Wang" not in shown(home)


def test_release_stands_far_from_stop_and_is_asked_first(tmp_path: Path) -> None:
    home = Home(tmp_path)
    write_status(status(state="stopped", cause="the table tripped"), home)
    request = StopRequest(key="k", station="T1", by="Li", at=datetime.now(UTC))
    lock_out(request, home)
    _, released, _, foot = seen_by(VIEW, card, only(home)).children
    assert "data-release" in str(released)
    assert "Is nobody within reach of the table of T1?" in str(released)
    assert "data-release" not in str(foot)
    assert "data-stop" in str(foot)
    assert "At rest" not in shown(home)
    answer_stop(StopAnswer(key="k", process=1, at_rest=True), home.locks, "T1")
    assert "At rest: stopped by Li" in shown(home)  # whoever stopped it, and wherever


def test_an_alarm_is_acknowledged_on_the_page_by_whoever_may_stop(tmp_path: Path) -> None:
    home = Home(tmp_path)
    write_status(status(state="stopped", cause="the table tripped"), home)
    (alarm,) = line_of(home).alarms
    assert f'"data-acknowledge": "{alarm.key}"' in shown(home)
    assert "data-acknowledge" not in shown(home, View(visitor=Visitor(name="Wu", role="viewer")))
    acknowledge(AlarmPressed(alarm=alarm.key), OPERATOR, home)
    assert "data-acknowledge" not in shown(home)
    assert f"{OPERATOR.name}, " in shown(home)


ANSWERS: dict[str, list[dict[str, Any]]] = {
    "/api/flow_runs/filter": [
        {"name": "dynamic-barracuda", "deployment_id": "d1", "flow_id": "f1",
         "parameters": {"order": {"certificate": "LAB-1", "home": "/h"}}, "state_name": "Late",
         "expected_start_time": "2026-11-27T08:00:00Z", "work_pool_name": "line"},
        *({"name": "rare-moose", "deployment_id": "d2", "flow_id": "f2", "parameters": {},
           "state_name": "Scheduled", "expected_start_time": f"2026-11-27T09:{minute}0:00Z"}
          for minute in range(3)),
        {"name": "calm-otter", "deployment_id": None, "flow_id": "f3",
         "parameters": {"order": {"model": "U", "since": "2026-01-01"}}, "state_name": "Running",
         "expected_start_time": None},
        {"name": "V1 jjf2003", "deployment_id": "d4", "flow_id": "f4", "parameters": {},
         "state_name": "Pending", "expected_start_time": None},
    ],
    "/api/deployments/filter": [{"id": "d1", "name": "issue"}, {"id": "d2", "name": "remind"},
                                {"id": "d4", "name": "T1"}],
    "/api/flows/filter": [{"id": "f1", "name": "issue"}, {"id": "f2", "name": "remind"},
                          {"id": "f3", "name": "reprocess"}, {"id": "f4", "name": "produce"}],
}  # fmt: skip


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[tuple[str, str | None]]]:
    """A Prefect server's answers; the paths that were asked for, and in whose name."""
    asked: list[tuple[str, str | None]] = []

    class Server(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            self.rfile.read(int(self.headers["Content-Length"]))
            asked.append((self.path, self.headers["Authorization"]))
            self.send_response(200)
            self.end_headers()
            self.wfile.write(json.dumps(ANSWERS[self.path]).encode())

        def log_message(self, *_: object) -> None:
            pass

    with HTTPServer(("127.0.0.1", 0), Server) as made:
        Thread(target=made.serve_forever, daemon=True).start()
        monkeypatch.setenv("PREFECT_API_URL", f"http://127.0.0.1:{made.server_port}/api")
        monkeypatch.setenv("PREFECT_API_AUTH_STRING", "line:secret")
        line_data._asked.cache_clear()
        yield asked
        made.shutdown()


def test_prefects_runs_are_named_by_deployment_and_subject(
    server: list[tuple[str, str | None]], tmp_path: Path
) -> None:
    line = line_of(Home(tmp_path))
    assert line.flows.fault is None
    assert [(each.deployment, each.subject, each.state) for each in line.flows.runs] == [
        ("issue", "LAB-1", "Late"), ("remind", "", "Scheduled"),
        ("reprocess", "U, 2026-01-01", "Running"),
    ]  # fmt: skip
    (late,) = line.alarms
    assert late.about == "issue LAB-1"
    assert "work pool line" in late.todo.en
    assert {path for path, _ in server} == set(ANSWERS)
    assert {who for _, who in server} == {"Basic bGluZTpzZWNyZXQ="}


def test_without_a_server_there_are_no_other_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PREFECT_API_URL", raising=False)
    assert not line_data.flow_runs().server


def test_a_server_that_does_not_answer_is_said_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PREFECT_API_URL", "http://127.0.0.1:9/api")
    line_data._asked.cache_clear()
    line = line_of(Home(tmp_path))
    assert line.flows.fault
    assert "did not answer" in line.flows.fault
    (alarm,) = line.alarms
    assert "administrator" in alarm.todo.en
