"""A real client for the virtual station: pymodbus, by the register map."""

import binascii
import struct
import time
from collections.abc import Callable, Iterator

import pytest
import serial
from pymodbus.client import ModbusTcpClient

from schemas.station import (
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
    StationFile,
)

TABLE = {each.name: each for each in (*TABLE_REGISTERS, *CAPTURE_REGISTERS)}
AXIS = {each.name: each for each in AXIS_REGISTERS}
CHAMBER = {each.name: each for each in CHAMBER_REGISTERS}


class Console:
    """Reads and writes registers by name; axis None means the table itself."""

    def __init__(self, station: StationFile) -> None:
        self.client = ModbusTcpClient(
            station.modbus_host, port=station.modbus_port, timeout=1, retries=0
        )
        self.client.connect()

    def _place(self, name: str, axis: int | None) -> tuple[int, Register]:
        register = TABLE[name] if axis is None else AXIS[name]
        return register.address + (0 if axis is None else AXIS_BASE + AXIS_STRIDE * axis), register

    def read(self, name: str, axis: int | None = None) -> float:
        address, register = self._place(name, axis)
        return self._read(TABLE_DEVICE, address, register)

    def read_chamber(self, name: str) -> float:
        return self._read(CHAMBER_DEVICE, CHAMBER[name].address, CHAMBER[name])

    def _read(self, device: int, address: int, register: Register) -> float:
        answer = self.client.read_holding_registers(address, count=register.words, device_id=device)
        assert not answer.isError()
        kind = self.client.DATATYPE[register.type.upper()]
        return self.client.convert_from_registers(answer.registers, kind)

    def write(self, name: str, value: float, axis: int | None = None):
        address, register = self._place(name, axis)
        words = self.client.convert_to_registers(value, self.client.DATATYPE[register.type.upper()])
        return self.client.write_registers(address, words, device_id=TABLE_DEVICE)

    def go(self, mode: str, axis: int, angle: float = 0.0, rate: float = 100.0) -> None:
        for name, value in (("target_angle", angle), ("target_rate", rate)):
            assert not self.write(name, value, axis).isError()
        assert not self.write("mode", MODES[mode], axis).isError()

    def until(self, holds: Callable[[], bool]) -> None:
        for _ in range(20_000):
            if holds():
                return
        raise AssertionError("it did not come about")

    def wait(self, seconds: float) -> None:
        """Station time, as the table says it."""
        start = self.read("station_time")
        self.until(lambda: self.read("station_time") >= start + seconds * 1e6)

    def has(self, bit: int, axis: int | None = None) -> bool:
        return bool(int(self.read("status", axis)) & bit)


@pytest.fixture
def consoles() -> Iterator[Callable[[StationFile], Console]]:
    opened: list[Console] = []

    def connect(station: StationFile) -> Console:
        opened.append(Console(station))
        return opened[-1]

    yield connect
    for console in opened:
        console.client.close()


FRAME = struct.Struct("<HIQ3i3ihH")  # written here once more, to judge what comes


def frames_heard(station: StationFile, seconds: float) -> bytes:
    """What comes over the unit's line for a while of wall time."""
    line = serial.serial_for_url(station.unit_link.url, timeout=0.05)
    try:
        end = time.monotonic() + seconds
        heard = b""
        while time.monotonic() < end:
            heard += line.read(42)
        return heard
    finally:
        line.close()


def whole_frames(heard: bytes) -> list[tuple[int, ...]]:
    """Fields of the frames whose check holds, in order."""
    found, at = [], 0
    while at + FRAME.size <= len(heard):
        fields = FRAME.unpack_from(heard, at)
        if fields[0] == 0x55AA and binascii.crc_hqx(heard[at : at + 40], 0) == fields[-1]:
            found.append(fields)
            at += FRAME.size
        else:
            at += 1
    return found


@pytest.fixture
def hear() -> Callable[[StationFile, float], bytes]:
    return frames_heard


@pytest.fixture
def whole() -> Callable[[bytes], list[tuple[int, ...]]]:
    return whole_frames
