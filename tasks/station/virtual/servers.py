"""The virtual station on the network: Modbus/TCP, the unit's stream, and the clock."""

import asyncio
import logging
from collections.abc import Callable, Iterable
from typing import Any, cast

from pymodbus.constants import ExcCodes
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

from schemas.base import Unusable
from schemas.station import (
    CHAMBER_DEVICE,
    FIXTURE_DEVICE,
    TABLE_DEVICE,
    AngleLink,
    AnyLink,
    StationFile,
    UnitLink,
)
from tasks.station.virtual.config import (
    STEP_S,
    VirtualStation,
    equipment,
    station_part,
    unit_identity,
)
from tasks.station.virtual.faults import Fault
from tasks.station.virtual.fixture_registers import FIXTURE_WORDS, FixtureRegisters
from tasks.station.virtual.reality import Reality
from tasks.station.virtual.registers import (
    CHAMBER_WORDS,
    TABLE_WORDS,
    BadAddress,
    BadValue,
    TableRegisters,
    chamber_words,
)

SLICE_WALL_S = 0.005
MOST_STEPS = 1000  # in one go: some milliseconds of computing, so that requests are answered
BACKLOG_BYTES = 16_000_000  # a client that reads no more is hung up on


class Line(asyncio.Protocol):
    """One client of the unit's stream; what it says is not heard."""

    def __init__(self, listeners: set[asyncio.Transport]) -> None:
        self._listeners = listeners

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """From now on it hears the unit."""
        self._transport = cast(asyncio.Transport, transport)
        self._listeners.add(self._transport)

    def connection_lost(self, _error: Exception | None) -> None:
        """It hung up."""
        self._listeners.discard(self._transport)


def _send(listeners: Iterable[asyncio.Transport], data: bytes) -> None:
    for transport in tuple(listeners):
        transport.write(data)
        if transport.get_write_buffer_size() > BACKLOG_BYTES:
            transport.abort()


class Controller:
    """Devices 1 to 3 of the register map, and the watchdog over them."""

    def __init__(self, reality: Reality) -> None:
        self._reality = reality
        self._registers = TableRegisters(reality)
        self._fixture_registers = FixtureRegisters(reality)
        self._heard: float | None = None
        self._never = asyncio.Event()

    def devices(self) -> list[SimDevice]:
        """For pymodbus's server."""

        def plain(count: int) -> list[SimData]:
            return [SimData(0, count=count, values=0, datatype=DataType.REGISTERS)]

        return [
            SimDevice(TABLE_DEVICE, plain(TABLE_WORDS), action=self._table),
            SimDevice(CHAMBER_DEVICE, plain(CHAMBER_WORDS), action=self._chamber),
            SimDevice(FIXTURE_DEVICE, plain(FIXTURE_WORDS), action=self._fixture),
        ]

    def watch(self) -> None:
        """Stops the table if nothing was heard for longer than the watchdog allows."""
        allowed = self._registers.watchdog_ms / 1000.0
        if not allowed or self._heard is None:
            return
        if asyncio.get_running_loop().time() - self._heard > allowed:
            self._heard = None  # until the next request it has done what it can
            self._reality.table.trip({"watchdog"})

    async def _answers(self) -> ExcCodes | None:
        modbus = self._reality.condition.modbus
        if modbus == "silent":
            await self._never.wait()
        self._heard = asyncio.get_running_loop().time()
        return ExcCodes.DEVICE_FAILURE if modbus == "exception" else None

    async def _table(
        self, _code: int, _start: int, address: int, _count: int, words: list[int],
        written: list[int] | list[bool] | None,
    ) -> ExcCodes | None:  # fmt: skip
        return await self._answer(self._registers, address, words, written)

    async def _fixture(
        self, _code: int, _start: int, address: int, _count: int, words: list[int],
        written: list[int] | list[bool] | None,
    ) -> ExcCodes | None:  # fmt: skip
        return await self._answer(self._fixture_registers, address, words, written)

    async def _answer(
        self, device: TableRegisters | FixtureRegisters, address: int, words: list[int],
        written: list[int] | list[bool] | None,
    ) -> ExcCodes | None:  # fmt: skip
        if failure := await self._answers():
            return failure
        if written is None:
            image = device.words()
            words[: len(image)] = image
            return None
        try:
            device.write(address, [int(word) for word in written])
        except BadAddress:
            return ExcCodes.ILLEGAL_ADDRESS
        except BadValue:
            return ExcCodes.ILLEGAL_VALUE
        return None

    async def _chamber(
        self, _code: int, _start: int, _address: int, _count: int, words: list[int],
        written: list[int] | list[bool] | None,
    ) -> ExcCodes | None:  # fmt: skip
        if failure := await self._answers():
            return failure
        words[:CHAMBER_WORDS] = chamber_words(self._reality)
        return None if written is None else ExcCodes.ILLEGAL_ADDRESS


async def _keep_time(
    reality: Reality, speed: float, controller: Controller, listeners: set[asyncio.Transport]
) -> None:
    """Lets station time pass at speed × wall time, slower where the machine cannot keep up."""
    loop = asyncio.get_running_loop()
    origin = loop.time()
    while True:
        behind = int((loop.time() - origin) * speed / STEP_S) - reality.table.steps
        steps = min(behind, MOST_STEPS)
        origin += max(behind - 2 * MOST_STEPS, 0) * STEP_S / speed
        controller.watch()
        if steps > 0 and (sent := reality.advance(steps)):
            _send(listeners, b"".join(sent))
        await asyncio.sleep(0 if behind > steps else SLICE_WALL_S)


async def serve(
    config: VirtualStation,
    *,
    host: str = "127.0.0.1",
    modbus_port: int = 0,
    unit_port: int = 0,
    speed: float = 1.0,
    faults: Iterable[Fault] = (),
    ready: Callable[[StationFile], None],
) -> None:
    """Runs the station until it is cancelled.

    speed: station seconds in a wall second. Port 0 takes a free one. ready gets what a client
    needs to find its way. Raises Unusable where a port cannot be had or the speed is no speed.
    """
    if not 0.0 < speed < float("inf"):
        raise Unusable(
            f"the station cannot run at speed {speed}: give a number above 0, as 1 or 20"
        )
    logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # it logs what clients do wrong
    reality = Reality(config, faults)
    reality.advance(1)  # so that the faults of second 0 hold for the first request
    controller = Controller(reality)
    listeners: set[asyncio.Transport] = set()
    modbus = ModbusTcpServer(controller.devices(), address=(host, modbus_port))
    if not await modbus.listen():
        raise Unusable(f"port {modbus_port} of {host} cannot be had for Modbus: choose another")
    try:
        unit = await asyncio.get_running_loop().create_server(
            lambda: Line(listeners), host, unit_port
        )
    except OSError as error:
        modbus.close()
        raise Unusable(
            f"port {unit_port} of {host} cannot be had for the unit: choose another"
        ) from error
    try:
        ready(_station_file(config, speed, host, _port(modbus.transport), _port(unit)))
        await _keep_time(reality, speed, controller, listeners)
    finally:
        modbus.close()
        unit.close()
        for transport in tuple(listeners):
            transport.close()


def _port(server: Any) -> int:
    return int(server.sockets[0].getsockname()[1])


def _station_file(
    config: VirtualStation, speed: float, host: str, modbus_port: int, unit_port: int
) -> StationFile:
    return StationFile(
        modbus_host=host,
        modbus_port=modbus_port,
        unit_link=_link(config, f"socket://{host}:{unit_port}"),
        station=station_part(config, speed),
        mount=config.mount,
        fixture="commanded",
        unit=unit_identity(config),
        equipment=equipment(config),
    )


def _link(config: VirtualStation, url: str) -> AnyLink:
    unit = config.unit
    line = {"url": url, "rate_hz": unit.rate_hz, "accel_lsb_m_s2": unit.accel.lsb}
    if unit.angle_lsb is None:
        return UnitLink.model_validate({**line, "gyro_lsb_rad_s": unit.gyro.lsb})
    return AngleLink.model_validate({**line, "frame": unit.frame, "angle_lsb_rad": unit.angle_lsb})
