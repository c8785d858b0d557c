"""The devices of a station that a run needs, connected and ready."""

from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine, Sequence
from contextlib import ExitStack, asynccontextmanager, closing
from dataclasses import dataclass
from typing import Any

from schemas.procedure import Refix
from schemas.station import StationFile
from schemas.unit_link import UnitLink
from tasks.station.bus import BusChamber, BusFixture, BusTable, bus
from tasks.station.drivers.devices import Devices
from tasks.station.drivers.unit import UnitDriver
from tasks.station.drivers.unit_line import UnitLine
from tasks.station.ports import Ask, Chamber, Fixture, Table


@dataclass(frozen=True)
class Bench:
    """A station ready for a run; fixture: None where nobody can turn the unit over.

    beside: runs the work where it waits for nothing that the run is busy with.
    """

    table: Table
    chamber: Chamber
    fixture: Fixture | None
    units: tuple[UnitDriver, ...]
    beside: Callable[[Coroutine[Any, Any, None]], Awaitable[None]]


@asynccontextmanager
async def connected(
    station: StationFile, links: Sequence[UnitLink], ask: Ask | None
) -> AsyncIterator[Bench]:
    """The bench of a station file with the units at some links, for the length of the block.

    Raises Unusable where the table or a unit's line cannot be reached, and where the chamber is to
    be set and its driver cannot set it.
    """
    names = tuple(axis.name for axis in station.station.table_axes or ())
    devices = Devices(names)
    fixture: Fixture | None = ByHand(ask) if ask is not None else None
    with bus() as drivers:
        if station.fixture != "by_hand":
            fixture = BusFixture(await drivers.do(devices.fixture(station.fixture)), drivers)
        try:
            table = BusTable(await drivers.do(devices.table(station.table)), drivers)
            is_set = station.limits.chamber is not None
            found = await drivers.do(devices.chamber(station.chamber, is_set))
            chamber = BusChamber(found, drivers)
            with ExitStack() as lines:
                units = tuple(
                    UnitDriver(link, lines.enter_context(closing(UnitLine(link)))) for link in links
                )
                yield Bench(table, chamber, fixture, units, drivers.do)
        finally:
            await drivers.do(devices.hang_up())


@dataclass(frozen=True)
class ByHand:
    """A fixture turned by a person, who sees to the supply too and says when it is done."""

    ask: Ask

    async def turn(self, refix: Refix) -> float | None:
        """Have it done; when the supply came back is not known."""
        await self.ask(refix)
        return None
