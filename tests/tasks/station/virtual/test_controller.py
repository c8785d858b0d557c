"""The controller without a network: who holds the table, the watchdog, and time that waits."""

import asyncio
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Any

import pytest
from pymodbus.constants import ExcCodes

from tasks.station.virtual import registers as under_test
from tasks.station.virtual.config import COMMANDS, TABLE_STATUS, VirtualStation
from tasks.station.virtual.servers import IdleClock, Pace, keep_time
from tasks.station.virtual.simulation import Simulation
from tests.simulated_time import run_simulated

WATCHDOG, COMMAND, MODE, CAPTURE_FROM = 8, 9, 16, 100  # addresses of device 1
RESET, STOP, TURN = 1, 2, 2
BUSY = ExcCodes.DEVICE_BUSY


@dataclass
class Client:
    """One connection, which asks a controller."""

    ask: Callable[..., Coroutine[Any, Any, ExcCodes | None]]
    connected: bool = True

    def is_active(self) -> bool:
        return self.connected

    async def read(self, address: int = 0) -> list[int]:
        under_test.client.set(self)  # type: ignore[arg-type]
        words = [0] * 300
        assert await self.ask(3, address, address, 4, words, None) is None
        return words

    async def write(self, address: int, *words: int) -> ExcCodes | None:
        under_test.client.set(self)  # type: ignore[arg-type]
        return await self.ask(16, address, address, len(words), [0] * 300, list(words))


@pytest.fixture
def simulation() -> Simulation:
    return Simulation(VirtualStation())


def with_two_clients(
    simulation: Simulation, work: Callable[[Client, Client], Coroutine[Any, Any, Any]]
) -> Any:
    """What the work gives with two clients of a controller whose clock runs."""

    async def run() -> Any:
        controller = under_test.Controller(simulation)
        ask = controller.devices()[0].action
        time_passes = asyncio.ensure_future(
            keep_time(simulation, 100.0, lambda data: None, controller.watch)
        )
        try:
            return await work(Client(ask), Client(ask))
        finally:
            time_passes.cancel()

    return run_simulated(run())


async def has_bitten(client: Client) -> bool:
    return bool((await client.read())[3] & TABLE_STATUS["watchdog"])


def test_the_watchdog_bites_after_a_silence_and_not_while_it_is_polled(simulation):
    async def work(holder: Client, _: Client) -> list[bool]:
        await holder.write(WATCHDOG, 1000)
        bitten = []
        for silence_s in (*[0.9] * 5, 1.1):
            await asyncio.sleep(silence_s)
            bitten.append(await has_bitten(holder))
        return bitten

    assert with_two_clients(simulation, work) == [False] * 5 + [True]


@pytest.mark.parametrize("is_killed", [True, False])
def test_the_watchdog_bites_however_much_another_client_polls(simulation, is_killed):
    async def work(holder: Client, other: Client) -> list[bool]:
        await holder.write(WATCHDOG, 1000)
        holder.connected = not is_killed
        bitten = []
        for _ in range(15):
            await asyncio.sleep(0.1)
            bitten.append(await has_bitten(other))
        return bitten

    bitten = with_two_clients(simulation, work)
    assert not any(bitten[:9])
    assert all(bitten[11:])


def test_fetching_encoders_is_no_sign_of_life(simulation):
    async def work(holder: Client, _: Client) -> bool:
        await holder.write(WATCHDOG, 1000)
        for _ in range(15):
            await asyncio.sleep(0.1)
            await holder.write(CAPTURE_FROM, 0, 1)
            await holder.read(CAPTURE_FROM + 2)
        return await has_bitten(holder)

    assert with_two_clients(simulation, work)


def test_nobody_else_commands_a_table_that_is_held_but_anybody_stops_it(simulation):
    async def work(holder: Client, other: Client) -> None:
        assert await holder.write(WATCHDOG, 1000) is None
        for address, word in ((MODE, TURN), (COMMAND, RESET), (WATCHDOG, 0), (WATCHDOG, 9000)):
            assert await other.write(address, word) == BUSY
        assert await other.write(CAPTURE_FROM, 0, 5) is None
        assert await holder.write(MODE, TURN) is None
        assert simulation.table.drives[0].mode == TURN
        for stop in (STOP, COMMANDS["quick_stop"]):
            assert await holder.write(MODE, TURN) is None
            assert await other.write(COMMAND, stop) is None
            assert simulation.table.drives[0].mode == 3

    with_two_clients(simulation, work)


@pytest.mark.parametrize("ends_by", ["watchdog 0", "hanging up", "a bite"])
def test_a_table_that_is_held_no_more_is_for_others(simulation, ends_by):
    async def work(holder: Client, other: Client) -> None:
        await holder.write(WATCHDOG, 1000)
        if ends_by == "watchdog 0":
            await holder.write(WATCHDOG, 0)
        elif ends_by == "hanging up":
            holder.connected = False
        else:
            await asyncio.sleep(1.5)
        assert await other.write(COMMAND, RESET) is None
        assert await other.write(WATCHDOG, 1000) is None
        assert await holder.write(MODE, TURN) == BUSY

    with_two_clients(simulation, work)


def captured_until(simulation: Simulation) -> int:
    return simulation.table.steps // simulation.config.table.capture_ms


def test_time_stands_still_rather_than_overwrite_what_is_still_wanted(simulation):
    kept = simulation.config.table.capture_kept

    async def work(reader: Client, _: Client) -> None:
        await reader.write(WATCHDOG, 60_000)
        await reader.write(CAPTURE_FROM, 0, 100)
        await asyncio.sleep(5.0)  # 500 s of the station, were it not held
        assert captured_until(simulation) == 100 + kept - 1
        await reader.write(CAPTURE_FROM, 0, 200)
        await asyncio.sleep(5.0)
        assert captured_until(simulation) == 200 + kept - 1
        assert simulation.table.capture(200, 1)[0] == 200

    with_two_clients(simulation, work)


def test_who_only_tries_the_table_does_not_hold_the_time_of_the_unit(simulation):
    """Else a unit that is tried after the encoders sends nothing (`station check` at 30 times)."""

    async def work(reader: Client, _: Client) -> None:
        await reader.write(CAPTURE_FROM, 0, 100)
        await asyncio.sleep(2.0 + under_test.TRIED_S)
        assert captured_until(simulation) > 100 + simulation.config.table.capture_kept

    with_two_clients(simulation, work)


@pytest.mark.parametrize("ends_by", ["fetching no more", "watchdog 0", "a bite"])
def test_a_client_that_fetches_no_more_does_not_hold_time_for_ever(simulation, ends_by):
    async def work(reader: Client, _: Client) -> None:
        if ends_by != "fetching no more":
            await reader.write(WATCHDOG, 1000)
        await reader.write(CAPTURE_FROM, 0, 100)
        if ends_by == "watchdog 0":
            await reader.write(WATCHDOG, 0)
        await asyncio.sleep(5.0 + (under_test.WANTED_S if ends_by == "fetching no more" else 0.0))
        assert captured_until(simulation) > 2 * simulation.config.table.capture_kept

    with_two_clients(simulation, work)


def test_time_stands_still_while_the_client_connects_again(simulation):
    async def work(reader: Client, again: Client) -> None:
        await reader.write(WATCHDOG, 5000)
        await reader.write(CAPTURE_FROM, 0, 100)
        await asyncio.sleep(2.0)
        reader.connected = False
        await asyncio.sleep(2.0)
        await again.write(WATCHDOG, 5000)
        assert simulation.table.capture(100, 1)[0] == 100

    with_two_clients(simulation, work)


def test_a_pause_of_the_station_itself_is_no_silence(simulation):
    async def work(holder: Client, _: Client) -> bool:
        await holder.write(WATCHDOG, 1000)
        loop: Any = asyncio.get_running_loop()
        loop._simulated.now_s += 60.0  # it was stopped meanwhile
        await asyncio.sleep(0.05)
        return await has_bitten(holder)

    assert not with_two_clients(simulation, work)


def test_an_idle_station_wakes_seldom_and_its_time_is_the_present_one_for_whoever_asks(simulation):
    slices = []

    async def run() -> float:
        doze = IdleClock(lambda: simulation.is_still)
        time_passes = asyncio.ensure_future(
            keep_time(simulation, 10.0, lambda data: None, lambda: slices.append(1), doze)
        )
        try:
            await asyncio.sleep(20.03)
            await doze.wake()
            return simulation.table.now
        finally:
            time_passes.cancel()

    assert run_simulated(run()) == pytest.approx(200.3, abs=0.1)
    assert len(slices) < 1000  # of 4000, were it not idle


def test_a_machine_that_comes_late_slows_its_clock_and_soon_takes_it_up_again(caplog):
    pace = Pace(60.0)
    pace.note(0.001, 0.005, 0.05)
    assert pace.speed == 60.0
    for _ in range(100):
        pace.note(0.05, 0.055, 0.55)  # 50 ms late: at 60 times 3 s of station time
    assert pace.speed == pytest.approx(10.0)
    assert [each.message for each in caplog.records] == [
        "this machine gives 10.0 times real time in place of 60"
    ]
    for _ in range(500):
        pace.note(0.0, 0.01, 0.6)
    assert pace.speed == 60.0
    busy = Pace(60.0)
    for _ in range(100):
        busy.note(0.0, 0.05, 0.2)  # in time, and with more to do than it can
    assert caplog.records[-1].message == "this machine gives 4.0 times real time in place of 60"


# The registers of the virtual station without a network: the encoder ring.


def test_the_ring_keeps_a_minute_and_starts_at_its_oldest(in_memory):
    console = in_memory("spike@1000")

    def block(first: int) -> tuple[int, int]:
        console.write("capture_from", first)
        return int(console.read("capture_first")), int(console.read("capture_count"))

    console.wait(65.0)
    newest = int(console.read("station_time")) // 10_000
    assert block(newest - 6000) == (newest - 6000, 19)
    console.wait(25.0)
    newest = int(console.read("station_time")) // 10_000
    oldest, count = block(0)
    assert 0 < oldest <= newest - 6000
    assert count == 19
