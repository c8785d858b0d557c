"""What a run needs of a station, connected and ready."""

from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine
from contextlib import asynccontextmanager, closing
from dataclasses import dataclass
from typing import Any

from schemas.procedure import Refix
from schemas.station import StationFile
from tasks.station.bus import BusChamber, BusFixture, BusTable, bus
from tasks.station.drivers.modbus import ModbusLink
from tasks.station.drivers.modbus_devices import ModbusChamber, ModbusFixture
from tasks.station.drivers.modbus_table import ModbusTable
from tasks.station.drivers.serial_line import SerialLine
from tasks.station.drivers.unit import UnitDriver
from tasks.station.ports import Ask, Chamber, Fixture, Table


@dataclass(frozen=True)
class Bench:
    """A station ready for a run; fixture: None where nobody can turn the unit over.

    beside: runs the work where it waits for nothing that the run is busy with.
    """

    table: Table
    chamber: Chamber
    fixture: Fixture | None
    unit: UnitDriver
    beside: Callable[[Coroutine[Any, Any, None]], Awaitable[None]]


@asynccontextmanager
async def connected(station: StationFile, ask: Ask | None) -> AsyncIterator[Bench]:
    """The bench of a station file, for the length of the block.

    Raises Unusable where the table or the unit's line cannot be reached.
    """
    link = ModbusLink(station.modbus_host, station.modbus_port)
    names = tuple(axis.name for axis in station.station.table_axes or ())
    fixture: Fixture | None = ByHand(ask) if ask is not None else None
    with bus() as devices:
        if station.fixture == "commanded":
            fixture = BusFixture(ModbusFixture(link), devices)
        try:
            table = BusTable(await devices.do(ModbusTable.find(link, names)), devices)
            with closing(SerialLine(station.unit_link)) as line:
                unit, chamber = UnitDriver(station.unit_link, line), ModbusChamber(link)
                yield Bench(table, BusChamber(chamber, devices), fixture, unit, devices.do)
        finally:
            await devices.do(link.hang_up())


@dataclass(frozen=True)
class ByHand:
    """A fixture turned by a person, who sees to the supply too and says when it is done."""

    ask: Ask

    async def turn(self, refix: Refix) -> float | None:
        """Have it done; when the supply came back is not known."""
        await self.ask(refix)
        return None
