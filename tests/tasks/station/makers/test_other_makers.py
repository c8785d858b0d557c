"""The shipped stations of other makers, driven from end to end by their files alone."""

import random
import socket
import socketserver
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np
import pytest

from schemas.procedure import Procedure
from schemas.station import StationFile
from tasks.station.acquisition import Acquired
from tasks.station.check_devices import check_station
from tests.tasks.station.makers import modbus_maker, text_maker
from tests.tasks.station.over_sockets import over_sockets
from tests.tasks.station.sample_stations import sample

pytestmark = pytest.mark.real_time
RATE_HZ = 100


@pytest.fixture
def brisk(short) -> Procedure:
    """The short procedure for a table that is not simulated faster than wall time."""
    steps = [step.model_dump() | {"dwell_s": 0.5} for step in short.steps]
    changes = {"steps": steps, "warm_up_s": 0.2, "settle_s": 0.1, "move_rate_deg_s": 400.0}
    return Procedure.model_validate(short.model_dump() | changes | {"acceleration_deg_s2": 4000.0})


@contextmanager
def sending(line_of: Callable[[int], str], send: Callable[[bytes], Any]) -> Iterator[None]:
    """Lines of a unit at RATE_HZ of wall time, for the length of the block."""
    done = threading.Event()

    def work() -> None:
        began_s = time.monotonic()
        for number in range(10**9):
            time.sleep(max(began_s + number / RATE_HZ - time.monotonic(), 0.0))
            if done.is_set():
                return
            send(line_of(number).encode())

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def csv_line(number: int) -> str:
    noise = [random.gauss(0.0, 0.01) for _ in range(3)]
    return (
        f"{number};{number * 10};" + ";".join(f"{each:.6f}" for each in (*noise, 0, 0, 1)) + "\r\n"
    )


def vn_line(number: int) -> str:
    gyro = ",".join(f"{random.gauss(0.0, 1e-3):+09.6f}" for _ in range(3))
    body = f"VNIMU,+01.0,-00.2,+00.3,+00.100,-00.200,-09.801,{gyro},+21.5,+101.25"
    check = 0
    for octet in body.encode():
        check ^= octet
    return f"${body}*{check:02X}\r\n"


def port_of(server: socketserver.TCPServer) -> int:
    return int(server.server_address[1])


def acquired(fields: dict[str, Any], procedure: Procedure, sink: Any) -> Acquired:
    station = StationFile.model_validate(fields)
    return over_sockets(station, procedure, sink)


def check(run: Acquired, sink: Any, environment: list[str]) -> None:
    """Every segment is there, and the table did what it was asked."""
    table, segments = sink.stream("table"), run.manifest.segments
    late_s = 2 * run.manifest.model_extra["table_time"]["half_width_s"]  # of a busy computer
    measured = [segment for segment in segments if segment.kind in ("static", "rate")]
    assert len(measured) == 4
    for segment in measured:
        rows = table.rows(segment.t_start, segment.t_end)
        outer, t = table.columns["outer_angle"][rows], table.t[rows]
        slope = np.degrees(np.polyfit(t - t[0], outer, 1)[0])
        rate = segment.rate_deg_s or 0.0
        assert slope == pytest.approx(rate, abs=3.0 + abs(rate) * late_s / np.ptp(t))
    assert list(sink.stream("environment").columns) == environment
    assert run.bad_frames == 0
    assert np.diff(sink.stream("imu").t).min() > 0


@pytest.mark.parametrize(
    "line",
    [
        *(pytest.param(one, marks=pytest.mark.rehearsal) for one in ("tcp", "serial")),
        "rtu through tcp",
    ],
)
def test_a_modbus_table_laid_out_otherwise_runs_a_procedure(brisk, kept, line):
    maker, fields = modbus_maker.ModbusMaker(), sample("modbus_polled")
    if line == "rtu through tcp":
        server = modbus_maker.over_tcp_as_rtu(maker)
        fields["table"]["framing"] = fields["chamber"]["framing"] = "rtu"
    else:
        server = modbus_maker.over_tcp(maker)
    url, hang_up = f"socket://127.0.0.1:{port_of(server)}", lambda: None
    if line == "serial":
        url, hang_up = modbus_maker.over_serial(maker)
    fields["table"]["url"] = fields["chamber"]["url"] = url
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        to = free.getsockname()
    fields["unit_link"]["url"] = f"udp://127.0.0.1:{to[1]}"
    outward = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        with outward, sending(csv_line, lambda data: outward.sendto(data, to)):
            run = acquired(fields, brisk, kept)
    finally:
        server.shutdown()
        server.server_close()
        hang_up()
    check(run, kept, ["temperature", "humidity", "supply_voltage"])
    assert maker.refused == []
    assert not maker.is_on
    assert all(drive.rate == 0 for drive in maker.drives)
    table_time = run.manifest.model_extra["table_time"]
    assert table_time["encoder"] == "polled"
    assert 0 < table_time["half_width_s"] < 1.0


def test_a_text_table_with_a_unit_of_vnimu_lines_runs_a_procedure(brisk, kept):
    maker, fields = text_maker.TextMaker(), sample("text_table")
    clients: list[Any] = []

    class Unit(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            clients.append(self.request)
            ended.wait()

    ended = threading.Event()
    servers = [text_maker.over_tcp(maker), text_maker.thermometer(), modbus_maker.listening(Unit)]
    for device, server in zip(("table", "chamber", "unit_link"), servers, strict=True):
        fields[device]["url"] = f"socket://127.0.0.1:{port_of(server)}"

    def send(data: bytes) -> None:
        for client in clients:
            with suppress(OSError):  # hung up, at the end of the run
                client.sendall(data)

    try:
        with sending(vn_line, send):
            run = acquired(fields, brisk, kept)
    finally:
        ended.set()
        for server in servers:
            server.shutdown()
            server.server_close()
    check(run, kept, ["temperature", "humidity"])
    assert maker.refused == []
    assert all(drive.rate == 0 for drive in maker.drives.values())


def test_a_station_is_checked_device_by_device_and_a_small_move_comes_back():
    maker, fields = text_maker.TextMaker(), sample("text_table")
    servers = [text_maker.over_tcp(maker), text_maker.thermometer()]
    fields["table"]["url"] = f"socket://127.0.0.1:{port_of(servers[0])}"
    fields["chamber"]["url"] = f"socket://127.0.0.1:{port_of(servers[1])}"
    fields["unit_link"]["url"] = "socket://127.0.0.1:1"
    fields["limits"] = {"axes": {"inner": {"angle_deg": [-90.0, 0.5]}}}
    try:
        trials = check_station(StationFile.model_validate(fields), move=True)
    finally:
        for server in servers:
            server.shutdown()
            server.server_close()
    works = {(trial.device, trial.tried): trial.works for trial in trials}
    assert works.pop(("unit", "samples")) is False
    assert works.pop(("table", "move inner"))
    assert len(works) == 7, trials
    assert all(works.values())
    assert "cannot be opened" in trials[-1].found.en
    assert [round(maker.drives[axis].angle, 3) for axis in "ABC"] == [0.0, 0.0, 0.0]
    assert maker.refused == []
    assert not maker.is_on
