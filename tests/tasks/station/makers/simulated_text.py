"""A station behind a controller of text, in simulated time: late and lost answers, a busy computer.

The product's own driver talks to the emulated controller through a port in pyserial's place.
"""

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import pytest

from schemas.procedure import Procedure
from schemas.station import StationFile
from tasks.station.acquisition import Acquired, NewRecording, RunRequest, run
from tasks.station.clock import wall_s
from tasks.station.connected_station import Bench
from tasks.station.drivers.table import DescribedTable
from tasks.station.drivers.text_device import TextBackend, TextLink
from tasks.station.drivers.unit import UnitDriver
from tasks.station.ports import Climate
from tasks.station.virtual.config import VirtualStation, station_file
from tasks.station.virtual.simulation import Simulation
from tests.simulated_time import run_simulated
from tests.tasks.station.in_memory import InMemoryLine
from tests.tasks.station.makers.motion import Axes

SLICE_S = 0.1  # in which time passes where nobody asks
STEPS_S = 1000


class Controller(Protocol):
    """terminator: what ends a line that it takes."""

    terminator: bytes

    def hear(self, line: bytes) -> bytes: ...


@dataclass
class Line:
    """What is wrong with the line and the computer.

    latency_s: an exchange takes twice as long at most. lost: the share of answers that never come.
    busy: the share of exchanges in which the computer does something else, for up to busy_s.
    """

    baudrate: int = 0
    latency_s: float = 0.004
    lost: float = 0.0
    busy: float = 0.0
    busy_s: float = 1.5
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(46))

    def delays_s(self) -> tuple[float, float]:
        """Before the controller hears a line, and after it answered."""
        before, after = self.rng.uniform(0.0, self.latency_s, 2)
        late = self.rng.uniform(0.0, self.busy_s, 2) * (self.rng.uniform(size=2) < self.busy / 2)
        return before + late[0], after + late[1]


class EmulatedPort:
    """In the place of a port of pyserial; `took_s` is what reading and writing would have taken."""

    def __init__(self, controller: Controller, line: Line, timeout_s: float) -> None:
        self._controller, self._line, self._timeout_s = controller, line, timeout_s
        self._heard, self._answers = b"", b""
        self.took_s = 0.0

    def write(self, data: bytes) -> None:
        self._take(data)
        *lines, self._heard = (self._heard + data).split(self._controller.terminator)
        for each in lines:
            answer = self._controller.hear(each)
            if self._line.rng.uniform() >= self._line.lost:
                self._answers += answer

    def read_until(self, end: bytes, most: int) -> bytes:
        place = self._answers.find(end)
        if place < 0:
            self.took_s += self._timeout_s
            return self._answers
        answer, self._answers = self._answers[: place + len(end)], self._answers[place + len(end) :]
        self._take(answer)
        return answer

    def reset_input_buffer(self) -> None:
        self._answers = b""

    def close(self) -> None:
        self._answers = b""

    def _take(self, data: bytes) -> None:
        if self._line.baudrate:
            self.took_s += 10 * len(data) / self._line.baudrate


class EmulatedLink(TextLink):
    """A link whose exchanges take simulated time, in the loop instead of a thread."""

    def __init__(self, described: Any, line: Line, moved: Callable[[], None]) -> None:
        super().__init__(described)
        self._line, self._moved = line, moved

    async def _in_thread(self, line: str, is_answered: bool) -> str | None:
        before_s, after_s = self._line.delays_s()
        await asyncio.sleep(before_s)
        self._moved()
        port = self._connected()
        began_s = port.took_s
        answer = self._exchange(line, is_answered)
        await asyncio.sleep(after_s + port.took_s - began_s)
        return answer


class Air:
    """A thermometer that reports no time."""

    async def climate(self) -> Climate:
        return Climate(float("nan"), 20.0, 45.0, 5.0, float("nan"))

    async def set_temperature(self, degc: float) -> None:
        raise NotImplementedError


class EmulatedStation:
    """One run on a table behind a controller; `make` makes it of the table's axes and a clock.

    table: that of a station file.
    """

    def __init__(
        self,
        config: VirtualStation,
        table: dict[str, Any],
        make: Callable[[Axes, Callable[[], float]], Controller],
        line: Line,
    ) -> None:
        self.simulation = Simulation(config)
        own = station_file(config, 1.0, "in-memory", 1, 1).model_dump()
        own["fixture"] = "by_hand"
        self.file = StationFile.model_validate(own | {"table": table})
        self.controller = make(Axes(self.simulation.table), lambda: self.simulation.table.now)
        self._line, self._unit = line, InMemoryLine()

    def _moved(self) -> None:
        """Time passes up to now."""
        while (steps := int(wall_s() * 1000) - self.simulation.table.steps) > 0:
            if sent := self.simulation.advance(min(steps, STEPS_S)):
                self._unit.send(b"".join(sent))

    def acquire(self, procedure: Procedure, sink: Any) -> Acquired:
        """The run of a procedure. Raises as `tasks.station.acquisition.acquire` does."""
        recording = NewRecording(self.file, sink, "emulated")
        request = RunRequest(self.file, procedure, (recording,), lambda progress: None)
        with self._ports():
            (acquired,) = run_simulated(self._run(request))
        return acquired

    @contextmanager
    def _ports(self) -> Iterator[None]:
        def opened(url: str, timeout: float, **_: Any) -> EmulatedPort:
            return EmulatedPort(self.controller, self._line, timeout)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("serial.serial_for_url", opened)
            yield

    async def _run(self, request: RunRequest) -> tuple[Acquired, ...]:
        described: Any = self.file.table
        names = tuple(axis.name for axis in self.file.station.table_axes or ())
        link = EmulatedLink(described, self._line, self._moved)
        table = DescribedTable(described, TextBackend(described, link, len(names)), names)
        unit = UnitDriver(self.file.unit_link, self._unit)
        bench = Bench(table, Air(), None, (unit,), beside=_here)
        keeper = asyncio.ensure_future(self._keep())
        try:
            return await run(request, bench)
        finally:
            await asyncio.sleep(3.0)  # for the table to come to rest
            self._moved()
            keeper.cancel()
            await asyncio.gather(keeper, return_exceptions=True)

    async def _keep(self) -> None:
        while True:
            self._moved()
            await asyncio.sleep(SLICE_S)


async def _here(work: Any) -> None:
    await work
