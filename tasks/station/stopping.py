"""What ends a run from outside: a switch that anybody presses, from any thread."""

import asyncio
import threading
import time
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager, suppress
from typing import Any, TypeVar

from schemas.base import Unusable
from schemas.station import StationFile
from schemas.stop import AxisReading
from schemas.text import Message
from tasks.station.clock import wall_s
from tasks.station.drivers.devices import Devices
from tasks.station.ports import Table, TableState
from tasks.words import message

T = TypeVar("T")

OPERATOR = "the operator"  # of the terminal, and whoever sends a signal
CANCELLATION, LOSS = "a cancellation in Prefect", "the loss of its Prefect worker"
STOPS = {
    OPERATOR: "station-log-operator", CANCELLATION: "station-cause.cancelled",
    LOSS: "station-cause.no-worker",
}  # fmt: skip
AT_REST_DEG_S = 0.01
REST_S = 20.0  # wall time: from 400 deg/s with 20 deg/s2
LOOK_S = 0.03


def stopped_by(name: str) -> Message:
    """By whom, or by what, a run was stopped, as a sentence."""
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
