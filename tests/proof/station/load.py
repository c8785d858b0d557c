"""A virtual station whose computer is busy with other work: its answers come late, in bouts.

The table and the unit stamp what they send, so that lateness moves no stamp. But encoder samples
are fetched, block after block over one link, from a ring that holds the newest: a client that is
kept waiting falls behind, loses what is overwritten, and at the end has not fetched the last.
"""

import asyncio

import numpy as np

from tasks.station.clock import wall_s
from tasks.station.ports import EncoderBlock, TableState
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.simulation import Simulation
from tests.tasks.station.in_memory import InMemoryStation, InMemoryTable

BOUT_S = 0.4  # wall time that the computer is busy, and then is not, on average
LATE_S = 0.01  # that an answer takes on average where it is busy


class BusyTable(InMemoryTable):
    """Answers one request after another, as over one link."""

    def __init__(self, simulation: Simulation, rng: np.random.Generator) -> None:
        super().__init__(simulation)
        self._rng = rng
        self._link = asyncio.Lock()
        self._is_busy = bool(rng.integers(2))
        self._until_s = 0.0

    async def state(self) -> TableState:
        async with self._link:
            await self._wait()
            return await super().state()

    async def encoder(self, first: int) -> EncoderBlock:
        async with self._link:
            await self._wait()
            return await super().encoder(first)

    async def _wait(self) -> None:
        while wall_s() > self._until_s:
            self._is_busy = not self._is_busy
            self._until_s += self._rng.exponential(BOUT_S)
        if self._is_busy:
            await asyncio.sleep(self._rng.exponential(LATE_S))


class BusyStation(InMemoryStation):
    """seed: of when it is busy, and for how long."""

    def __init__(self, config: VirtualStation, speed: float, seed: int) -> None:
        super().__init__(config, speed)
        rng = np.random.default_rng(np.random.SeedSequence((seed, 50)))
        self.table = BusyTable(self.simulation, rng)
