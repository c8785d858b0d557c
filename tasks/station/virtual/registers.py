"""The register map over the virtual table, chamber and fixture: values read, writes applied."""

import math
import struct
from collections.abc import Iterable, Mapping

import numpy as np

from schemas.station import (
    AXIS_BASE,
    AXIS_REGISTERS,
    AXIS_STRIDE,
    CAPTURE_REGISTERS,
    CAPTURE_VALUES,
    CHAMBER_REGISTERS,
    COMMANDS,
    FIXTURE_REGISTERS,
    MAP_VERSION,
    MODES,
    TABLE_IDENT,
    TABLE_REGISTERS,
    Register,
)
from tasks.station.virtual.config import STEP_US
from tasks.station.virtual.simulation import Simulation
from tasks.station.virtual.table import DEGREE

TABLE_WORDS = CAPTURE_REGISTERS[-1].address + 2 * CAPTURE_VALUES
CHAMBER_WORDS = CHAMBER_REGISTERS[-1].address + CHAMBER_REGISTERS[-1].words
FIXTURE_WORDS = FIXTURE_REGISTERS[-1].address + FIXTURE_REGISTERS[-1].words
ATTITUDE = ("qw", "qx", "qy", "qz")
MIN_NORM_SQUARED = 0.1  # a quaternion below it is no attitude
CODES = {"uint16": ">H", "uint32": ">I", "int32": ">i", "uint64": ">Q", "float32": ">f"}

Value = float | int
# Address of the first word, the register, its axis (None for the table itself), in map order.
Place = tuple[int, Register, int | None]


def to_words(register: Register, value: Value) -> list[int]:
    """A value as words, high word first; counts turn over at the size of the register."""
    code = CODES[register.type]
    if register.type == "int32":
        value = (int(value) + 2**31) % 2**32 - 2**31
    data = struct.pack(code, value if register.type == "float32" else int(value))
    return list(struct.unpack(f">{register.words}H", data))


def from_words(register: Register, words: list[int]) -> Value:
    """The value in the words of a register."""
    value: Value = struct.unpack(CODES[register.type], struct.pack(f">{register.words}H", *words))[
        0
    ]
    return value


class Refused(Exception):  # noqa: N818 (the controller refuses; the server answers with a code)
    """A write that the controller does not take."""


class BadAddress(Refused):
    """To a register that is not writable, or only to a part of one."""


class BadValue(Refused):
    """Of a value that means nothing here."""


def writes(
    known: Iterable[Place], address: int, words: list[int]
) -> Iterable[tuple[Register, int | None, Value]]:
    """The values that words from an address on write to the known places; raises BadAddress."""
    places = {start: (register, axis) for start, register, axis in known}
    offset = 0
    while offset < len(words):
        register, axis = places.get(address + offset, (None, None))
        end = offset + (register.words if register else 0)
        if register is None or not register.writable or end > len(words):
            raise BadAddress
        yield register, axis, from_words(register, words[offset:end])
        offset = end


class TableRegisters:
    """Device 1."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._table = simulation.table
        self.watchdog_ms = 0
        self._capture_from = 0
        axes = range(len(simulation.table.drives))
        self._places: tuple[Place, ...] = (
            *((register.address, register, None) for register in TABLE_REGISTERS),
            *((AXIS_BASE + AXIS_STRIDE * axis + register.address, register, axis)
              for axis in axes for register in AXIS_REGISTERS),
            *((register.address, register, None) for register in CAPTURE_REGISTERS[:-1]),
        )  # fmt: skip

    def words(self) -> list[int]:
        """All words of the device as they are now."""
        image = [0] * TABLE_WORDS
        groups: dict[int | None, Mapping[str, Value]] = {
            axis: self._axis(axis) for axis in range(len(self._table.drives))
        }
        first, counts = self._block()
        groups[None] = self._head() | {
            "capture_from": self._capture_from,
            "capture_count": len(counts),
            "capture_first": first,
        }
        for address, register, axis in self._places:
            value = groups[axis][register.name]
            image[address : address + register.words] = to_words(register, value)
        samples = counts.astype(">i4").tobytes()
        start = CAPTURE_REGISTERS[-1].address
        image[start : start + len(samples) // 2] = np.frombuffer(samples, ">u2").tolist()
        return image

    def _head(self) -> dict[str, Value]:
        return {
            "ident": TABLE_IDENT,
            "map_version": MAP_VERSION,
            "axes": len(self._table.drives),
            "status": self._table.status(),
            "station_time": self._table.steps * STEP_US,
            "watchdog": self.watchdog_ms,
            "command": 0,
            "capture_period": self._table.design.capture_ms * 1000,
        }

    def _axis(self, axis: int) -> dict[str, Value]:
        drive = self._table.drives[axis]
        return {
            "mode": drive.mode,
            "status": self._table.axis_status(axis),
            "target_angle": drive.target_angle / DEGREE,
            "target_rate": drive.target_rate / DEGREE,
            "acceleration_limit": drive.acceleration / DEGREE,
            "angle": int(self._table.counts(self._table.angle[axis])),
            "rate": self._table.rate[axis] / DEGREE,
            "counts_per_turn": self._table.design.counts_per_turn,
        }

    def _block(self) -> tuple[int, np.ndarray]:
        return self._table.capture(self._capture_from, CAPTURE_VALUES // len(self._table.drives))

    def write(self, address: int, words: list[int]) -> None:
        """Takes words from an address on: whole writable registers, each with a sane value.

        Raises BadAddress or BadValue, and then nothing has changed. A mode is taken last, so
        that it goes toward the targets of the same write.
        """
        taken = list(writes(self._places, address, words))
        for register, axis, value in taken:
            self._check(register.name, axis, value)
        for register, axis, value in sorted(taken, key=lambda write: write[0].name == "mode"):
            if axis is None:
                self._take(register.name, int(value))
            else:
                self._take_axis(register.name, axis, value)

    def _check(self, name: str, axis: int | None, value: Value) -> None:
        design = self._table.design
        sane = {
            "command": value in COMMANDS.values(),
            "mode": value in MODES.values(),
            "target_rate": abs(value) <= design.most_rate_deg_s,
            "acceleration_limit": 0 < value <= design.most_acceleration_deg_s2,
        }
        if not math.isfinite(value) or not sane.get(name, True):
            raise BadValue

    def _take(self, name: str, value: int) -> None:
        if name == "watchdog":
            self.watchdog_ms = value
        elif name == "capture_from":
            self._capture_from = value
        elif value == COMMANDS["reset"]:
            self._table.reset()
        else:
            self._table.stop()

    def _take_axis(self, name: str, axis: int, value: Value) -> None:
        if name == "mode":
            self._table.command(axis, int(value))
            return
        fields = {"acceleration_limit": "acceleration"}
        setattr(self._table.drives[axis], fields.get(name, name), value * DEGREE)


class ChamberRegisters:
    """Device 2."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation

    def words(self) -> list[int]:
        """All words of the device as they are now."""
        air = self._simulation.config.air
        return _image(
            CHAMBER_REGISTERS,
            {
                "temperature": self._simulation.air_degc,
                "humidity": air.humidity_percent,
                "supply_voltage": air.supply_v,
                "pressure": air.pressure_hpa,
                "station_time": self._simulation.table.steps * STEP_US,
            },
        )

    def write(self, address: int, words: list[int]) -> None:
        """Takes nothing."""
        raise BadAddress


class FixtureRegisters:
    """Device 3: the fixture and the unit's supply."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation

    def words(self) -> list[int]:
        """All words of the device as they are now."""
        simulation = self._simulation
        values: dict[str, Value] = dict(zip(ATTITUDE, simulation.fixture.wanted, strict=True))
        values |= {
            "turn": 0,
            "status": simulation.fixture.status(simulation.table.now),
            "supply": int(simulation.is_supplied),
            "supply_on_time": simulation.supplied_steps * STEP_US,
        }
        return _image(FIXTURE_REGISTERS, values)

    def write(self, address: int, words: list[int]) -> None:
        """Takes words from an address on; raises BadAddress or BadValue as the table does."""
        places = ((register.address, register, None) for register in FIXTURE_REGISTERS)
        taken = [(register.name, value) for register, _, value in writes(places, address, words)]
        for name, value in taken:
            if not (abs(value) <= 1.0 if name in ATTITUDE else value in (0, 1)):
                raise BadValue
        for name, value in taken:
            self._take(name, value)

    def _take(self, name: str, value: Value) -> None:
        simulation = self._simulation
        if name in ATTITUDE:
            simulation.fixture.wanted[ATTITUDE.index(name)] = value
        elif name == "supply":
            simulation.supply(bool(value))
        elif value:
            if (simulation.fixture.wanted**2).sum() < MIN_NORM_SQUARED:
                raise BadValue
            simulation.turn_fixture()


def _image(registers: Iterable[Register], values: Mapping[str, Value]) -> list[int]:
    """The words of neighbouring registers with their values."""
    return [word for register in registers for word in to_words(register, values[register.name])]
