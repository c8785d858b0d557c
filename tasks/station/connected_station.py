"""The devices of a station that a run needs, connected and ready."""

import asyncio
import concurrent.futures
import logging
import threading
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine, Iterator, Sequence
from contextlib import ExitStack, asynccontextmanager, closing, contextmanager, suppress
from dataclasses import dataclass
from typing import Any, TypeVar, cast

from schemas.base import Unusable
from schemas.procedure import Refix
from schemas.station import StationFile
from tasks.station.drivers.devices import Devices
from tasks.station.drivers.identity import confirm
from tasks.station.drivers.unit import UnitDriver
from tasks.station.drivers.unit_line import UnitLine
from tasks.station.ports import Ask, Chamber, Fixture, Table
from tasks.station.stopping import StopSwitch, bring_to_rest, is_at_rest

T = TypeVar("T")
END_S = 0.01  # after which work that swallowed its cancellation is cancelled again
STUBBORN_S = 0.3  # for which a stop waits for it
READ = ("state", "encoder", "climate")  # many times a second: no events


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


class OnBus:
    """A device that is talked to on a bus; what is no method is the device's own.

    name: of its logger. stop: once it was pressed, the device takes no more commands.
    """

    def __init__(self, name: str, device: Any, bus: Bus, stop: StopSwitch) -> None:
        self._device = device
        self._bus = bus
        self._stop = stop
        self._log = logging.getLogger(f"mimucal.station.{name}")

    def __getattr__(self, name: str) -> Any:
        """A method runs on the bus. The encoders are read after a stop as well."""
        member = getattr(self._device, name)
        if not callable(member):
            return member

        async def run(*given: Any) -> Any:
            if name not in READ:
                self._log.debug(name, extra={"given": given})
            try:
                return await self._bus.do(sent(*given))
            except Unusable as fault:
                self._log.error("failed", extra={"command": name, "cause": str(fault)})
                raise

        async def sent(*given: Any) -> Any:
            """Looks at the switch on the bus: what comes there after a stop is not sent."""
            if name != "encoder":
                self._stop.check()
            return await member(*given)

        return run


class TableOnBus(OnBus):
    """A table that is brought to rest, and handed back, by the press of a switch."""

    async def leave(self) -> None:
        """Hand the table back, or wait until the stop has done it."""
        if self._stop.by is None:
            await self._bus.do(self._device.leave())
        else:
            await self._bus.stopped()

    async def bring_to_rest(self) -> None:
        """On the bus: stop every axis, note when the table is at rest, and hand it back."""

        def commanded() -> None:
            self._stop.is_commanded = True

        self._log.warning("stopped", extra={"by": self._stop.by})
        try:
            state = await bring_to_rest(self._device, commanded)
            self._stop.rest = state if is_at_rest(state) else None
        finally:
            await self._device.leave()


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
            turned = await drivers.do(devices.fixture(station.fixture))
            fixture = cast(Fixture, OnBus("fixture", turned, drivers, stop))
        try:
            turning = await drivers.do(devices.table(station.table))
            table = TableOnBus("table", turning, drivers, stop)
            is_set = station.limits.chamber is not None
            found = await drivers.do(devices.chamber(station.chamber, is_set))
            chamber = cast(Chamber, OnBus("chamber", found, drivers, stop))
            for place in places:
                confirm(place.unit, place.unit_link)
            with ExitStack() as lines:
                lines.enter_context(stop.calling(lambda: drivers.stop(table.bring_to_rest)))
                units = tuple(
                    UnitDriver(link, lines.enter_context(closing(UnitLine(link))))
                    for link in (place.unit_link for place in places)
                )
                yield Bench(cast(Table, table), chamber, fixture, units, drivers.do)
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
