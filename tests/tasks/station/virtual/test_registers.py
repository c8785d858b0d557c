"""The registers of the virtual station without a network: the encoder ring, and the watchdog."""

import asyncio

from schemas.station import TABLE_STATUS
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.servers import Controller
from tasks.station.virtual.simulation import Simulation
from tests.simulated_time import run_simulated

WATCHDOG = TABLE_STATUS["watchdog"]


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


def test_the_watchdog_bites_after_a_silence_and_not_while_it_is_polled():
    async def run() -> list[bool]:
        simulation = Simulation(VirtualStation())
        controller = Controller(simulation)
        table = controller.devices()[0]

        async def look() -> bool:
            words = [0] * 300
            assert await table.action(3, 0, 0, 4, words, None) is None
            return bool(words[3] & WATCHDOG)

        assert await table.action(16, 8, 8, 1, [0] * 300, [1000]) is None  # ms, register 8
        bitten = []
        for silence_s in (*[0.9] * 5, 1.1):
            await asyncio.sleep(silence_s)
            controller.watch()
            bitten.append(await look())
        return bitten

    assert run_simulated(run()) == [False] * 5 + [True]
