"""Runs over sockets on a virtual station in another process, and what such a run leaves behind."""

import asyncio
from collections.abc import Callable
from typing import Any

from schemas.procedure import Procedure
from schemas.station import ModbusTable, StationFile
from tasks.station.acquisition import Acquired, NewRecording, RunRequest, acquire
from tasks.station.drivers.devices import Devices
from tasks.station.drivers.modbus import ModbusLink
from tasks.station.ports import TableState
from tasks.station.progress import Progress

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
