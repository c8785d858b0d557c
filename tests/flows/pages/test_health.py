"""`/health` and `/metrics`: what they say, and to whom."""

import base64
import json

import httpx
import pytest
from flask.testing import FlaskClient
from prometheus_client.parser import text_string_to_metric_families

from flows.pages import health, login
from flows.pages.app import make_app
from storage.catalogue import database, tables, users
from storage.home import Home
from storage.stations import write_status
from tests.pages_server import served
from tests.storage.test_stations import status

PASSWORD = "correct horse battery"
ELSEWHERE = {"REMOTE_ADDR": "192.0.2.7"}


def client_of(home: Home) -> FlaskClient:
    return make_app(home).server.test_client()


def metrics(client: FlaskClient) -> dict[str, float]:
    """Every sample by its name and labels, read by Prometheus' own parser."""
    text = client.get("/metrics").text
    return {
        f"{sample.name}{json.dumps(sample.labels, sort_keys=True)}": sample.value
        for family in text_string_to_metric_families(text)
        for sample in family.samples
    }


@pytest.fixture
def credentials() -> dict[str, str]:
    given = base64.b64encode(f"Wang Li:{PASSWORD}".encode()).decode()
    return {"Authorization": f"Basic {given}"}


@pytest.fixture
def known(tmp_path) -> Home:
    """A home with a user, whose pages ask for a name."""
    users.add("Wang Li", "viewer", login.hashed(PASSWORD), Home(tmp_path), "Admin")
    return Home(tmp_path)


def test_a_sound_home_is_healthy_and_anybody_may_ask(known):
    answer = client_of(known).get("/health", environ_base=ELSEWHERE)
    assert (answer.status_code, answer.json) == (200, {"ok": True, "faults": {}})


def test_what_is_wrong_is_said_without_names(known, monkeypatch):
    client = client_of(known)
    with database.changing(known) as connection:
        connection.execute(tables.sql.text("UPDATE alembic_version SET version_num = '0001'"))
    monkeypatch.setenv("MIMUCAL_STORE", "nonsense-with-a-secret")
    monkeypatch.setattr(health, "LEAST_FREE", 2**70)
    answer = client.get("/health", environ_base=ELSEWHERE)
    assert answer.status_code == 503
    assert answer.json["faults"].keys() == {"migrations", "store", "disk"}
    monkeypatch.setenv("MIMUCAL_DATABASE", "postgresql://lab:secret@127.0.0.1:1/mimucal")
    answer = client.get("/health", environ_base=ELSEWHERE)
    assert answer.json["faults"].keys() == {"database", "migrations", "store", "disk"}
    assert not any(word in answer.text for word in ("secret", "127.0.0.1", str(known.path), "lab"))


def test_a_part_that_does_not_answer_in_time_is_a_fault(known, monkeypatch):
    from threading import Event

    forever = Event()
    monkeypatch.setattr(health, "ANSWER_S", 0.05)
    monkeypatch.setitem(health.LOOKS, "store", lambda home: str(forever.wait(60)))
    assert health.health_checks(known)["store"] == "does not answer"
    forever.set()


def test_metrics_are_those_of_the_line(line_store):
    home, _ = line_store
    write_status(status("measuring"), home)
    client = client_of(home)
    client.get("/api/v1/runs")
    found = metrics(client)
    runs = {name: n for name, n in found.items() if name.startswith("mimucal_runs{")}
    assert sum(runs.values()) == 60
    assert found['mimucal_health{"part": "database"}'] == 1
    assert found["mimucal_disk_free_bytes{}"] > 0
    assert found["mimucal_last_run_age_seconds{}"] > 0
    assert found["mimucal_reminders_failed{}"] == 0
    station = status("measuring").station
    dead = json.dumps({"state": "dead", "station": station})
    assert found[f"mimucal_station_state{dead}"] == 1
    assert found['mimucal_http_requests_total{"status": "200"}'] == 1
    assert sum(n for name, n in found.items() if name.startswith("mimucal_certificates{")) > 0


def test_metrics_of_an_unreachable_catalogue_are_those_of_the_rest(known, monkeypatch):
    client = client_of(known)
    monkeypatch.setenv("MIMUCAL_DATABASE", "postgresql://lab@127.0.0.1:1/mimucal")
    found = metrics(client)
    assert found['mimucal_health{"part": "database"}'] == 0
    assert not any(name.startswith("mimucal_runs") for name in found)


def test_metrics_are_for_this_machine_and_for_those_with_a_name(known, credentials):
    client = client_of(known)
    assert client.get("/metrics").status_code == 200
    assert client.get("/metrics", environ_base=ELSEWHERE).status_code == 401
    assert client.get("/metrics", headers={"X-Forwarded-For": "192.0.2.7"}).status_code == 401
    assert client.get("/metrics", environ_base=ELSEWHERE, headers=credentials).status_code == 200
    wrong = {"Authorization": "Basic " + base64.b64encode(b"Wang Li:no").decode()}
    assert client.get("/metrics", environ_base=ELSEWHERE, headers=wrong).status_code == 401


@pytest.mark.real_time
@pytest.mark.parametrize("header", ["X-Forwarded-For", "Forwarded", "X-Forwarded-Host"])
def test_metrics_as_served_see_who_comes_through_a_proxy(tmp_path, header):
    """Whatever the server of the pages takes out of a request, it is no request of this machine."""
    with served(Home(tmp_path)) as url, httpx.Client(trust_env=False) as client:
        assert client.get(f"{url}/metrics").status_code == 200
        assert client.get(f"{url}/metrics", headers={header: "for=1.2.3.4"}).status_code == 401
