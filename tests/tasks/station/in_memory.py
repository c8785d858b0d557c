"""A virtual station in this process and in simulated time: the ports, with nothing between."""

import asyncio
from collections.abc import Callable, Coroutine, Iterable
from typing import Any

import numpy as np

from schemas.procedure import Procedure, Refix
from schemas.station import StationFile
from tasks.station.acquisition import Acquired, NewRecording, Progress, RunRequest, run
from tasks.station.clock import wall_s
from tasks.station.connected_station import Bench, ByHand
from tasks.station.drivers.unit import UnitDriver
from tasks.station.ports import (
    TRIPS,
    AxisState,
    Climate,
    EncoderBlock,
    TableState,
    check_trips,
)
from tasks.station.virtual.config import (
    AXIS_STATUS,
    CAPTURE_VALUES,
    MODES,
    TABLE_STATUS,
    VirtualStation,
    station_file,
)
from tasks.station.virtual.faults import StationFault
from tasks.station.virtual.servers import keep_time
from tasks.station.virtual.simulation import Simulation
from tests.simulated_time import run_simulated

DEGREE = np.pi / 180.0


def _trips(status: int, bits: dict[str, int]) -> frozenset[str]:
    return frozenset(trip for trip in TRIPS if status & bits.get(trip, 0))


class InMemoryTable:
    """The port of a table over the virtual one."""

    time_half_width_s = 0.0

    def __init__(self, simulation: Simulation) -> None:
        design = simulation.config.table
        self.names = tuple(axis.name for axis in design.axes)
        self.period_us = design.capture_ms * 1000
        self.block_samples = CAPTURE_VALUES // len(self.names)
        self.has_been_left = False
        self._table = simulation.table
        self._rad = 2.0 * np.pi / design.counts_per_turn

    async def home(self) -> None:
        check_trips(await self.state(), self.names)

    async def move_to(self, axis: int, angle: float, rate: float, acceleration: float) -> None:
        self._table.drives[axis].target_angle = angle * DEGREE
        self._start(axis, "angle", rate, acceleration)

    async def turn_at(self, axis: int, rate: float, acceleration: float) -> None:
        self._start(axis, "rate", rate, acceleration)

    async def stop(self, axis: int) -> None:
        self._table.command(axis, MODES["stop"])

    async def leave(self) -> None:
        self._table.stop()
        self.has_been_left = True

    async def state(self) -> TableState:
        return TableState(
            station_s=self._table.now,
            wall_s=wall_s(),
            axes=tuple(self._axis(axis) for axis in range(len(self.names))),
            trips=_trips(self._table.status(), TABLE_STATUS),
        )

    async def encoder(self, first: int) -> EncoderBlock:
        first, counts = self._table.capture(first, self.block_samples)
        t = (np.arange(len(counts)) + first) * self.period_us / 1e6
        return EncoderBlock(first, counts * self._rad, t)

    def _axis(self, axis: int) -> AxisState:
        status = self._table.axis_status(axis)
        return AxisState(
            angle_deg=self._table.angle[axis] / DEGREE,
            rate_deg_s=self._table.rate[axis] / DEGREE,
            is_moving=bool(status & AXIS_STATUS["moving"]),
            is_settled=bool(status & AXIS_STATUS["settled"]),
            trips=_trips(status, AXIS_STATUS),
        )

    def _start(self, axis: int, mode: str, rate: float, acceleration: float) -> None:
        drive = self._table.drives[axis]
        drive.target_rate, drive.acceleration_limit = rate * DEGREE, acceleration * DEGREE
        self._table.command(axis, MODES[mode])


class InMemoryChamber:
    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation

    async def climate(self) -> Climate:
        air = self._simulation.air
        return Climate(
            self._simulation.table.now, air.temperature_degc, air.humidity_percent,
            air.supply_v, air.pressure_hpa,
        )  # fmt: skip

    async def set_temperature(self, degc: float) -> None:
        self._simulation.chamber.go_to(self._simulation.table.now, degc)


class InMemoryFixture:
    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation

    async def turn(self, refix: Refix) -> float | None:
        simulation = self._simulation
        if refix.power_off:
            simulation.supply(False)
        simulation.fixture.wanted[:] = refix.mount.quaternion_wxyz
        simulation.turn_fixture()
        while simulation.table.now < simulation.fixture.still_since():
            await asyncio.sleep(0.02)
        if not refix.power_off:
            return None
        simulation.supply(True)
        return simulation.table.now


class InMemoryLine:
    """What the unit sends, as soon as it sends it."""

    broken = None

    def __init__(self) -> None:
        self._chunks: list[bytes] = []
        self._arrived_s = 0.0

    def send(self, data: bytes) -> None:
        self._chunks.append(data)
        self._arrived_s = wall_s()

    def received(self) -> tuple[bytes, float]:
        chunks, self._chunks = self._chunks, []
        return b"".join(chunks), self._arrived_s

    def end(self) -> None:
        pass


async def _here(work: Coroutine[Any, Any, None]) -> None:
    await work


class InMemoryStation:
    """One run after another on a virtual station; `speed`: station seconds in a wall second.

    ask: has a person turn the unit over, who gets the simulated fixture to do it with; else the
    station does it.
    """

    def __init__(
        self, config: VirtualStation, speed: float = 50.0, faults: Iterable[StationFault] = ()
    ) -> None:
        lines = range(1, 2 + len(config.neighbours))
        self.file: StationFile = station_file(config, speed, "in-memory", 1, *lines)
        self.simulation = Simulation(config, faults)
        self.simulation.advance(1)
        self.table = InMemoryTable(self.simulation)
        self.fixture = InMemoryFixture(self.simulation)
        self.duration_s = 0.0  # wall time that the last run would have taken
        self._speed = speed

    def acquire(
        self,
        procedure: Procedure,
        sink: Any,
        report: Callable[[Any], None] = lambda progress: None,
        file: StationFile | None = None,
        ask: Any = None,
    ) -> Acquired:
        """The run of a procedure. Raises as `tasks.station.acquisition.acquire` does."""
        station = file or self.file
        recording = NewRecording(station, sink, "in memory")
        (acquired,) = self.run(RunRequest(station, procedure, (recording,), report, ask))
        return acquired

    def run(self, request: RunRequest) -> tuple[Acquired, ...]:
        """In the place of `tasks.station.acquisition.acquire`."""
        return run_simulated(self._run(request))

    async def _run(self, request: RunRequest) -> tuple[Acquired, ...]:
        lines = [InMemoryLine() for _ in request.recordings]

        def to_neighbours() -> None:
            for line, data in zip(lines[1:], self.simulation.neighbours_sent(), strict=False):
                line.send(data)

        time_passes = asyncio.ensure_future(
            keep_time(self.simulation, self._speed, lines[0].send, to_neighbours)
        )
        fixture = self.fixture if request.ask is None else ByHand(request.ask)
        chamber = InMemoryChamber(self.simulation)
        units = tuple(
            UnitDriver(recording.station.unit_link, line)
            for recording, line in zip(request.recordings, lines, strict=True)
        )
        bench = Bench(self.table, chamber, fixture, units, beside=_here)
        try:
            return await run(request, bench)
        finally:
            self.duration_s = wall_s()
            time_passes.cancel()
            await asyncio.gather(time_passes, return_exceptions=True)


def spoils_once(station: InMemoryStation) -> Callable[[Progress], None]:
    """A watcher of a run that lets the unit drop samples the first time it turns at -50 deg/s."""
    begun: list[str] = []

    def spoil(progress: Progress) -> None:
        begun.append(progress.now)
        first = progress.now == "rate x -50 deg/s" and "rate x +100 deg/s" not in begun
        station.simulation.faults = (StationFault("unit_drops"),) if first else ()

    return spoil
