"""The registers of the virtual table, chamber and fixture: values read, writes applied."""

import asyncio
import math
from collections.abc import Awaitable, Callable, Iterator, Mapping, Sequence
from contextvars import ContextVar

import numpy as np
from pymodbus.constants import ExcCodes
from pymodbus.server import ModbusTcpServer
from pymodbus.server.requesthandler import ServerRequestHandler
from pymodbus.simulator import DataType, SimData, SimDevice

from tasks.station.clock import wall_s
from tasks.station.drivers.modbus import decode, encode
from tasks.station.virtual.config import (
    AXIS_BASE,
    AXIS_REGISTERS,
    AXIS_STRIDE,
    CAPTURE_REGISTERS,
    CAPTURE_VALUES,
    CHAMBER_DEVICE,
    CHAMBER_REGISTERS,
    COMMANDS,
    FIXTURE_DEVICE,
    FIXTURE_REGISTERS,
    MAP_VERSION,
    MODES,
    STEP_US,
    TABLE_DEVICE,
    TABLE_IDENT,
    TABLE_REGISTERS,
    Register,
)
from tasks.station.virtual.simulation import Simulation
from tasks.station.virtual.table import DEGREE

ATTITUDE = ("qw", "qx", "qy", "qz")
MIN_NORM_SQUARED = 0.1  # a quaternion below it is no attitude

Value = float | int


class RefusedWrite(Exception):  # noqa: N818 (the controller refuses; the client reads why)
    """A write that the controller does not take, with the code that it answers.

    ILLEGAL_ADDRESS: to a register that is not writable, or only to a part of one. ILLEGAL_VALUE:
    of a value that means nothing here. DEVICE_BUSY: another client holds the table.
    """

    def __init__(self, code: ExcCodes) -> None:
        self.code = code


def is_for_all(name: str, value: Value) -> bool:
    """Whether a write is taken from anybody while another holds the table."""
    stops = (
        ("command", COMMANDS["stop"]), ("command", COMMANDS["quick_stop"]), ("mode", MODES["stop"])
    )  # fmt: skip
    return name == "capture_from" or (name, value) in stops


class DeviceRegisters:
    """A device of the register map: what its registers read, and what is written to them."""

    def __init__(
        self, simulation: Simulation, registers: Sequence[Register], axes: int = 0
    ) -> None:
        self.simulation = simulation
        self._axes = (None, *range(axes))
        # By the address of its first word: a register and its axis, None for the device itself.
        self._places: dict[int, tuple[Register, int | None]] = {
            register.address: (register, None) for register in registers
        }
        for axis in range(axes):
            base = AXIS_BASE + AXIS_STRIDE * axis
            self._places |= {base + each.address: (each, axis) for each in AXIS_REGISTERS}
        self.size = max(address + place.words for address, (place, _) in self._places.items())

    def values(self, axis: int | None) -> Mapping[str, Value]:
        """The values of an axis, or of the device itself, by the register's name."""
        raise NotImplementedError

    def is_sane(self, name: str, value: Value) -> bool:
        """Whether a value means something in a writable register."""
        raise NotImplementedError

    def take(self, name: str, axis: int | None, value: Value) -> None:
        """Takes a sane value for a writable register."""
        raise NotImplementedError

    def words(self) -> list[int]:
        """All words of the device as they are now."""
        image = [0] * self.size
        values = {axis: self.values(axis) for axis in self._axes}
        for address, (register, axis) in self._places.items():
            words = encode(values[axis][register.name], register.type)
            image[address : address + register.words] = words
        return image

    def write(self, address: int, words: list[int], commands: bool = True) -> None:
        """Takes words from an address on: whole writable registers, each with a sane value.

        commands: whether it comes from one who may command; else it may fetch and stop only.

        Raises RefusedWrite, and then nothing has changed. A mode is taken last, so
        that it goes toward the targets of the same write.
        """
        written = list(self._written(address, words))
        if not all(self.is_sane(name, value) for name, _, value in written):
            raise RefusedWrite(ExcCodes.ILLEGAL_VALUE)
        if not commands and not all(is_for_all(name, value) for name, _, value in written):
            raise RefusedWrite(ExcCodes.DEVICE_BUSY)
        for name, axis, value in sorted(written, key=lambda write: write[0] == "mode"):
            self.take(name, axis, value)

    def _written(self, address: int, words: list[int]) -> Iterator[tuple[str, int | None, Value]]:
        offset = 0
        while offset < len(words):
            register, axis = self._places.get(address + offset, (None, None))
            end = offset + (register.words if register else 0)
            if register is None or not register.writable or end > len(words):
                raise RefusedWrite(ExcCodes.ILLEGAL_ADDRESS)
            yield register.name, axis, decode(words[offset:end], register.type)
            offset = end


class TableRegisters(DeviceRegisters):
    """Device 1."""

    def __init__(self, simulation: Simulation) -> None:
        self._table = simulation.table
        self.watchdog = 0  # ms
        self.capture_from = 0
        registers = (*TABLE_REGISTERS, *CAPTURE_REGISTERS[:-1])
        super().__init__(simulation, registers, len(self._table.drives))
        self.size += 2 * CAPTURE_VALUES

    def words(self) -> list[int]:
        """All words of the device as they are now, the captured samples among them."""
        image = super().words()
        samples = self._block()[1].astype(">i4").tobytes()
        start = CAPTURE_REGISTERS[-1].address
        image[start : start + len(samples) // 2] = np.frombuffer(samples, ">u2").tolist()
        return image

    def values(self, axis: int | None) -> Mapping[str, Value]:
        """What the table or one of its axes reads."""
        table = self._table
        if axis is None:
            first, counts = self._block()
            return {
                "ident": TABLE_IDENT,
                "map_version": MAP_VERSION,
                "axes": len(table.drives),
                "status": table.status(),
                "station_time": table.steps * STEP_US,
                "watchdog": self.watchdog,
                "command": 0,
                "capture_period": table.design.capture_ms * 1000,
                "capture_from": self.capture_from,
                "capture_count": len(counts),
                "capture_first": first,
            }
        drive = table.drives[axis]
        return {
            "mode": drive.mode,
            "status": table.axis_status(axis),
            "target_angle": drive.target_angle / DEGREE,
            "target_rate": drive.target_rate / DEGREE,
            "acceleration_limit": drive.acceleration_limit / DEGREE,
            "angle": int(table.counts(table.angle)[axis].astype(np.int32)),  # turns over
            "rate": table.rate[axis] / DEGREE,
            "counts_per_turn": table.design.counts_per_turn,
        }

    def _block(self) -> tuple[int, np.ndarray]:
        return self._table.capture(self.capture_from, CAPTURE_VALUES // len(self._table.drives))

    def is_sane(self, name: str, value: Value) -> bool:
        """Whether it is finite, a mode or a command that there is, and not beyond the drives."""
        design = self._table.design
        sane = {
            "command": value in COMMANDS.values(),
            "mode": value in MODES.values(),
            "target_rate": abs(value) <= design.most_rate_deg_s,
            "acceleration_limit": 0 < value <= design.most_acceleration_deg_s2,
        }
        return math.isfinite(value) and sane.get(name, True)

    def take(self, name: str, axis: int | None, value: Value) -> None:
        """Takes a set-point of an axis, or what the table as a whole is told."""
        table = self._table
        if axis is None and name == "command":
            commands = {"reset": table.reset, "stop": table.stop, "quick_stop": table.quick_stop}
            next(commands[each] for each, number in COMMANDS.items() if number == value)()
        elif axis is None:
            setattr(self, name, int(value))
            if name == "capture_from":
                table.want(self.capture_from)
        elif name == "mode":
            table.command(axis, int(value))
        else:
            setattr(table.drives[axis], name, value * DEGREE)


class ChamberRegisters(DeviceRegisters):
    """Device 2."""

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation, CHAMBER_REGISTERS)
        self._last: Mapping[str, Value] = {}

    def values(self, axis: int | None) -> Mapping[str, Value]:
        """What the chamber measures."""
        if not self.simulation.condition.is_chamber_frozen or not self._last:
            self._last = self._measured()
        return self._last

    def _measured(self) -> Mapping[str, Value]:
        air = self.simulation.air
        return {
            "temperature": air.temperature_degc,
            "humidity": air.humidity_percent,
            "supply_voltage": air.supply_v,
            "pressure": air.pressure_hpa,
            "station_time": self.simulation.table.steps * STEP_US,
            "target": self.simulation.chamber.target,
        }

    def is_sane(self, name: str, value: Value) -> bool:
        """Whether it is a temperature that the chamber can keep."""
        low, high = self.simulation.config.chamber.temperature_degc
        return low <= value <= high

    def take(self, name: str, axis: int | None, value: Value) -> None:
        """Sets out for a temperature."""
        self.simulation.chamber.go_to(self.simulation.table.now, value)


class FixtureRegisters(DeviceRegisters):
    """Device 3: the fixture and the unit's supply."""

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation, FIXTURE_REGISTERS)

    def values(self, axis: int | None) -> Mapping[str, Value]:
        """The attitude wanted, and whether the fixture is there and the unit is on."""
        simulation = self.simulation
        return {
            **dict(zip(ATTITUDE, simulation.fixture.wanted, strict=True)),
            "turn": 0,
            "status": simulation.fixture.status(simulation.table.now),
            "supply": int(simulation.is_supplied),
            "supply_on_time": simulation.supplied_steps * STEP_US,
        }

    def is_sane(self, name: str, value: Value) -> bool:
        """Whether it is a part of a unit quaternion, or a yes or no."""
        return abs(value) <= 1.0 if name in ATTITUDE else value in (0, 1)

    def take(self, name: str, axis: int | None, value: Value) -> None:
        """Takes it; raises RefusedWrite where the fixture is to turn to what is no attitude."""
        simulation = self.simulation
        if name in ATTITUDE:
            simulation.fixture.wanted[ATTITUDE.index(name)] = value
        elif name == "supply":
            simulation.supply(bool(value))
        elif value:
            if (simulation.fixture.wanted**2).sum() < MIN_NORM_SQUARED:
                raise RefusedWrite(ExcCodes.ILLEGAL_VALUE)
            simulation.turn_fixture()


# The station's controller: which client its devices answer, who holds the table, the watchdog.

LOOK_S = 0.1  # a pause of the station itself counts for no more: it heard nobody meanwhile
TRIED_S = 1.0  # the same of one that does not hold the table, as who tries devices
WANTED_S = 30.0  # wall time for which a client that has stopped fetching holds the clock

REFUSALS = {
    "exception": ExcCodes.DEVICE_FAILURE,
    "address": ExcCodes.ILLEGAL_ADDRESS,
    "busy": ExcCodes.DEVICE_BUSY,
}

_WATCHDOG = next(each.address for each in TABLE_REGISTERS if each.name == "watchdog")
_CAPTURE = CAPTURE_REGISTERS[0].address

client: ContextVar["Connection"] = ContextVar("client")  # whose request is being answered


class Connection(ServerRequestHandler):
    """One client."""

    async def handle_request(self) -> None:
        """Answer its request."""
        client.set(self)
        await super().handle_request()


class ControllerServer(ModbusTcpServer):
    """pymodbus's server, in which an answer may depend on who asks."""

    def callback_new_connection(self) -> Connection:
        return Connection(self, self.trace_packet, self.trace_pdu, self.trace_connect)


async def _nobody_sleeps() -> None:
    pass


class Controller:
    """Devices 1 to 3 of the register map.

    The client that sets the watchdog holds the table: until it sets it to 0, it has tripped, or the
    connection ends, no other client commands it, and only the holder's requests reset the watchdog.

    wake: awaited before every answer.
    """

    def __init__(
        self, simulation: Simulation, wake: Callable[[], Awaitable[None]] = _nobody_sleeps
    ) -> None:
        self._simulation = simulation
        self._wake = wake
        self._table = TableRegisters(simulation)
        self._holder: Connection | None = None
        self._unheard_s = self._unfetched_s = 0.0  # wall time since the holder, anybody asked
        self._looked_s = wall_s()
        self._requests = 0
        self._never = asyncio.Event()

    def devices(self) -> list[SimDevice]:
        """The devices as pymodbus's server takes them."""
        return [
            self._served(TABLE_DEVICE, self._table),
            self._served(CHAMBER_DEVICE, ChamberRegisters(self._simulation)),
            self._served(FIXTURE_DEVICE, FixtureRegisters(self._simulation)),
        ]

    def _served(self, number: int, device: DeviceRegisters) -> SimDevice:
        async def action(
            _code: int, _start: int, address: int, _count: int, words: list[int],
            written: list[int] | list[bool] | None,
        ) -> ExcCodes | None:  # fmt: skip
            asking = client.get()
            await self._wake()
            if failure := await self._failure(number, asking):
                return failure
            if written is not None:
                try:
                    commands = self._is_free() or asking is self._holder
                    device.write(address, [int(word) for word in written], commands)
                except RefusedWrite as refusal:
                    return refusal.code
            if number == TABLE_DEVICE:
                written_to = range(address, address + len(written or ()))
                self._note_request(asking, address, _WATCHDOG in written_to)
            if written is None:
                words[: device.size] = self._shown(device.words())
            return None

        zeros = SimData(0, count=device.size, values=0, datatype=DataType.REGISTERS)
        return SimDevice(number, [zeros], action=action)

    def _is_free(self) -> bool:
        return self._holder is None or not self._holder.is_active()

    def _note_request(self, asking: Connection, address: int, sets_watchdog: bool) -> None:
        """Which client sent a request, and whether it resets the watchdog; fetching encoders
        does not.
        """
        if sets_watchdog:
            self._hold(asking if self._table.watchdog else None)
        if address >= _CAPTURE:
            self._unfetched_s = 0.0
        elif asking is self._holder:
            self._unheard_s = 0.0

    def watch(self) -> None:
        """Stops the table if its holder is silent for longer than the watchdog allows."""
        now_s = wall_s()
        passed_s, self._looked_s = min(now_s - self._looked_s, LOOK_S), now_s
        self._unheard_s += passed_s
        self._unfetched_s += passed_s
        if self._holder and self._unheard_s * 1000.0 > self._table.watchdog:
            self._hold(None)
            self._simulation.table.trip({"watchdog"})
        if self._unfetched_s > (WANTED_S if self._holder else TRIED_S):
            self._simulation.table.wanted = None

    def _hold(self, holder: Connection | None) -> None:
        self._holder = holder
        if holder is None:  # whoever fetched for a run that is over fetches no more
            self._simulation.table.wanted = None

    def _shown(self, words: list[int]) -> list[int]:
        stuck = {"zeros": 0, "ones": 0xFFFF}.get(self._simulation.condition.modbus)
        return words if stuck is None else [stuck] * len(words)

    async def _failure(self, number: int, asking: Connection) -> ExcCodes | None:
        """By what fault a request to a device is not answered as it should be."""
        now = self._simulation.condition
        if now.modbus == "silent" or (now.is_chamber_silent and number == CHAMBER_DEVICE):
            await self._never.wait()
        if now.modbus_delay_s:
            await asyncio.sleep(now.modbus_delay_s)
        self._requests += 1
        if now.cuts_modbus_every and self._requests % now.cuts_modbus_every == 0:
            asking.close()
            return ExcCodes.DEVICE_FAILURE  # which nobody gets
        return REFUSALS.get(now.modbus)
