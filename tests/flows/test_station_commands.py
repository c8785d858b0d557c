"""What a person types and presses at a station: a dry run, its file, the page that stops it."""

import http.client
import json
import re
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from flows import station_commands as commands
from flows.station_page import StationPage, page_server
from schemas.laboratory import Limits
from schemas.station import Stopped
from storage.home import Home
from storage.stations import one_run_on, write_status
from tasks.station.virtual.config import VirtualStation, station_file
from tests.storage.test_stations import status
from tests.tasks.station.sample_stations import sample

# `acquire --dry-run` on a station that nobody answers for: nothing is connected, nothing moves.

SEGMENTS = 48  # 12 positions, 3 × 2 rests and 3 × 10 rates


@pytest.fixture
def station(tmp_path):
    """Writes the file of a station with these limits; its path."""

    def write(limits):
        file = station_file(VirtualStation(), 1.0, "127.0.0.1", 1, 1)
        path = tmp_path / "station.json"
        path.write_text(
            file.model_copy(update={"limits": Limits.model_validate(limits)}).model_dump_json()
        )
        return path

    return write


def test_every_segment_comes_with_its_beginning_and_its_motion(mimucal, station, home):
    done = mimucal("acquire", station({}), "--dry-run", "--json")
    assert done.code == 0
    assert done.json["format"] == "mimu-dry-run/1"
    segments = done.json["segments"]
    assert len({segment["segment"] for segment in segments}) == len(segments) == SEGMENTS
    first, *_, last = segments
    assert first["begins_s"] == 600.0  # the warm-up
    assert len(first["angles_deg"]) == 3
    assert first["rate_deg_s"] == 0.0
    assert {segment["rate_deg_s"] for segment in segments} >= {-200.0, 200.0}
    ends = [segment["begins_s"] + segment["takes_s"] for segment in segments]
    begins = [segment["begins_s"] for segment in segments]
    assert begins[1:] == pytest.approx(ends[:-1], abs=0.15)
    assert done.json["station_s"] == pytest.approx(last["begins_s"] + last["takes_s"], abs=0.15)
    assert not home.exists()


def test_a_person_reads_a_row_for_each_segment(mimucal, station):
    done = mimucal("acquire", station({}), "--dry-run")
    assert done.code == 0
    title, *rows = done.out.splitlines()
    assert title.startswith("JJF 2003")
    assert sum("rate_x_" in row for row in rows) > 1
    assert any("position_+x_000" in row for row in rows)


def test_what_the_table_must_not_do_is_said_before_anything_is_connected(mimucal, station):
    done = mimucal("acquire", station({"axes": {"outer": {"rate_deg_s": 5.0}}}), "--dry-run")
    assert done.code == 2
    assert "limit 5" in done.err
    assert done.out == ""


# `mimucal station stop`, and what `station status` says of a run that was killed.


@pytest.mark.real_time
def test_where_rest_is_not_confirmed_it_fails_and_names_the_emergency_stop(tmp_path, mimucal):
    fields = sample("mimucal")
    fields["table"]["url"] = "socket://127.0.0.1:1"
    file = tmp_path / "station.json"
    file.write_text(json.dumps(fields), encoding="utf-8")
    stopped = mimucal("station", "stop", file, "--by", "Li")
    assert stopped.code == 1
    assert "use the emergency stop" in stopped.err


def test_a_station_that_nobody_knows_is_one_sentence(mimucal):
    stopped = mimucal("station", "stop", "T9")
    assert stopped.code == 2
    assert "station T9" in stopped.err


def test_of_a_run_that_was_killed_nothing_says_that_it_goes_on(home, mimucal):
    write_status(status("measuring"), Home(home))
    (run,) = mimucal("station", "status", "--json").json["runs"]
    assert (run["state"], run["is_dead"]) == ("stopped", False)
    assert "ended without a word" in run["cause"]


# `mimucal station check` on a station that nobody answers for.


@pytest.mark.real_time
def test_every_device_that_does_not_work_is_said_and_the_command_fails(
    tmp_path, monkeypatch, capsys
):
    import typer

    monkeypatch.setenv("MIMUCAL_HOME", str(tmp_path / "home"))
    fields = sample("mimucal")
    for device in ("table", "chamber", "fixture", "unit_link"):
        fields[device]["url"] = "socket://127.0.0.1:1"
    file = Path(tmp_path / "station.json")
    file.write_text(json.dumps(fields), encoding="utf-8")
    with pytest.raises(typer.Exit) as end:
        commands.check(str(file), move=False, as_json=True)
    assert end.value.exit_code == 1
    checked = json.loads(capsys.readouterr().out)
    assert checked["format"] == "mimu-station-check/1"
    failed = {(trial["device"], trial["works"]) for trial in checked["trials"]}
    assert failed == {(name, False) for name in ("table", "chamber", "fixture", "unit")}


# Stations of a home without a Prefect server: their files, and what is refused.


@pytest.fixture
def given(tmp_path) -> Path:
    return written(tmp_path / "given.json", "S-1")


def written(path: Path, station: str) -> Path:
    file = station_file(VirtualStation(), 1.0, "127.0.0.1", 1, 2)
    named = file.station.model_copy(update={"id": station})
    path.write_text(file.model_copy(update={"station": named}).model_dump_json(), "utf-8")
    return path


def test_a_station_is_kept_under_its_id_for_its_owner_alone_and_goes_again(mimucal, home, given):
    for _ in range(2):
        added = mimucal("station", "add", given)
        assert added.code == 0, added.err
    (kept,) = (home / "stations").iterdir()
    assert (kept.name, kept.stat().st_mode & 0o777) == ("S-1.json", 0o600)
    assert kept.read_bytes() == given.read_bytes()
    assert mimucal("station", "remove", "S-1").code == 0
    assert not list((home / "stations").iterdir())
    assert mimucal("station", "remove", "S-1").code == 2


def test_what_was_kept_under_another_name_is_replaced(mimucal, home, given):
    (home / "stations").mkdir(parents=True)
    written(home / "stations/old.json", "S-1")
    assert mimucal("station", "add", given).code == 0
    assert [path.name for path in (home / "stations").iterdir()] == ["S-1.json"]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--schedule", "0 8 * * *"), "PREFECT_API_URL"),
        (("--timezone", "Mars/Base"), "--timezone Mars/Base"),
    ],
)
def test_what_cannot_be_done_is_refused_and_nothing_is_kept(
    mimucal, home, given, options, sentence
):
    refused = mimucal("station", "add", given, *options)
    assert refused.code == 2
    assert sentence in refused.err
    assert not home.exists()


def test_deploying_without_a_server_says_what_is_missing(mimucal, home):
    refused = mimucal("deploy")
    assert refused.code == 2
    assert "PREFECT_API_URL" in refused.err


# The page of a station's own computer: what it shows, and who may press its button.

FORM = {"Content-Type": "application/x-www-form-urlencoded"}


@pytest.fixture
def served(tmp_path, monkeypatch) -> Iterator[tuple[StationPage, int]]:
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
