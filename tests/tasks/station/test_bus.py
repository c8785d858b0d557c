"""Drivers in a thread of their own: encoders are fetched while the run's own loop is held up."""

import asyncio
import time
from typing import Any, cast

import numpy as np
import pytest

from schemas.base import Unusable
from tasks.station import stream_readers
from tasks.station.clock import StationClock, wall_s
from tasks.station.connected_station import Bus, StopSwitch, TableOnBus, bus
from tasks.station.ports import EncoderBlock, Table
from tasks.station.stream_readers import EncoderReader


class Endless:
    """A table whose capture is always full."""

    names = ("only",)
    period_us = 10_000
    block_samples = 19

    async def encoder(self, first: int) -> EncoderBlock:
        await asyncio.sleep(0)
        t = (first + np.arange(self.block_samples)) / 100.0
        return EncoderBlock(first, np.full((self.block_samples, 1), 0.5), t)

    async def state(self) -> Any:
        raise Unusable("the table says no")


def table_on(devices: Bus) -> Table:
    return cast(Table, TableOnBus("table", Endless(), devices, StopSwitch()))


async def reading(devices: Bus) -> tuple[EncoderReader, asyncio.Task[None]]:
    clock = StationClock()
    clock.update(0.0, wall_s())
    reader = EncoderReader(table_on(devices), clock, [].append)
    return reader, asyncio.create_task(devices.do(reader.run()))


def held_up_until(holds: Any) -> None:
    """Without giving the loop a turn."""
    while not holds():
        time.sleep(0.001)


def test_encoders_are_fetched_while_the_runs_loop_is_held_up():
    async def run() -> np.ndarray:
        with bus() as devices:
            reader, task = await reading(devices)
            await asyncio.sleep(0)
            held_up_until(lambda: len(reader.blocks) > 50)
            taken = [reader.take().t, reader.take().t]
            task.cancel()
            return np.concatenate(taken)

    t = asyncio.run(run())
    assert len(t) > 50 * Endless.block_samples
    assert np.diff(t) == pytest.approx(0.01)


def test_no_more_is_fetched_than_may_wait(monkeypatch):
    monkeypatch.setattr(stream_readers, "MOST_BLOCKS", 10)

    async def run() -> tuple[int, int]:
        with bus() as devices:
            reader, task = await reading(devices)
            await asyncio.sleep(0)
            held_up_until(lambda: len(reader.blocks) >= 10)
            waiting = len(reader.blocks)
            first = reader.take()
            held_up_until(lambda: len(reader.blocks) >= 10)
            after = reader.take()
            task.cancel()
            return waiting, round((after.t[0] - first.t[-1]) * 100)

    assert asyncio.run(run()) == (10, 1)


def test_a_fault_on_the_bus_is_raised_where_it_was_asked_and_is_an_event(caplog):
    async def run() -> None:
        with bus() as devices:
            await table_on(devices).state()

    with pytest.raises(Unusable, match="the table says no"):
        asyncio.run(run())
    failed = caplog.records[-1]
    assert (failed.name, failed.message) == ("mimucal.station.table", "failed")
    assert (failed.command, failed.cause) == ("state", "the table says no")  # type: ignore[attr-defined]


def test_the_bus_ends_with_its_block_whatever_still_runs_there():
    async def stubborn() -> None:
        for _ in range(3):  # cancellations that it swallows
            try:
                await asyncio.sleep(3600.0)
            except asyncio.CancelledError:
                continue

    async def run() -> None:
        with bus() as devices:
            ignored = asyncio.create_task(devices.do(stubborn()))
            await asyncio.sleep(0)
            await devices.do(asyncio.sleep(0))
            ignored.cancel()

    asyncio.run(run())
