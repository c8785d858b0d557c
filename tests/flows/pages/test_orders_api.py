"""/api/v1/orders: a manufacturing system's orders, each once, and nobody else's."""

from typing import Any

import pytest
from flask.testing import FlaskClient
from werkzeug.test import TestResponse

from flows.pages import login
from flows.pages.app import make_app
from storage.catalogue import orders, users
from storage.home import Home
from tests.flows.order_homes import Begun, add_station, no_workers

PASSWORD = "correct horse battery"
ORDER = {"number": "4711", "station": "LINE-1", "units": [{"serial": "S1"}]}
CLIENT = {
    "received": "2026-01-08",
    "client": {"name": "C", "name_zh": "客户", "address": "A", "address_zh": "地址"},
}


@pytest.fixture
def begun(monkeypatch) -> Begun:
    return no_workers(monkeypatch)


@pytest.fixture
def home(tmp_path, begun) -> Home:
    add_station(tmp_path)
    for name, role in (("mes", "operator"), ("Zhao", "viewer")):
        users.add(name, role, login.hashed(PASSWORD), Home(tmp_path), "Admin")
    return Home(tmp_path)


@pytest.fixture
def client(home) -> FlaskClient:
    return make_app(home).server.test_client()


def give(client: FlaskClient, order: Any, name: str = "mes", **more: Any) -> TestResponse:
    return client.post("/api/v1/orders", json=order, auth=(name, PASSWORD), **more)


def test_an_order_is_created_once_and_is_there_with_what_became_of_it(client, home, begun):
    order = ORDER | {"client_order": CLIENT, "procedure": "jjf2003"}
    answers = [give(client, order), give(client, order)]
    assert [answer.status_code for answer in answers] == [201, 200]
    assert answers[0].json == answers[1].json
    assert (answers[0].json["person"], answers[0].json["state"]) == ("mes", "waiting")
    other = give(client, ORDER | {"units": [{"serial": "S2"}]})
    assert other.status_code == 400
    assert "order 4711 is there already" in other.json["error"]
    listed = client.get("/api/v1/orders?station=LINE-1", auth=("Zhao", PASSWORD)).json
    assert [each["number"] for each in listed["orders"]] == ["4711"]
    assert client.get("/api/v1/orders?station=X", auth=("Zhao", PASSWORD)).json["orders"] == []
    assert client.get("/api/v1/orders?state=x", auth=("Zhao", PASSWORD)).status_code == 400
    assert begun.commands[0][-3:] == ["station", "work", "LINE-1"]


def test_who_may_not_order_and_who_says_no_name_is_refused(client, home):
    assert give(client, ORDER, "Zhao").status_code == 403
    assert client.post("/api/v1/orders", json=ORDER).status_code == 401
    wrong = client.post("/api/v1/orders", json=ORDER, auth=("mes", "wrong password"))
    assert wrong.status_code == 401
    assert orders.listed(home) == []


def test_a_browser_that_knows_the_password_cannot_be_made_to_order(client, home):
    forged = client.post(
        "/api/v1/orders", data=str(ORDER), content_type="text/plain", auth=("mes", PASSWORD)
    )
    assert forged.status_code == 400
    page = client.get("/login", headers={"Accept": "text/html"}).text
    token = page.partition('name="csrf_token" value="')[2].partition('"')[0]
    form = {"name": "mes", "password": PASSWORD, "next": "/runs", "csrf_token": token}
    assert client.post("/login", data=form).status_code == 302
    assert client.post("/api/v1/orders", json=ORDER).status_code == 400
    assert client.post("/logout").status_code == 400
    assert orders.listed(home) == []


@pytest.mark.parametrize(
    ("changes", "sentences"),
    [
        ({"number": None}, ["number is missing"]),
        ({"units": [{"serial": "", "colour": 1}], "client_order": {}},
         ["units.0.serial: ", "units.0.colour: ", "client_order.client", "client_order.rec"]),
        ({"station": "NONE"}, ["has no file of station NONE"]),
        ({"procedure": "/etc/own.toml"}, ["there is no procedure '/etc/own.toml'"]),
        ({"units": [{"serial": "S\u0000"}]}, ["units.0.serial"]),
        ({"client_order": "/etc/passwd"}, ["client_order: "]),
    ],
)  # fmt: skip
def test_every_fault_of_an_order_is_named_and_it_is_not_kept(changes, sentences, client, home):
    refused = give(client, ORDER | changes)
    assert refused.status_code == 400
    for sentence in sentences:
        assert sentence in refused.json["error"], sentence
    assert orders.listed(home) == []


def test_openapi_describes_both_ways(client):
    described = client.get("/api/v1/openapi.json", auth=("mes", PASSWORD)).json
    path = described["paths"]["/api/v1/orders"]
    assert set(path["post"]["responses"]) == {"200", "201", "400", "401", "403", "503"}
    for name in ("OrderRequest", "ProductionOrder", "ProductionOrders"):
        assert name in described["components"]["schemas"]
    assert [each["name"] for each in path["get"]["parameters"]] == ["station", "state"]


@pytest.mark.parametrize("serial", ["<b>S1</b>", "../..", ". .", "S1'", "S&1"])
def test_a_serial_number_is_neither_markup_nor_a_path(client, home, serial):
    answer = give(client, ORDER | {"units": [{"serial": serial}]})
    assert answer.status_code == 400
    assert "serial" in answer.json["error"]
    assert orders.listed(home) == []


def test_a_manufacturing_system_has_an_order_carried_out_again_under_its_number(client, home):
    give(client, ORDER)
    document: dict[str, Any] = {"number": "4711", "reason": "clamped anew"}

    def retry(document: dict[str, Any]) -> TestResponse:
        return client.post("/api/v1/retry", json=document, auth=("mes", PASSWORD))

    assert retry(document).status_code == 400  # it waits
    orders.claim("4711", home)
    orders.finish("4711", "failed", home, "it was loose")
    answer = retry(document)
    assert (answer.status_code, answer.json["state"]) == (200, "waiting")
    assert retry({"number": "1"}).status_code == 404
