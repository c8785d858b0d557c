"""A virtual station with its queue: from orders to drafts, with another unit mounted in between."""

import socket
from pathlib import Path

import pytest

from flows.orders.order_queue import give
from flows.orders.production import work_at
from schemas.production import OrderRequest, ProductionOrder
from storage.catalogue import orders, run_index
from storage.home import Home
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.protocol import MOUNT_REQUEST
from tasks.station.virtual.unit import draw_unit
from tests.flows.on_prefect.test_prefect_flows import SHORT
from tests.flows.order_homes import no_workers
from tests.tasks.station.in_thread import serving

pytestmark = pytest.mark.real_time


def mount(url: str, serial: str, seed: int) -> None:
    host, _, port = url.removeprefix("socket://").partition(":")
    with socket.create_connection((host, int(port)), timeout=30.0) as client:
        client.sendall(f"{MOUNT_REQUEST}{serial},{seed}\r\n".encode())
        received = b""
        while f"$MOUNTED,{serial}".encode() not in received:
            received += client.recv(4096)


def test_each_unit_of_the_queue_has_its_draft_and_one_that_is_not_mounted_has_none(
    home: Path, monkeypatch: pytest.MonkeyPatch, unprinted
) -> None:
    no_workers(monkeypatch)
    (home / "stations").mkdir(parents=True)
    procedure = home / "short.toml"
    procedure.write_text(SHORT, encoding="utf-8")
    config = VirtualStation(unit=draw_unit(7).model_copy(update={"label": "U-1"}))
    with serving(config, 20.0) as station:
        (home / "stations" / "one.json").write_text(station.model_dump_json())
        for serial in ("U-1", "U-2", "U-3"):
            request = {
                "station": "VIRTUAL-1",
                "units": [{"serial": serial}],
                "procedure": str(procedure),
                "number": serial,
            }
            give(OrderRequest.model_validate(request), "Li", Home(home))

        def change(order: ProductionOrder) -> None:
            if order.number == "U-2":  # which nobody mounted
                mount(station.unit_link.url, "U-3", 31)

        assert work_at("VIRTUAL-1", Home(home), change)
    first, wrong, last = orders.listed(Home(home))
    assert [order.state for order in (first, wrong, last)] == ["done", "failed", "done"]
    assert "says that it is U-1, and the run is ordered for U-2" in str(wrong.fault)
    assert wrong.runs == ()
    kept = {run.id: run.serial for run in run_index.all_runs(Home(home))}
    assert [kept[order.runs[0]] for order in (first, last)] == ["U-1", "U-3"]
    assert len({*first.certificates, *last.certificates}) == 2
