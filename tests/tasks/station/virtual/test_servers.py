"""The running virtual station as a client finds it: registers, ring, frames, clock, watchdog."""

import socket
import subprocess
import sys
import time

import numpy as np
import pytest
from pymodbus.exceptions import ModbusIOException

from schemas.base import Unusable
from tasks.station.drivers.modbus import host_and_port
from tasks.station.virtual.config import (
    CAPTURE_REGISTERS,
    MODES,
    TABLE_DEVICE,
    TABLE_REGISTERS,
    VirtualStation,
    draw_unit,
    truth,
)
from tasks.station.virtual.faults import StationFault
from tasks.station.virtual.servers import running
from tests.tasks.station.over_sockets import serving

SETTLED, MOVING, WATCHDOG = 4, 2, 64

pytestmark = pytest.mark.real_time


@pytest.fixture(scope="module")
def station():
    with serving(VirtualStation(), 20.0) as found:
        yield found


@pytest.fixture
def console(station, consoles):
    found = consoles(station)
    found.write("command", 1)
    found.write("watchdog", 0)
    found.write("command", 2)
    return found


def block(console, first, count_axes=3):
    """capture_from written and the block read in one exchange."""
    words = console.client.convert_to_registers(first, console.client.DATATYPE.UINT32)
    answer = console.client.readwrite_registers(
        read_address=102, read_count=117, write_address=100, values=words, device_id=TABLE_DEVICE
    )
    assert not answer.isError()
    count = answer.registers[0]
    start = console.client.convert_from_registers(
        answer.registers[1:3], console.client.DATATYPE.UINT32
    )
    raw = np.array(answer.registers[3 : 3 + 2 * count * count_axes], dtype=">u2")
    return start, raw.tobytes(), np.frombuffer(raw.tobytes(), ">i4").reshape(count, count_axes)


def test_the_table_says_what_it_is(console):
    assert console.read("ident") == 0x4D54
    assert console.read("map_version") == 1
    assert console.read("axes") == 3
    assert console.read("capture_period") == 10_000
    assert console.read("counts_per_turn", 2) == 3_600_000


def test_the_whole_map_reads_in_two_requests(console):
    for start, count in ((0, 100), (100, 119)):
        answer = console.client.read_holding_registers(start, count=count, device_id=TABLE_DEVICE)
        assert not answer.isError()
        assert len(answer.registers) == count
    beyond = console.client.read_holding_registers(219, count=1, device_id=TABLE_DEVICE)
    assert beyond.exception_code == 2


def test_an_axis_goes_to_its_angle_and_says_so(console):
    console.go("angle", 1, angle=-45.0, rate=60.0)
    console.until(lambda: console.has(MOVING, 1))
    console.until(lambda: console.has(SETTLED, 1))
    assert console.read("angle", 1) == pytest.approx(-45.0 / 360.0 * 3_600_000, abs=6)
    assert console.read("mode", 1) == MODES["angle"]


def test_a_target_waits_for_the_mode(console):
    console.go("rate", 2, rate=10.0)
    console.write("target_rate", 20.0, 2)
    console.wait(3.0)
    assert console.read("rate", 2) == pytest.approx(10.0, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "value", "axis", "code"),
    [
        ("mode", 7, 0, 3),
        ("acceleration_limit", 0.0, 0, 3),
        ("acceleration_limit", float("nan"), 0, 3),
        ("target_rate", 1e6, 0, 3),
        ("target_angle", float("inf"), 0, 3),
        ("command", 9, None, 3),
        ("angle", 5, 0, 2),
        ("ident", 5, None, 2),
    ],
)
def test_a_write_that_means_nothing_is_refused(console, name, value, axis, code):
    assert console.write(name, value, axis).exception_code == code


def test_a_write_is_taken_whole_or_not_at_all(console):
    client = console.client
    words = client.convert_to_registers(33.0, client.DATATYPE.FLOAT32)
    wrong = client.convert_to_registers(-1.0, client.DATATYPE.FLOAT32)
    before = console.read("target_rate", 0)
    # target_rate and acceleration_limit of axis 0
    answer = client.write_registers(20, words + wrong, device_id=TABLE_DEVICE)
    assert answer.exception_code == 3
    assert client.write_registers(20, words[:1], device_id=TABLE_DEVICE).exception_code == 2
    assert console.read("target_rate", 0) == before


def test_the_chamber_reads_its_air(console):
    assert console.read_chamber("temperature") == pytest.approx(20.0)
    assert console.read_chamber("humidity") == pytest.approx(45.0)
    assert console.client.write_registers(0, [1, 2], device_id=2).exception_code == 2


def test_the_capture_ring_has_no_gaps_and_its_times_are_right(console):
    console.go("rate", 0, rate=36.0)
    console.until(lambda: console.has(SETTLED, 0))
    first = int(console.read("station_time")) // 10_000
    rows, wanted = [], first
    while wanted < first + 300:
        start, _, counts = block(console, wanted)
        assert start == wanted
        assert len(counts) <= 19
        rows.extend(counts[:, 0].tolist())
        wanted += len(counts)
    # 36 °/s are 3600 counts in 10 ms; rounding leaves a count at either end.
    assert set(np.diff(rows)) <= {3599, 3600, 3601}
    answer = console.client.read_holding_registers(0, count=100, device_id=TABLE_DEVICE).registers
    now_us = int.from_bytes(b"".join(word.to_bytes(2, "big") for word in answer[4:8]), "big")
    counts = console.client.convert_from_registers(answer[24:26], console.client.DATATYPE.INT32)
    expected = rows[0] + 3600 * (now_us / 10_000 - first)
    assert counts == pytest.approx(expected, abs=5)


def test_a_sample_that_is_not_yet_there_is_not_given(console):
    ahead = int(console.read("station_time")) // 10_000 + 50_000
    assert len(block(console, ahead)[2]) == 0


def test_frames_come_whole_in_order_and_on_time(station, console, hear, whole):
    received = hear(station, 0.5)
    frames = whole(received)
    assert len(received) // 42 - len(frames) <= 1  # the last may be cut off
    counters = np.array([frame[1] for frame in frames])
    stamps = np.array([frame[2] for frame in frames])
    assert len(frames) > 100
    assert (np.diff(counters) == 1).all()
    np.testing.assert_array_equal(stamps, counters * 10_000)
    # The stamps are near the table's time: both are station time here.
    assert console.read("station_time") >= stamps[-1]


def test_a_map_register_lies_where_no_other_does():
    places = [
        word
        for each in (*TABLE_REGISTERS, *CAPTURE_REGISTERS)
        for word in range(each.address, each.address + each.words)
    ]
    assert len(places) == len(set(places))


def test_the_station_file_says_what_a_certificate_needs(station):
    assert station.station.model_extra["clock_speed"] == 20.0
    assert station.unit.model == "V-MIMU"
    assert all("virtual" in each.name and "虚拟" in each.name_zh for each in station.equipment)


# The virtual station in its own process: it starts, and ends in any case.


def test_the_truth_is_that_of_the_unit():
    true = truth(VirtualStation(unit=draw_unit(8)))
    assert np.array(true["Kg"]) == pytest.approx(np.array(draw_unit(8).gyro.scale))
    assert true["station"]["latitude_deg"] == 39.9


def test_a_station_ends_when_its_starter_dies(tmp_path):
    script = (
        "import os\n"
        "from tasks.station.virtual.config import VirtualStation\n"
        "from tasks.station.virtual.servers import running\n"
        "with running(VirtualStation(), 1.0) as found:\n"
        "    print(found.table.url.rpartition(':')[2], flush=True)\n"
        "    os._exit(3)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    port = int(done.stdout)
    for _ in range(6000):  # five minutes, on a busy machine
        try:
            socket.create_connection(("127.0.0.1", port), timeout=1).close()
        except ConnectionRefusedError:
            return
        time.sleep(0.05)
    raise AssertionError("the station went on without its starter")


def test_a_speed_that_is_none_is_refused_in_one_sentence():
    with pytest.raises(Unusable, match="cannot run at speed 0"), running(VirtualStation(), 0.0):
        pass


def test_a_station_ends_with_its_block_and_quietly_with_clients_on_the_line(consoles, capfd):
    with running(VirtualStation(), 20.0, [StationFault("modbus_silent", 2.0)]) as found:
        host, port = found.unit_link.url.removeprefix("socket://").split(":")
        with socket.create_connection((host, int(port))) as line:
            assert line.recv(42)
            console = consoles(found, timeout=1.0)
            with pytest.raises(ModbusIOException):
                console.wait(5.0)
    assert capfd.readouterr().err == ""
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(host_and_port(found.table.url), timeout=1)
