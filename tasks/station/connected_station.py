"""The devices of a station that a run needs, connected and ready."""

import asyncio
import concurrent.futures
import logging
import threading
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine, Iterator, Sequence
from contextlib import ExitStack, asynccontextmanager, closing, contextmanager, suppress
from dataclasses import dataclass
from typing import Any, TypeVar, cast

from schemas.base import Unusable
from schemas.procedure import Refix
from schemas.station import AxisReading, StationFile
from schemas.text import Message
from tasks.station.clock import wall_s
from tasks.station.drivers.backend import confirm
from tasks.station.drivers.devices import Devices
from tasks.station.drivers.unit import UnitDriver, UnitLine
from tasks.station.ports import Ask, Chamber, Fixture, Table, TableState
from tasks.words import message

# What ends a run from outside: a switch that anybody presses, from any thread.

T = TypeVar("T")

OPERATOR = "the operator"  # of the terminal, and whoever sends a signal
CANCELLATION, LOSS = "a cancellation in Prefect", "the loss of its Prefect worker"
STOPS = {
    OPERATOR: "station-log-operator",
    CANCELLATION: "station-cause.cancelled",
    LOSS: "station-cause.no-worker",
}
AT_REST_DEG_S = 0.01
REST_S = 20.0  # wall time: from 400 deg/s with 20 deg/s2
LOOK_S = 0.03


def stopped_by(name: str) -> Message:
    """The sentence that says by whom, or by what, a run was stopped."""
    return message(STOPS[name]) if name in STOPS else message("station-log-stopped-by", name=name)


class StopRequested(Exception):  # noqa: N818 (nothing is in error)
    """A run ends because somebody stopped it; the text is who."""


class StopSwitch:
    """Pressed by whoever stops a run, and by whom; a second press changes nothing.

    is_live: while pressing it ends something. is_commanded, rest: whether the table was commanded
    to stop, and its state once it was at rest.
    """

    def __init__(self) -> None:
        self.by: str | None = None
        self.is_live = False
        self.is_commanded = False
        self.rest: TableState | None = None
        self._listeners: list[Callable[[], object]] = []
        self._lock = threading.RLock()  # a signal may press while its thread is inside

    def press(self, by: str) -> None:
        """End whatever the switch ends."""
        with self._lock:
            if self.by is not None:
                return
            self.by = by
            listeners = tuple(self._listeners)
        for listener in listeners:
            with suppress(RuntimeError):  # its event loop has ended meanwhile
                listener()

    def check(self) -> None:
        """Raises StopRequested once it was pressed."""
        if self.by is not None:
            raise StopRequested(self.by)

    def sleep(self, seconds: float) -> None:
        """Wait; raises StopRequested where it is pressed meanwhile."""
        end_s = time.monotonic() + seconds
        while (left_s := end_s - time.monotonic()) > 0:
            self.check()
            time.sleep(min(left_s, LOOK_S))
        self.check()

    @contextmanager
    def calling(self, listener: Callable[[], object]) -> Iterator[None]:
        """Have a function called at the press, in the thread that presses, or now if it was."""
        with self._lock:
            self._listeners.append(listener)
            is_pressed = self.by is not None
        if is_pressed:
            listener()
        try:
            yield
        finally:
            with self._lock:
                self._listeners.remove(listener)


def run_until_stopped(work: Coroutine[Any, Any, T], stop: StopSwitch) -> T:
    """Run the work in an event loop of its own; raises StopRequested where the switch ended it.

    The work is cancelled once, so that a second press does not cut short how it ends.
    """

    async def run() -> T:
        task, loop = asyncio.current_task(), asyncio.get_running_loop()
        assert task is not None
        with stop.calling(lambda: loop.call_soon_threadsafe(task.cancel)):
            return await work

    stop.is_live = True
    try:
        return asyncio.run(run())
    except (asyncio.CancelledError, Unusable) as end:
        if stop.by is None:
            raise
        raise StopRequested(stop.by) from end
    finally:
        stop.is_live = False


async def bring_to_rest(table: Table, commanded: Callable[[], None] = lambda: None) -> TableState:
    """Stop every axis, as quickly as the table may; its state at rest, or after REST_S.

    commanded: called once every axis was commanded. Raises Unusable where one could not be.
    """
    await _quick_stop(table)
    commanded()
    end_s, looks = wall_s() + REST_S, 0
    while True:
        state = await table.state()
        looks = looks + 1 if is_at_rest(state) else 0  # twice: a rate may pass through 0
        if looks == 2 or wall_s() > end_s:
            return state
        await asyncio.sleep(LOOK_S)


async def _quick_stop(table: Table) -> None:
    """By the quick stop of a table that has one, else by the stop of each axis."""
    if quick := getattr(table, "quick_stop", None):
        await quick()
        return
    failures = []
    for axis in range(len(table.names)):
        try:
            await table.stop(axis)
        except Unusable as failure:  # the others are to stop all the same
            failures.append(failure)
    if failures:
        raise failures[0]


def is_at_rest(state: TableState) -> bool:
    """Whether no axis moves."""
    return not any(axis.is_moving or abs(axis.rate_deg_s) > AT_REST_DEG_S for axis in state.axes)


def stop_directly(station: StationFile) -> TableState:
    """Stop the table of a station file on a connection of its own, whoever else commands it.

    Raises Unusable where it does not answer.
    """
    return asyncio.run(_stop_directly(station))


async def _stop_directly(station: StationFile) -> TableState:
    devices = Devices(tuple(axis.name for axis in station.station.table_axes or ()))
    try:
        # what the table is expected to be is not asked: nothing stands before a stop
        return await bring_to_rest(devices.table_unasked(station.table))
    finally:
        with suppress(OSError):
            await devices.hang_up()


def axes_of(station: StationFile, state: TableState | None) -> tuple[AxisReading, ...]:
    """The axes of a table as they were read, with their names."""
    names = (axis.name for axis in station.station.table_axes or ())
    axes = state.axes if state is not None else ()
    return tuple(
        AxisReading(name=name, angle_deg=axis.angle_deg, rate_deg_s=axis.rate_deg_s)
        for name, axis in zip(names, axes, strict=False)
    )


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
        """Stops every axis on the bus, notes when the table is at rest, and hand it back."""

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
