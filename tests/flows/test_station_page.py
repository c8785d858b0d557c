"""The page of a station's own computer: what it shows, and who may press its button."""

import http.client
import re
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from flows.station_page import StationPage, page_server
from schemas.station import Stopped
from storage.home import Home
from storage.stations import one_run_on, write_status
from tests.storage.test_stations import status

FORM = {"Content-Type": "application/x-www-form-urlencoded"}


@pytest.fixture
def served(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[StationPage, int]]:
    def stop_station(station: str, by: str, home: Home) -> Stopped:
        return Stopped(station=station, by=by, at_rest=True, way="run", seconds=0.4)

    monkeypatch.setattr("flows.station_page.stop_station", stop_station)
    page = StationPage("T1", "Li", Home(tmp_path))
    with page_server(page, 0) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        yield page, server.server_port
        server.shutdown()
        thread.join()


def asked(port: int, method: str, path: str, body: str = "", **headers: str) -> tuple[int, str]:
    line = http.client.HTTPConnection("127.0.0.1", port, timeout=30)
    try:
        line.request(method, path, body, FORM | headers)
        answer = line.getresponse()
        return answer.status, answer.read().decode()
    finally:
        line.close()


def test_it_shows_how_the_station_stands(served, tmp_path):
    _, port = served
    assert "no run yet" in asked(port, "GET", "/")[1]
    with one_run_on("T1", Home(tmp_path)):
        write_status(status("measuring"), Home(tmp_path))
        code, shown = asked(port, "GET", "/now")
    assert code == 200
    assert "measuring" in shown
    assert "Process lost" in asked(port, "GET", "/now")[1]


def test_its_button_stops_the_station_and_shows_what_came_of_it(served):
    page, port = served
    token = re.search(r'name="token" value="([^"]+)"', asked(port, "GET", "/")[1])
    assert token
    assert asked(port, "POST", "/stop", f"token={token[1]}")[0] == 303
    assert page.stopped.by == "Li"
    assert "at rest, 0.4 s" in asked(port, "GET", "/now")[1]


@pytest.mark.parametrize(
    ("token", "headers"),
    [
        ("wrong", {}),
        ("", {}),
        (None, {"Origin": "http://elsewhere.example"}),
        (None, {"Host": "elsewhere.example"}),
    ],
)
def test_no_other_site_presses_it(served, token, headers):
    page, port = served
    body = f"token={page.token if token is None else token}"
    assert asked(port, "POST", "/stop", body, **headers)[0] == 403
    assert page.stopped is None


def test_a_name_that_leads_here_from_elsewhere_is_shown_nothing(served):
    assert asked(served[1], "GET", "/", Host="elsewhere.example")[0] == 404
