"""A virtual station with its queue: from orders to drafts, and hands that mount what is ordered."""

import socket
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from flows.orders.production import give, work_at
from schemas.orders import OrderRequest
from storage.catalogue import orders, runs
from storage.home import Home
from tasks.station.virtual.config import MOUNT_REQUEST, VirtualStation, draw_unit
from tests.flows.on_prefect.test_prefect_flows import SHORT
from tests.flows.order_homes import no_workers
from tests.tasks.station.over_sockets import serving

pytestmark = [pytest.mark.real_time, pytest.mark.rehearsal]  # of test_production and test_identity


def mount(url: str, serial: str, seed: int) -> None:
    host, _, port = url.removeprefix("socket://").partition(":")
    with socket.create_connection((host, int(port)), timeout=30.0) as client:
        client.sendall(f"{MOUNT_REQUEST}{serial},{seed}\r\n".encode())
        received = b""
        while f"$MOUNTED,{serial}".encode() not in received:
            received += client.recv(4096)


def hindered(number: str, home: Home) -> str:
    """What keeps an order from beginning, once it says so."""
    while not (fault := orders.find(number, home).fault):
        time.sleep(0.05)
    return fault


def test_the_queue_waits_for_the_unit_that_is_ordered_or_for_the_orders_cancellation(
    home, monkeypatch, unprinted
):
    no_workers(monkeypatch)
    place, hindrances = Home(home), {}
    (home / "stations").mkdir(parents=True)
    procedure = home / "short.toml"
    procedure.write_text(SHORT, encoding="utf-8")
    config = VirtualStation(unit=draw_unit(7).model_copy(update={"label": "U-1"}))
    with serving(config, 8.0) as station, ThreadPoolExecutor(1) as operator:
        (home / "stations" / "one.json").write_text(station.model_dump_json())
        for serial in ("U-1", "U-2", "U-3"):
            request = {
                "station": "VIRTUAL-1",
                "units": [{"serial": serial}],
                "procedure": str(procedure),
                "number": serial,
            }
            give(OrderRequest.model_validate(request), "Li", place)

        def operate() -> None:
            hindrances["U-2"] = hindered("U-2", place)
            mount(station.unit_link.url, "U-2", 31)
            hindrances["U-3"] = hindered("U-3", place)
            orders.cancel("U-3", "Li", place)

        operated = operator.submit(operate)
        assert work_at("VIRTUAL-1", place, lambda order: None)
        operated.result()
    first, second, last = orders.listed(place)
    for order in (first, second):  # on a busy computer a station of eight times the speed is late
        assert order.state == "done" or "clocks of unit and table" in str(order.fault)
    assert "says that it is U-1, and the run is ordered for U-2: mount U-2" in hindrances["U-2"]
    assert "mount U-3" in hindrances["U-3"]
    assert (last.state, last.runs) == ("cancelled", ())
    kept = {run.id: run.serial for run in runs.all_runs(place)}
    assert [kept[order.runs[0]] for order in (first, second)] == ["U-1", "U-2"]
    drafts = [key for order in (first, second) for key in order.certificates]
    assert len(set(drafts)) == sum(order.state == "done" for order in (first, second))
