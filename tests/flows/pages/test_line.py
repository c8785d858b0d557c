"""The line as it is now: stations, the day, and what Prefect holds."""

import json
from datetime import UTC, datetime, timedelta
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from threading import Thread

import pytest

from flows.pages import line
from flows.pages.page import View
from schemas.pages.line import LineQuestion
from schemas.run_log import RunStatus
from storage.home import Home
from storage.station_lock import one_run_on, write_status
from tests.drafts import draft

NOW = datetime(2026, 11, 23, 6, tzinfo=UTC)


def status(**changes: object) -> RunStatus:
    fields = {
        "station": "T1", "procedure": "jjf2003", "units": ("V1",), "process": 1, "began_at": NOW,
        "at": NOW, "state": "measuring", "now": "rate x", "segment": 3, "segments": 48,
        "station_s_done": 10.0, "station_s_total": 40.0, "wall_s_left": 90.0,
    }  # fmt: skip
    return RunStatus.model_validate(fields | changes)


def test_a_station_is_alive_while_its_process_holds_it_and_dead_after(tmp_path: Path) -> None:
    home = Home(tmp_path)
    write_status(status(), home)
    with one_run_on("T1", home):
        (alive,) = line.data(LineQuestion(), home).stations
        assert line._state(alive).kind == "good"
    (dead,) = line.data(LineQuestion(), home).stations
    assert dead.is_dead
    assert line._state(dead).kind == "bad"
    assert "V1" in str(line.layout(line.data(LineQuestion(), home), View("zh"), LineQuestion()))


def test_the_day_counts_what_was_taken_in_on_it(tmp_path: Path) -> None:
    home, today = Home(tmp_path), datetime.now(UTC).date()
    draft(home, "1")
    made = line.output(today, home)
    assert (made.runs, made.valid, made.passed, made.issued) == (1, 1, 1, 0)
    assert made.by_station == {"T1": 1}
    assert line.output(today - timedelta(days=1), home).runs == 0


def test_without_a_server_there_is_no_queue(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PREFECT_API_URL", raising=False)
    assert not line.queue().server


def test_the_queue_is_what_the_server_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    held = [{"name": "acquire on T1", "state_name": "Late", "expected_start_time": str(NOW)}]
    asked = []

    class Server(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            asked.append((self.path, self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(200)
            self.end_headers()
            self.wfile.write(json.dumps(held).encode())

        def log_message(self, *_: object) -> None:
            pass

    with HTTPServer(("127.0.0.1", 0), Server) as server:
        Thread(target=server.handle_request, daemon=True).start()
        monkeypatch.setenv("PREFECT_API_URL", f"http://127.0.0.1:{server.server_port}/api")
        line._asked.cache_clear()
        found = line.queue()
    assert found.fault is None
    assert [(each.name, each.state) for each in found.waiting] == [("acquire on T1", "Late")]
    assert asked[0][0] == "/api/flow_runs/filter"
    assert b"RUNNING" in asked[0][1]


def test_a_server_that_does_not_answer_is_said_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PREFECT_API_URL", "http://127.0.0.1:9/api")
    line._asked.cache_clear()
    found = line.queue()
    assert found.server
    assert found.fault
    assert "did not answer" in found.fault
