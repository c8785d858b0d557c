"""What reads unit and encoders: stamps on the table's time, and blocks while the run is held up."""

import asyncio
import time
from typing import Any, cast

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.unit_link import UnitLink
from tasks.station import stream_readers
from tasks.station.clock import StationClock, wall_s
from tasks.station.connected_station import Bus, StopSwitch, TableOnBus, bus
from tasks.station.drivers.unit import UnitDriver, no_samples, to_stream
from tasks.station.ports import EncoderBlock, Table
from tasks.station.stream_readers import EncoderReader, UnitReader, compared
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.servers import station_file

# The unit's stamps on the table's time: what a delay does to them, and a clock of its own.

SPEED = 30.0
LINK = station_file(VirtualStation(), SPEED, "host", 1, 2).unit_link


class Driver:
    """One frame a call, stamped by the unit's clock, that arrived some time (s) later."""

    bad_frames, is_off = 0, False

    def __init__(self, link: UnitLink, behind_s: float) -> None:
        self.link = link
        self.behind_s = behind_s
        self.arrived_s = self.delay_s = 0.0

    def take(self) -> tuple[np.ndarray, np.ndarray]:
        frames = np.zeros(1, no_samples(self.link.frame).dtype)
        frames["stamp"] = round((self.arrived_s * SPEED - self.behind_s) * 1e6)
        self.arrived_s += self.delay_s
        return frames, no_samples(self.link.frame)

    def lost(self, frames: np.ndarray) -> np.ndarray:
        return np.zeros(len(frames) - 1, dtype=np.int64)

    def stream(self, frames: np.ndarray, shift_us: int = 0) -> Any:
        return to_stream(frames, self.link.frame, shift_us)


def shift_s(line_s: list[float], answer_s: list[float], behind_s: float = 0.0) -> float:
    """What the stamps are moved by, where frames and answers of the table come so late (s)."""
    clock, driver = StationClock(), Driver(LINK, behind_s)
    clock.update(100.0 * SPEED - 60.0, 98.0)
    reader = UnitReader(cast(UnitDriver, driver), clock, lambda _: None)
    for place, (of_frame, of_answer) in enumerate(zip(line_s, answer_s, strict=True)):
        now_s = 100.0 + 0.2 * place
        clock.update((now_s - of_answer) * SPEED, now_s)
        driver.arrived_s, driver.delay_s = now_s, of_frame
        reader.take()
    return reader.clock_shifts_s[0]


@pytest.mark.parametrize(
    ("line_s", "answer_s"),
    [
        ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
        ([0.3, 0.4, 0.01], [0.0, 0.0, 0.0]),
        ([0.01, 0.01, 0.01], [0.0, 0.5, 0.0]),
        ([0.01, 0.3, 0.01], [0.4, 0.0, 0.4]),
    ],
)
def test_what_a_busy_computer_delays_moves_no_stamp(line_s, answer_s):
    assert shift_s(line_s, answer_s) == 0.0


@pytest.mark.parametrize("behind_s", [-12.0, 12.0])
def test_a_clock_of_its_own_is_put_on_the_tables_time(behind_s):
    found = shift_s([0.01, 0.05, 0.02], [0.0, 0.0, 0.01], behind_s)
    assert found == pytest.approx(behind_s, abs=1.6)


def test_the_clocks_difference_is_within_u_where_the_tables_answers_take_long():
    """A reading lies anywhere in its exchange; the unit's clock is the table's."""
    clock, driver, took_s = StationClock(), Driver(LINK, 0.0), 0.01
    clock.update(98.0 * SPEED, 98.0)
    reader = UnitReader(cast(UnitDriver, driver), clock, lambda _: None)
    for place in range(60):
        now_s = 100.0 + 0.2 * place
        clock.update((now_s - took_s * (place % 5) / 4.0) * SPEED, now_s, took_s)
        driver.arrived_s, driver.delay_s = now_s, 0.001
        reader.take()
    found = reader.compared()
    assert found is not None
    assert abs(found.offset_s) < 2.0 * found.u_offset_s
    assert found.u_offset_s == pytest.approx((took_s + 0.02) * SPEED / 12**0.5, rel=0.2)


# The unit's clock against the table's, by when its stamps arrived.

OFFSET_S, SKEW, DELAY_S = 0.2, 4e-5, 5e-3
STAMPS_S = np.arange(0.0, 600.0, 0.2)
NO_DOUBT_S = np.zeros(len(STAMPS_S))


def arrived(seed: int, least_s: float = 0.0) -> np.ndarray:
    delays = np.random.default_rng(seed).exponential(DELAY_S, len(STAMPS_S))
    return OFFSET_S + STAMPS_S * (1.0 + SKEW) + least_s + delays


@pytest.mark.parametrize("seed", range(8))
def test_offset_and_skew_are_found_under_delays_that_are_never_negative(seed):
    found = compared(STAMPS_S, arrived(seed), NO_DOUBT_S)
    assert found is not None
    at_start_s = found.offset_s - found.skew * found.at_s
    assert at_start_s == pytest.approx(OFFSET_S, abs=2e-4)
    assert abs(found.skew - SKEW) < 5.0 * found.u_skew
    assert 0.0 < found.u_offset_s < 1e-4


@pytest.mark.parametrize("least_s", [0.0, 0.2, 0.5])
def test_the_offset_is_within_u_whatever_the_least_delay_up_to_the_doubt(least_s):
    """Thirty times the clock: a frame that comes 16 ms after its stamp comes half a second late."""
    found = compared(STAMPS_S, arrived(3, least_s), NO_DOUBT_S + 0.5)
    assert found is not None
    at_start_s = found.offset_s - found.skew * found.at_s
    assert abs(at_start_s - OFFSET_S) < 2.0 * found.u_offset_s
    assert found.u_offset_s < 0.2
    assert abs(found.skew - SKEW) < 5.0 * found.u_skew


def test_answers_of_the_table_that_take_long_are_not_taken_for_an_offset():
    """A reading that is believed to be of the answer's time is early by up to the whole exchange:
    the latest that it can have been is not."""
    took_s = np.random.default_rng(5).uniform(0.01, 0.4, len(STAMPS_S))
    read_late_s = took_s * np.random.default_rng(6).uniform(0.0, 1.0, len(STAMPS_S))
    found = compared(STAMPS_S, arrived(4) - read_late_s + took_s, took_s)
    assert found is not None
    at_start_s = found.offset_s - found.skew * found.at_s
    assert abs(at_start_s - OFFSET_S) < 2.0 * found.u_offset_s < 0.1


def test_a_clock_without_delays_is_compared_exactly():
    found = compared(STAMPS_S, OFFSET_S + STAMPS_S * (1.0 + SKEW), NO_DOUBT_S)
    assert found is not None
    assert found.skew == pytest.approx(SKEW, rel=1e-6)
    assert found.u_offset_s < 1e-9


@pytest.mark.parametrize("count", [0, 1, 3])
def test_too_few_stamps_say_nothing(count):
    assert compared(STAMPS_S[:count], STAMPS_S[:count], NO_DOUBT_S[:count]) is None


# Drivers in a thread of their own: encoders are fetched while the run's own loop is held up.


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
