"""`mimucal order …`, and about which axes the certificate of an order is."""

import io
import json

import pytest

from flows import execute
from schemas.orders import CalibrateOrder, CertifyOrder
from storage.catalogue import orders, results, runs
from storage.home import Home
from tasks.stages.estimate import how_made
from tests.flows.order_homes import CLIENT, Begun, add_station, no_workers
from tests.own_limits import laboratory_file

# `mimucal order …`: from a form, a file, a scanner; each unit once, and no half of a file.


@pytest.fixture
def begun(home, monkeypatch) -> Begun:
    add_station(home)
    add_station(home, "LINE-2")
    (home / "client-orders").mkdir()
    (home / "client-orders" / "acme.toml").write_text(CLIENT, encoding="utf-8")
    monkeypatch.setenv("MIMUCAL_USER", "Li")
    return no_workers(monkeypatch)


def test_an_order_waits_for_a_worker_of_its_station_and_is_one_however_often_it_is_given(
    mimucal, home, begun
):
    add = ("order", "add", "LINE-1", "--serial", "S7", "--number", "4711", "--client-order",
           home / "client-orders" / "acme.toml", "--json")  # fmt: skip
    first, again = mimucal(*add), mimucal(*add)
    assert (first.json["new"], again.json["new"]) == (["4711"], [])
    (order,) = again.json["orders"]
    assert order == first.json["orders"][0]
    names = ("manufacturer", "model", "serial")
    assert [order["units"][0][name] for name in names] == ["Example", "MIMU", "S7"]
    assert (order["person"], order["state"]) == ("Li", "waiting")
    assert order["client_order"]["client"]["name"] == "Client"
    assert [command[-3:] for command in begun.commands] == [["station", "work", "LINE-1"]] * 2
    other = mimucal("order", "add", "LINE-2", "--serial", "S7", "--number", "4711")
    assert other.code == 2
    assert "order 4711 is there already" in other.err


def test_without_a_number_a_unit_that_is_in_the_queue_is_not_ordered_again(mimucal, home, begun):
    for _ in range(2):
        assert mimucal("order", "add", "LINE-1", "--serial", "S7").code == 0
    (order,) = orders.listed(Home(home))
    mimucal("order", "cancel", order.number)
    assert mimucal("order", "add", "LINE-1", "--serial", "S7", "--json").json["new"]
    listed = mimucal("order", "list", "--station", "LINE-1", "--json").json
    assert [each["state"] for each in listed["orders"]] == ["cancelled", "waiting"]
    assert (
        mimucal("order", "list", "--state", "cancelled", "--json").json["orders"]
        == (listed["orders"][:1])
    )
    assert "S7" in mimucal("order", "list").out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("NONE", "--serial", "S1"), "has no file of station NONE"),
        (("LINE-1", "--serial", " "), "--serial ' '"),
        (("LINE-1", "--serial", "S1", "--procedure", "none"), "there is no procedure 'none'"),
        (("LINE-1", "--serial", "S1", "--serial", "S2"), "has 1 places, not 2"),
        (("LINE-1", "--serial", "S1", "--client-order", "none.toml"), "none.toml cannot be read"),
        (("LINE-1", "--serial", "S1", "--by", " "), "Say who does it"),
    ],
)
def test_what_cannot_be_carried_out_is_refused_before_it_is_kept(
    arguments, sentence, mimucal, home, begun
):
    refused = mimucal("order", "add", *arguments)
    assert refused.code == 2
    assert sentence in refused.err.replace("--serial: ", "--serial ")
    assert orders.listed(Home(home)) == []
    assert begun.commands == []


def test_what_a_person_at_a_terminal_would_be_asked_is_refused(mimucal, home, begun):
    one_axis = {"table_axes": [{"name": "table", "direction": [0.0, 0.0, 1.0]}]}
    add_station(home, "HAND", fixture="by_hand", station_part=one_axis, limits={})
    refused = mimucal("order", "add", "HAND", "--serial", "S1", "--procedure", "jjf1536_twelve")
    assert refused.code == 2
    assert "terminal" in refused.err
    assert orders.listed(Home(home)) == []


def test_a_file_is_taken_in_whole_with_the_rows_of_a_number_as_one_order(
    mimucal, home, begun, tmp_path
):
    file = tmp_path / "orders.csv"
    file.write_text(
        "\ufeffnumber,station,serial,manufacturer,model,procedure,client_order\n"
        f"1,LINE-1,S1,,,,{home}/client-orders/acme.toml\n"
        '2,LINE-2,"S,2",Other,M 3,jjf2003,\n\n',
        encoding="utf-8",
    )
    taken = mimucal("order", "import", file, "--json")
    assert taken.json["new"] == ["1", "2"]
    first, second = orders.listed(Home(home))
    assert first.client_order is not None
    assert (second.serials, second.units[0].manufacturer, second.units[0].model) == (
        "S,2", "Other", "M 3",
    )  # fmt: skip
    assert mimucal("order", "import", file, "--json").json["new"] == []
    assert len(orders.listed(Home(home))) == 2


def test_every_fault_of_a_file_is_named_by_line_column_and_value_and_nothing_is_taken_in(
    mimucal, home, begun, tmp_path
):
    mimucal("order", "add", "LINE-1", "--serial", "S9", "--number", "9")
    file = tmp_path / "orders.csv"
    rows = ("1,LINE-1,S1,,", "2,NOWHERE,S2,,", "3,LINE-1,,,", "4,LINE-1,S4,none,", "9,LINE-1,S1,,",
            ",LINE-1,S5,,", "6,LINE-1,S6,,none.toml", "1,LINE-1,S7,,")  # fmt: skip
    file.write_text("\n".join(("number,station,serial,procedure,client_order", *rows)))
    refused = mimucal("order", "import", file)
    assert refused.code == 2
    for sentence in (
        "line 3: ", "station NOWHERE", "line 4, column serial",
        "line 5: there is no procedure 'none'",
        "line 6: order 9 is there already", "line 7, column number: '' is empty",
        "line 8, column client_order: ", "column number: '1' is of two orders",
        "faults in", ": 7, orders placed: 0",
    ):  # fmt: skip
        assert sentence in refused.err, sentence
    assert [each.number for each in orders.listed(Home(home))] == ["9"]


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("station,serial\nLINE-1,S1\n", "line 1 has no column 'number'"),
        ("number,station,serial,colour\n", "line 1 has an unknown column 'colour'"),
        ("number,station,serial\n1,LINE-1,S1,S2\n", "line 2 has more fields than line 1"),
        ("", "line 1 has no column 'number'"),
    ],
)
def test_a_file_that_is_no_list_of_orders_is_refused(content, sentence, mimucal, begun, tmp_path):
    file = tmp_path / "orders.csv"
    file.write_text(content)
    refused = mimucal("order", "import", file)
    assert refused.code == 2
    assert sentence in refused.err


def test_each_line_of_a_scanner_is_a_unit_and_a_wrong_one_stops_no_other(
    mimucal, home, begun, monkeypatch
):
    lines = "S1\r\nS1\n\nOther,M3,S2,jjf2003,acme.toml\nS3,S4\nOther,M3,S5,none\nS6\n"
    monkeypatch.setattr("sys.stdin", io.StringIO(lines))
    scanned = mimucal("order", "scan", "LINE-1", "--json")
    assert scanned.code == 2
    assert "'S3,S4' is no order: scan SERIAL" in scanned.err
    assert "there is no procedure 'none'" in scanned.err
    assert "lines that were refused: 2" in scanned.err
    assert [each.serials for each in orders.listed(Home(home))] == ["S1", "S2", "S6"]
    assert orders.listed(Home(home))[1].client_order is not None


# The axes that a client's order names reach the result, the verdict and what is made again.

PARTY = {"name": "C", "name_zh": "客", "address": "a", "address_zh": "址"}
CODE = "mounting_unknown"


@pytest.mark.usefixtures("unprinted")
def test_an_order_decides_about_which_axes_its_certificate_is(home, ideal_run, tmp_path):
    laboratory_file(home)
    place = Home(home)
    run, _ = runs.add(ideal_run(dwell=1.0), place)
    plain = execute.calibrate(CalibrateOrder(run=run.id))
    assert plain.settings["axes"] == "fixture"
    for axes, blocked in (("fixture", False), ("mounting plane", True)):
        order = {"client": PARTY, "received": "2026-05-01", "axes": axes}
        path = tmp_path / "order.json"
        path.write_text(json.dumps(order), encoding="utf-8")
        paper = execute.certify(CertifyOrder(run=run.id, client_order=str(path))).certificate
        made = paper.calibration
        assert made.settings["axes"] == axes
        assert (CODE in {remark.code for remark in made.remarks}) is blocked
        assert how_made(made).axes == axes
    assert len(results.of_run(run, place)) == 2
