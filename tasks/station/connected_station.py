"""The devices of a station that a run needs, connected and ready."""

import asyncio
import concurrent.futures
import threading
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine, Iterator, Sequence
from contextlib import ExitStack, asynccontextmanager, closing, contextmanager, suppress
from dataclasses import dataclass, field
from typing import Any, TypeVar

from schemas.base import Unusable
from schemas.procedure import Refix
from schemas.station import StationFile
from tasks.station.drivers.devices import Devices
from tasks.station.drivers.identity import confirm
from tasks.station.drivers.unit import UnitDriver
from tasks.station.drivers.unit_line import UnitLine
from tasks.station.ports import (
    Ask,
    Chamber,
    Climate,
    EncoderBlock,
    Fixture,
    Table,
    TableState,
    oscillating,
)
from tasks.station.stopping import StopSwitch, bring_to_rest, is_at_rest

T = TypeVar("T")
END_S = 0.01  # after which work that swallowed its cancellation is cancelled again
STUBBORN_S = 0.3  # for which a stop waits for it


# A thread in which drivers talk to their devices, so that other work does not delay them.
#
# What the run writes, checks and shows may hold up its own event loop for seconds; the encoders
# that the table has captured are fetched meanwhile.


class Bus:
    """An event loop in a thread; `do` runs something there for another loop."""

    def __init__(self) -> None:
        self._loop = asyncio.new_event_loop()
        self._stopping: concurrent.futures.Future[None] | None = None
        # What fails is raised where it was asked for; whoever asked may have ended meanwhile.
        self._loop.set_exception_handler(lambda loop, context: None)
        self._thread = threading.Thread(target=self._loop.run_forever, name="bus", daemon=True)
        self._thread.start()

    async def do(self, work: Coroutine[Any, Any, T]) -> T:
        """What the work gives, or raises; cancelled here, it is cancelled there."""
        return await asyncio.wrap_future(asyncio.run_coroutine_threadsafe(work, self._loop))

    def stop(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """End whatever runs there, then do this; returns at once, in any thread."""
        self._stopping = asyncio.run_coroutine_threadsafe(self._alone(work), self._loop)

    async def _alone(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        loop = asyncio.get_running_loop()
        end_s = loop.time() + STUBBORN_S
        others = asyncio.all_tasks() - {asyncio.current_task()}
        while others and loop.time() < end_s:
            for task in others:
                task.cancel()
            _, others = await asyncio.wait(others, timeout=END_S)
        await work()

    async def stopped(self) -> None:
        """Wait for the end of what `stop` does there; nothing where it was not called."""
        if self._stopping is not None:
            with suppress(Unusable, OSError, TimeoutError):
                await asyncio.shield(asyncio.wrap_future(self._stopping))

    def close(self) -> None:
        """End whatever still runs there, and the thread."""
        self._loop.call_soon_threadsafe(self._end)
        self._thread.join()
        self._loop.close()

    def _end(self) -> None:
        running = asyncio.all_tasks(self._loop)
        for task in running:
            task.cancel()
        # again until all have ended, as in `acquisition`: one may swallow its cancellation
        self._loop.call_later(END_S, self._end) if running else self._loop.stop()


@contextmanager
def bus() -> Iterator[Bus]:
    """A bus for the length of the block."""
    made = Bus()
    try:
        yield made
    finally:
        made.close()


@dataclass(frozen=True)
class BusTable:
    """A table that is talked to on a bus; once the switch is pressed it takes no more commands."""

    table: Table
    bus: Bus
    stop_switch: StopSwitch = field(default_factory=StopSwitch)

    @property
    def names(self) -> tuple[str, ...]:
        return self.table.names

    @property
    def period_us(self) -> int:
        return self.table.period_us

    @property
    def block_samples(self) -> int:
        return self.table.block_samples

    @property
    def time_half_width_s(self) -> float:
        return self.table.time_half_width_s

    async def home(self) -> None:
        await self._do(self.table.home)

    async def move_to(self, axis: int, angle: float, rate: float, acceleration: float) -> None:
        await self._do(self.table.move_to, axis, angle, rate, acceleration)

    async def turn_at(self, axis: int, rate: float, acceleration: float) -> None:
        await self._do(self.table.turn_at, axis, rate, acceleration)

    async def oscillate(self, axis: int, amplitude: float, frequency: float, cycles: int) -> None:
        await self._do(oscillating(self.table), axis, amplitude, frequency, cycles)  # type: ignore[arg-type]

    async def stop(self, axis: int) -> None:
        await self._do(self.table.stop, axis)

    async def state(self) -> TableState:
        return await self._do(self.table.state)

    async def encoder(self, first: int) -> EncoderBlock:
        return await self.bus.do(self.table.encoder(first))

    async def leave(self) -> None:
        if self.stop_switch.by is None:
            await self.bus.do(self.table.leave())
        else:
            await self.bus.stopped()

    async def _do(self, command: Callable[..., Coroutine[Any, Any, T]], *given: Any) -> T:
        return await self.bus.do(_unless_stopped(self.stop_switch, command, *given))

    async def bring_to_rest(self) -> None:
        """On the bus: stop every axis, note when the table is at rest, and hand it back."""

        def commanded() -> None:
            self.stop_switch.is_commanded = True

        try:
            state = await bring_to_rest(self.table, commanded)
            self.stop_switch.rest = state if is_at_rest(state) else None
        finally:
            await self.table.leave()


async def _unless_stopped(
    stop: StopSwitch, command: Callable[..., Coroutine[Any, Any, T]], *given: Any
) -> T:
    """Looked at on the bus itself: what comes there after a stop is not sent."""
    stop.check()
    return await command(*given)


@dataclass(frozen=True)
class BusChamber:
    """A chamber that is read on a bus."""

    chamber: Chamber
    bus: Bus

    async def climate(self) -> Climate:
        return await self.bus.do(self.chamber.climate())

    async def set_temperature(self, degc: float) -> None:
        await self.bus.do(self.chamber.set_temperature(degc))


@dataclass(frozen=True)
class BusFixture:
    """A fixture that is turned on a bus."""

    fixture: Fixture
    bus: Bus
    stop_switch: StopSwitch

    async def turn(self, refix: Refix) -> float | None:
        return await self.bus.do(_unless_stopped(self.stop_switch, self.fixture.turn, refix))


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
    station: StationFile, places: Sequence[StationFile], ask: Ask | None, stop: StopSwitch
) -> AsyncIterator[Bench]:
    """The bench of a station file for the length of the block.

    places: the station once for each unit that is measured, as if it were alone. At the press of
    the switch the table is stopped on the bus, whatever this loop is busy with.

    Raises Unusable where the table or a unit's line cannot be reached, where another unit is
    mounted than the one that is named, and where the chamber is to be set and its driver cannot
    set it.
    """
    names = tuple(axis.name for axis in station.station.table_axes or ())
    devices = Devices(names)
    fixture: Fixture | None = ByHand(ask) if ask is not None else None
    with bus() as drivers:
        if station.fixture != "by_hand":
            fixture = BusFixture(await drivers.do(devices.fixture(station.fixture)), drivers, stop)
        try:
            table = BusTable(await drivers.do(devices.table(station.table)), drivers, stop)
            is_set = station.limits.chamber is not None
            found = await drivers.do(devices.chamber(station.chamber, is_set))
            chamber = BusChamber(found, drivers)
            for place in places:
                confirm(place.unit, place.unit_link)
            with ExitStack() as lines:
                lines.enter_context(stop.calling(lambda: drivers.stop(table.bring_to_rest)))
                units = tuple(
                    UnitDriver(link, lines.enter_context(closing(UnitLine(link))))
                    for link in (place.unit_link for place in places)
                )
                yield Bench(table, chamber, fixture, units, drivers.do)
        finally:
            await drivers.stopped()
            await drivers.do(devices.hang_up())


@dataclass(frozen=True)
class ByHand:
    """A fixture turned by a person, who sees to the supply too and says when it is done."""

    ask: Ask

    async def turn(self, refix: Refix) -> float | None:
        """Have it done; when the supply came back is not known."""
        await self.ask(refix)
        return None
