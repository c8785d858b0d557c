"""The virtual station in its own process: it starts, and ends in any case."""

import socket
import subprocess
import sys
import time

import numpy as np
import pytest
from pymodbus.exceptions import ModbusIOException

from schemas.base import Unusable
from tasks.station.drivers.modbus import host_and_port
from tasks.station.virtual.config import VirtualStation, truth
from tasks.station.virtual.faults import StationFault
from tasks.station.virtual.process import running
from tasks.station.virtual.unit import draw_unit

pytestmark = pytest.mark.real_time


def test_the_truth_is_that_of_the_unit():
    true = truth(VirtualStation(unit=draw_unit(8)))
    assert np.array(true["Kg"]) == pytest.approx(np.array(draw_unit(8).gyro.scale))
    assert true["station"]["latitude_deg"] == 39.9


def test_a_station_ends_when_its_starter_dies(tmp_path):
    script = (
        "import os\n"
        "from tasks.station.virtual.config import VirtualStation\n"
        "from tasks.station.virtual.process import running\n"
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
