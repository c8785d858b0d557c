"""The doctor finds what is wrong with a machine or a home, and says what to do."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from http.server import BaseHTTPRequestHandler, HTTPServer
from threading import Thread

import pytest

from schemas.recording import RunStatus
from schemas.store import Examined
from storage.catalogue import audit_trail, database
from storage.home import Home
from storage.stations import lock_place, one_run_on, write_status
from tasks.stages import doctor as stage
from tasks.stages.doctor import diagnose
from tasks.validation import record


@pytest.fixture
def empty(tmp_path, monkeypatch, validated) -> Home:
    monkeypatch.setattr(record, "shipped", lambda: validated)
    monkeypatch.delenv("PREFECT_API_URL", raising=False)
    monkeypatch.delenv("MIMUCAL_DATABASE", raising=False)
    return Home(tmp_path / "home")


def examined(home: Home, what: str) -> Examined:
    return next(one for one in diagnose(home).examined if one.what == what)


def test_a_fresh_home_on_a_sound_machine_needs_nothing(empty):
    assert diagnose(empty).faults == ()
    assert not empty.path.exists()


def test_a_missing_package_and_one_of_another_release_are_named(empty, monkeypatch):
    needed = ["numpy", "no-such-package", "scipy<1", "other; python_version < '3'"]
    monkeypatch.setattr(stage, "requires", lambda _: needed)
    found = examined(empty, "packages")
    assert "no-such-package is missing" in found.found
    assert "not <1" in found.found
    assert "other" not in found.found
    assert found.remedy is not None


def test_a_catalogue_that_is_none_is_told(empty):
    empty.path.mkdir()
    (empty.path / "catalog.sqlite").write_bytes(b"no database at all, and long enough" * 99)
    assert examined(empty, "catalogue").remedy is not None


def test_a_clock_behind_the_trail_is_told(empty):
    with database.changing(empty) as connection:
        audit_trail.add(
            connection, "Li Na", "issue", "A-1", at=datetime.now(UTC) + timedelta(days=2)
        )
    assert examined(empty, "clock").remedy == "Set the computer's clock."


@pytest.mark.parametrize("name", ["laboratory.toml", "recall.toml"])
def test_a_file_of_settings_that_cannot_be_read_is_told(empty, name):
    empty.path.mkdir()
    (empty.path / name).write_text("[")
    assert name in str(examined(empty, name).remedy)


def test_a_record_of_another_code_is_told(empty, monkeypatch, validated):
    methods = {
        name: each.model_copy(update={"fingerprint": "0" * 64})
        for name, each in validated.methods.items()
    }
    old = validated.model_copy(update={"code_version": "0.0.1+0 of old", "methods": methods})
    monkeypatch.setattr(record, "shipped", lambda: old)
    assert "mimucal validate" in str(examined(empty, "validation record").remedy)


def test_an_interrupted_run_is_told(empty):
    empty.acquiring.mkdir(parents=True)
    left = empty.acquiring / "20260301T000000Z-ab.mcap"
    left.touch()  # killed before its first readings: the next run removes it
    assert examined(empty, "interrupted runs").found == "none"
    left.write_bytes(b"recorded")
    assert "--resume" in str(examined(empty, "interrupted runs").remedy)


def test_a_run_that_is_going_on_is_none_of_the_interrupted(empty):
    recording = empty.acquiring / "20260301T000000Z-ab.mcap"
    recording.parent.mkdir(parents=True)
    recording.write_bytes(b"recorded")
    now = datetime.now(UTC)
    status = RunStatus(
        station="LINE-1", procedure="jjf2003", process=1, began_at=now, at=now, state="measuring",
        now="rate x", segment=3, segments=4, station_s_done=1.0, station_s_total=2.0,
        wall_s_left=1.0, recordings=(str(recording),), lock=lock_place(empty),
    )  # fmt: skip
    write_status(status, empty)
    with one_run_on("LINE-1", empty):
        assert examined(empty, "interrupted runs").found == "none"
    assert recording.name in examined(empty, "interrupted runs").found


def test_a_line_whose_operators_nobody_named_is_told(empty, monkeypatch):
    assert all(one.what != "alerts" for one in diagnose(empty).examined)
    monkeypatch.setenv("PREFECT_API_URL", "http://127.0.0.1:9/api")
    assert "[operators]" in str(examined(empty, "alerts").remedy)
    empty.path.mkdir(0o700)
    (empty.path / "recall.toml").write_text('[operators.channels]\nmail = "mailto://a@example.com"')
    assert examined(empty, "alerts").remedy is None


@pytest.mark.parametrize("url", ["http://127.0.0.1:9/api", "not an address"])
def test_a_prefect_server_that_does_not_answer_is_told(empty, monkeypatch, url):
    monkeypatch.setenv("PREFECT_API_URL", url)
    assert "PREFECT_API_URL" in str(examined(empty, "Prefect").remedy)


@contextmanager
def server_with(password: str | None) -> Iterator[str]:
    """The address of a server that answers whoever says this password, or everybody."""

    settings = {"server": {"concurrency": {"lease_storage": "lease_storage.filesystem"}}}

    class Answering(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.answer(settings)

        def do_POST(self) -> None:
            self.rfile.read(int(self.headers["Content-Length"]))
            self.answer([])

        def answer(self, document: object) -> None:
            is_right = password is None or self.headers.get("Authorization") == password
            self.send_response(200 if is_right else 401)
            self.end_headers()
            self.wfile.write(json.dumps(document).encode())

        def log_message(self, *_: object) -> None:
            pass

    with HTTPServer(("127.0.0.1", 0), Answering) as server:
        thread = Thread(target=server.serve_forever, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}/api"
        server.shutdown()
        thread.join()


def test_a_prefect_server_is_asked_with_its_password_and_one_without_is_told(empty, monkeypatch):
    monkeypatch.setenv("PREFECT_API_AUTH_STRING", "line:secret")
    with server_with("Basic bGluZTpzZWNyZXQ=") as url:
        monkeypatch.setenv("PREFECT_API_URL", url)
        assert examined(empty, "Prefect").remedy is None
        assert examined(empty, "Prefect's door").remedy is None
    with server_with("Basic other") as url:
        monkeypatch.setenv("PREFECT_API_URL", url)
        refused = examined(empty, "Prefect")
        assert refused.found == f"{url} refused PREFECT_API_AUTH_STRING"
        assert "mend PREFECT_API_URL or PREFECT_API_AUTH_STRING" in str(refused.remedy)
    with server_with(None) as url:
        monkeypatch.setenv("PREFECT_API_URL", url)
        assert "Set PREFECT_SERVER_API_AUTH_STRING" in str(examined(empty, "Prefect's door").remedy)


def test_a_home_that_everybody_may_read_is_told(empty):
    empty.path.mkdir(0o700)
    assert examined(empty, "rights of the home").remedy is None
    empty.path.chmod(0o755)
    assert "chmod -R o=" in str(examined(empty, "rights of the home").remedy)
