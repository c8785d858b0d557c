"""A run looks for itself whether it is to stop."""

import json
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest

from flows import signals
from flows.signals import FLOW_RUN, cancellation_watch
from tasks.station.connected_station import CANCELLATION, LOSS

pytestmark = pytest.mark.real_time


class Server(BaseHTTPRequestHandler):
    """Prefect's answer to one flow run, for those who know the password."""

    state = "RUNNING"
    asked: list[tuple[str, str | None]] = []  # noqa: RUF012

    def do_GET(self) -> None:
        self.asked.append((self.path, self.headers["Authorization"]))
        body = json.dumps({"state_type": type(self).state}).encode()
        self.send_response(200)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Iterator[type[Server]]:
    Server.state, Server.asked = "RUNNING", []
    with HTTPServer(("127.0.0.1", 0), Server) as serving:
        thread = threading.Thread(target=serving.serve_forever)
        thread.start()
        monkeypatch.setenv("PREFECT_API_URL", f"http://127.0.0.1:{serving.server_port}/api")
        monkeypatch.setenv("PREFECT_API_AUTH_STRING", "line:secret")
        monkeypatch.setenv(FLOW_RUN, "1234")
        monkeypatch.setattr(signals, "LOOK_S", 0.02)
        yield Server
        serving.shutdown()
        thread.join()


def caused() -> tuple[list[str], threading.Event]:
    return [], threading.Event()


def test_a_run_that_prefect_cancels_is_stopped_once(server) -> None:
    causes, stopped = caused()
    server.state = "CANCELLING"
    with cancellation_watch(lambda cause: (causes.append(cause), stopped.set())):
        assert stopped.wait(30)
    assert causes == [CANCELLATION]
    assert server.asked[0] == ("/api/flow_runs/1234", "Basic bGluZTpzZWNyZXQ=")


def test_a_run_whose_worker_is_gone_is_stopped_without_the_server(monkeypatch, server) -> None:
    causes, stopped = caused()
    monkeypatch.setenv("PREFECT_API_URL", "http://127.0.0.1:9/api")
    parents = iter([77, 77, 1])
    monkeypatch.setattr(signals.os, "getppid", lambda: next(parents, 1))
    with cancellation_watch(lambda cause: (causes.append(cause), stopped.set())):
        assert stopped.wait(30)
    assert causes == [LOSS]


def test_a_server_that_is_away_stops_nothing(monkeypatch, server) -> None:
    causes, _ = caused()
    monkeypatch.setenv("PREFECT_API_URL", "http://127.0.0.1:9/api")
    with cancellation_watch(causes.append):
        assert not threading.Event().wait(0.5)
    assert causes == []


def test_nothing_is_looked_for_outside_of_a_workers_process(monkeypatch, server) -> None:
    causes, _ = caused()
    monkeypatch.delenv(FLOW_RUN)
    server.state = "CANCELLED"
    with cancellation_watch(causes.append):
        assert not threading.Event().wait(0.3)
    assert (causes, server.asked) == ([], [])
