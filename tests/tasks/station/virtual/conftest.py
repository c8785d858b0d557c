"""Clients for the virtual station, by the register map: over pymodbus, and in memory."""

import binascii
import struct
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import serial
from pymodbus.client import ModbusTcpClient
from pymodbus.client.mixin import ModbusClientMixin as Mixin

from schemas.station import StationFile
from tasks.station.drivers.modbus import host_and_port
from tasks.station.virtual.config import (
    AXIS_BASE,
    AXIS_REGISTERS,
    AXIS_STRIDE,
    CAPTURE_REGISTERS,
    CHAMBER_DEVICE,
    CHAMBER_REGISTERS,
    MODES,
    TABLE_DEVICE,
    TABLE_REGISTERS,
    Register,
    VirtualStation,
)
from tasks.station.virtual.faults import StationFault
from tasks.station.virtual.registers import ChamberRegisters, TableRegisters
from tasks.station.virtual.simulation import Simulation

TABLE = {each.name: each for each in (*TABLE_REGISTERS, *CAPTURE_REGISTERS)}
AXIS = {each.name: each for each in AXIS_REGISTERS}
CHAMBER = {each.name: each for each in CHAMBER_REGISTERS}


class Console:
    """Reads and writes registers by name; axis None means the table itself."""

    def words(self, device: int, address: int, count: int) -> list[int]:
        raise NotImplementedError

    def write_words(self, address: int, words: list[int]) -> Any:
        raise NotImplementedError

    def tick(self) -> None:
        """What happens between two looks."""

    def _place(self, name: str, axis: int | None) -> tuple[int, Register]:
        register = TABLE[name] if axis is None else AXIS[name]
        return register.address + (0 if axis is None else AXIS_BASE + AXIS_STRIDE * axis), register

    def read(self, name: str, axis: int | None = None) -> float:
        return self._read(TABLE_DEVICE, *self._place(name, axis))

    def read_chamber(self, name: str) -> float:
        return self._read(CHAMBER_DEVICE, CHAMBER[name].address, CHAMBER[name])

    def _read(self, device: int, address: int, register: Register) -> float:
        words = self.words(device, address, register.words)
        return Mixin.convert_from_registers(words, Mixin.DATATYPE[register.type.upper()])

    def write(self, name: str, value: float, axis: int | None = None) -> Any:
        address, register = self._place(name, axis)
        kind = Mixin.DATATYPE[register.type.upper()]
        return self.write_words(address, Mixin.convert_to_registers(value, kind))

    def go(self, mode: str, axis: int, angle: float = 0.0, rate: float = 100.0) -> None:
        self.write("target_angle", angle, axis)
        self.write("target_rate", rate, axis)
        self.write("mode", MODES[mode], axis)

    def until(self, holds: Callable[[], bool]) -> None:
        for _ in range(20_000):
            if holds():
                return
            self.tick()
        raise AssertionError("it did not come about")

    def wait(self, seconds: float) -> None:
        """Station time, as the table says it."""
        start = self.read("station_time")
        self.until(lambda: self.read("station_time") >= start + seconds * 1e6)

    def has(self, bit: int, axis: int | None = None) -> bool:
        return bool(int(self.read("status", axis)) & bit)


class SocketConsole(Console):
    """A real client, of a station in another process."""

    def __init__(self, station: StationFile, timeout: float) -> None:
        host, port = host_and_port(station.table.url) or ("", 0)
        self.client = ModbusTcpClient(host, port=port, timeout=timeout, retries=0)
        self.client.connect()

    def words(self, device: int, address: int, count: int) -> list[int]:
        answer = self.client.read_holding_registers(address, count=count, device_id=device)
        assert not answer.isError()
        return answer.registers

    def write_words(self, address: int, words: list[int]) -> Any:
        return self.client.write_registers(address, words, device_id=TABLE_DEVICE)


class InMemoryConsole(Console):
    """The registers of a station in this process, whose time passes by 10 ms from look to look."""

    def __init__(self, *faults: StationFault) -> None:
        self.simulation = Simulation(VirtualStation(), faults)
        self.sent = [*self.simulation.advance(1)]  # the unit's frames so far
        self._devices = {
            TABLE_DEVICE: TableRegisters(self.simulation),
            CHAMBER_DEVICE: ChamberRegisters(self.simulation),
        }

    def words(self, device: int, address: int, count: int) -> list[int]:
        return self._devices[device].words()[address : address + count]

    def write_words(self, address: int, words: list[int]) -> None:
        self._devices[TABLE_DEVICE].write(address, words)

    def tick(self) -> None:
        self.sent += self.simulation.advance(10)

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds * 10)):
            self.sent += self.simulation.advance(100)


@pytest.fixture
def consoles() -> Iterator[Callable[..., SocketConsole]]:
    opened: list[SocketConsole] = []

    def connect(station: StationFile, timeout: float = 60.0) -> SocketConsole:
        opened.append(SocketConsole(station, timeout))
        return opened[-1]

    yield connect
    for console in opened:
        console.client.close()


@pytest.fixture
def in_memory() -> Callable[[str], InMemoryConsole]:
    return lambda fault: InMemoryConsole(StationFault.parse(fault))


FRAME = struct.Struct("<HIQ3i3ihH")  # written here once more, to judge what comes


def frames_received(station: StationFile, seconds: float) -> bytes:
    """What comes over the unit's line for a while of wall time."""
    line = serial.serial_for_url(station.unit_link.url, timeout=0.05)
    try:
        end = time.monotonic() + seconds
        received = b""
        while time.monotonic() < end:
            received += line.read(42)
        return received
    finally:
        line.close()


def whole_frames(received: bytes) -> list[tuple[int, ...]]:
    """Fields of the frames whose check holds, in order."""
    found, at = [], 0
    while at + FRAME.size <= len(received):
        fields = FRAME.unpack_from(received, at)
        if fields[0] == 0x55AA and binascii.crc_hqx(received[at : at + 40], 0) == fields[-1]:
            found.append(fields)
            at += FRAME.size
        else:
            at += 1
    return found


@pytest.fixture
def hear() -> Callable[[StationFile, float], bytes]:
    return frames_received


@pytest.fixture
def whole() -> Callable[[bytes], list[tuple[int, ...]]]:
    return whole_frames
