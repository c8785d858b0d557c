"""The station's controller: which client its devices answer, who holds the table, the watchdog."""

import asyncio
from collections.abc import Awaitable, Callable
from contextvars import ContextVar

from pymodbus.constants import ExcCodes
from pymodbus.server import ModbusTcpServer
from pymodbus.server.requesthandler import ServerRequestHandler
from pymodbus.simulator import DataType, SimData, SimDevice

from tasks.station.clock import wall_s
from tasks.station.virtual.protocol import (
    CAPTURE_REGISTERS,
    CHAMBER_DEVICE,
    FIXTURE_DEVICE,
    TABLE_DEVICE,
    TABLE_REGISTERS,
)
from tasks.station.virtual.registers import (
    ChamberRegisters,
    DeviceRegisters,
    FixtureRegisters,
    RefusedWrite,
    TableRegisters,
)
from tasks.station.virtual.simulation import Simulation

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
        """For pymodbus's server."""
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
