"""The unit that is mounted is the one that is ordered, or nothing turns."""

import socket

import pytest

from schemas.base import Unusable
from schemas.recording import Unit
from schemas.station import StationFile
from schemas.unit_link import SerialQuery, UnitLink
from tasks.station.check_devices import check_station
from tasks.station.drivers import backend
from tasks.station.drivers.backend import confirm
from tasks.station.virtual.config import (
    MOUNT_REQUEST,
    REFUSAL,
    VirtualStation,
    draw_unit,
    virtual_station,
)
from tests.tasks.station.over_sockets import over_sockets, serving, table_and_watchdog
from tests.tasks.station.over_sockets import unit as listening
from tests.tasks.station.sample_stations import rates_link

QUERY = SerialQuery(request="$WHO", answer="$ME,")
pytestmark = pytest.mark.real_time


def link(url: str) -> UnitLink:
    return rates_link().model_copy(update={"url": url, "identify": QUERY})


def unit(serial: str) -> Unit:
    return Unit(manufacturer="Example", model="MIMU", serial=serial)


def ask(station: StationFile, line: str) -> str:
    """What the virtual unit answers, among its frames."""
    host, _, port = station.unit_link.url.removeprefix("socket://").partition(":")
    with socket.create_connection((host, int(port)), timeout=10.0) as client:
        client.sendall(f"{line}\r\n".encode())
        received = b""
        while b"\r\n" not in received.partition(b"$")[2]:
            received += client.recv(4096)
    return "$" + received.partition(b"$")[2].partition(b"\r\n")[0].decode()


@pytest.mark.parametrize("end", [b"\r\n", b"*5A\r\n", b",1.2\n"])
def test_a_unit_that_tells_the_ordered_number_is_confirmed_among_its_frames(end):
    with listening(lambda _: b"$ME,A-17 b" + end) as (url, lines):
        assert confirm(unit("A-17 b"), link(url)) == "A-17 b"
        assert lines[0] == b"$WHO\r\n"


def test_another_unit_is_refused_with_both_numbers_and_the_way_out():
    with listening(lambda _: b"$ME,A18\r\n") as (url, _):
        sentence = "says that it is A18, and the run is ordered for A17: mount A17, or order A18"
        with pytest.raises(Unusable, match=sentence):
            confirm(unit("A17"), link(url))


def test_a_unit_that_does_not_answer_is_not_taken_for_the_ordered_one(monkeypatch):
    monkeypatch.setattr(backend, "ANSWER_S", 0.3)
    sentence = "did not tell its serial number: “\\$WHO” was not"
    with (
        listening(lambda _: b"$YOU,A17\r\n") as (url, _),
        pytest.raises(Unusable, match=sentence),
    ):
        confirm(unit("A17"), link(url))


def test_nothing_turns_for_another_unit_than_the_one_that_is_mounted(short, kept):
    with serving(VirtualStation(unit=draw_unit(7)), 20.0) as station:
        ordered = station.with_units((station.unit.model_copy(update={"serial": "V99999"}),))
        with pytest.raises(Unusable, match="says that it is V00007, and the run is ordered for"):
            over_sockets(ordered, short, kept)
        state, _ = table_and_watchdog(station)
        assert kept.manifests == []
        assert [axis.angle_deg for axis in state.axes] == [0.0, 0.0, 0.0]


@pytest.mark.rehearsal
def test_the_operator_of_the_virtual_station_mounts_another_unit(short, kept):
    with serving(VirtualStation(unit=draw_unit(7)), 20.0) as station:
        assert ask(station, "$SERIAL?") == "$SERIAL,V00007"
        assert ask(station, f"{MOUNT_REQUEST}U-1,x").startswith(REFUSAL)
        assert ask(station, f"{MOUNT_REQUEST}U-1,31") == "$MOUNTED,U-1"
        assert ask(station, "$SERIAL?") == "$SERIAL,U-1"
        unit_ = station.unit.model_copy(update={"serial": "U-1"})
        acquired = over_sockets(station.with_units((unit_,)), short, kept)
        assert acquired.manifest.unit.serial == "U-1"
        (found,) = [t.found.en for t in check_station(station, False) if t.tried == "serial"]
        assert found == "The unit says that it is U-1; the station file names V00007."


@pytest.mark.rehearsal
def test_two_virtual_stations_are_two_stations(tmp_path):
    for ahrs in (False, True):
        made = virtual_station(1, ahrs).model_copy(update={"id": None})
        with serving(made, 20.0) as one, serving(made, 20.0) as other:
            ids = {one.station.id, other.station.id}
            serials = {each.serial for found in (one, other) for each in found.equipment}
            assert len(ids) == 2
            assert len(serials) == 2 * len(one.equipment)
            assert all(name.startswith("VIRTUAL-") for name in ids)
