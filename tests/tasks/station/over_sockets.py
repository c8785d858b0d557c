"""A virtual station behind sockets, runs over them, and a unit that listens."""

import asyncio
import socket
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from typing import Any

from schemas.procedure import Procedure
from schemas.station import ModbusTable, StationFile
from tasks.station.acquisition import Acquired, NewRecording, Progress, RunRequest, acquire
from tasks.station.drivers.devices import Devices
from tasks.station.drivers.modbus import ModbusLink
from tasks.station.ports import TableState
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import StationFault
from tasks.station.virtual.servers import serve

SPEED = 20.0
WATCHDOG = 8  # its register
MEASURED = ["position_+x_000", "position_-x_000", "rate_x_-50", "rate_x_+100"]


def ignore(progress: Progress) -> None:
    pass


def over_sockets(
    station: StationFile,
    procedure: Procedure,
    sink: Any,
    report: Callable[[Progress], None] = ignore,
) -> Acquired:
    recording = NewRecording(station, sink, "over sockets")
    (acquired,) = acquire(RunRequest(station, procedure, (recording,), report))
    return acquired


def table_and_watchdog(station: StationFile) -> tuple[TableState, int]:
    """The table's state once it is at rest, and its watchdog, by a connection of its own."""

    async def read() -> tuple[TableState, int]:
        devices = Devices(tuple(axis.name for axis in station.station.table_axes or ()))
        assert isinstance(station.table, ModbusTable)
        link = ModbusLink(station.table)
        try:
            (watchdog,) = await link.read(1, "holding", WATCHDOG, 1)
            table = await devices.table(station.table)
            for _ in range(1000):
                state = await table.state()
                if not any(axis.is_moving for axis in state.axes):
                    break
                await asyncio.sleep(0.02)
            return state, watchdog
        finally:
            link.close()
            await devices.hang_up()

    return asyncio.run(read())


async def let_the_watchdog_bite(station: StationFile) -> None:
    """As a run does that is killed: polls for a while, then no more."""
    assert isinstance(station.table, ModbusTable)
    link = ModbusLink(station.table)
    try:
        await link.write(1, "holding", WATCHDOG, [50])
        await asyncio.sleep(0.3)
    finally:
        link.close()


# A virtual station behind sockets, served by a thread of this process.


@contextmanager
def serving(
    config: VirtualStation, speed: float, faults: Iterable[StationFault] = ()
) -> Iterator[StationFile]:
    """In the place of `tasks.station.virtual.servers.running`."""
    started = Future[tuple[StationFile, Callable[[], object]]]()

    def ready(station: StationFile) -> None:
        loop, task = asyncio.get_running_loop(), asyncio.current_task()
        assert task is not None
        started.set_result((station, lambda: loop.call_soon_threadsafe(task.cancel)))

    def work() -> None:
        try:
            asyncio.run(serve(config, speed=speed, faults=faults, ready=ready))
        except asyncio.CancelledError:
            pass
        except Exception as error:
            started.set_exception(error)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    station, end = started.result()
    try:
        yield station
    finally:
        end()
        thread.join()


# A unit that is told lines of text, and answers among the frames that it goes on sending.


@contextmanager
def unit(answer: Callable[[bytes], bytes]) -> Iterator[tuple[str, list[bytes]]]:
    """Its address, and the lines that it was told."""
    received: list[bytes] = []

    def serve(server: socket.socket) -> None:
        client, _ = server.accept()
        with client, suppress(OSError):
            for line in client.makefile("rb"):
                received.append(line)
                client.sendall(b"\xaa\x55frame" + answer(line) + b"\xaa\x55frame")

    with socket.create_server(("127.0.0.1", 0)) as server:
        thread = threading.Thread(target=serve, args=(server,), daemon=True)
        thread.start()
        try:
            yield f"socket://127.0.0.1:{server.getsockname()[1]}", received
        finally:  # where nobody connected, an empty connection ends the wait for one
            socket.create_connection(server.getsockname()).close()
            thread.join(5.0)
