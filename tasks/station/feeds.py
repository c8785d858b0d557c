"""The three flows of a run: each gathers what comes, and gives it as a stream when asked."""

import asyncio
import math
from collections.abc import Callable

import numpy as np

from schemas.procedure import EnvironmentLimits
from schemas.recording import Stream
from tasks.station.chamber import COLUMNS, Climate, read_climate
from tasks.station.clock import StationClock
from tasks.station.findings import Finding
from tasks.station.frames import RECORDS, lost_between, to_stream
from tasks.station.modbus import Link
from tasks.station.table import Block, Table
from tasks.station.unit import Unit

Say = Callable[[Finding], None]
CLOCK_OFF_S = 0.5
CLOCK_WALL_S = 0.1  # what a busy machine may delay a frame by, on the wall
SHIFT_TAKES = 3


class EncoderFeed:
    """Captured encoder angles, contiguous: a gap in the numbers is said and never bridged."""

    def __init__(self, table: Table, clock: StationClock, say: Say) -> None:
        self._table = table
        self._clock = clock
        self._say = say
        self._blocks: list[Block] = []
        self._read: np.ndarray | None = None
        self._counts = np.zeros(len(table.names), np.int64)

    async def run(self) -> None:
        """Fetch blocks for ever, as fast as they fill."""
        period_s = self._table.period_us / 1e6
        wanted = math.floor(self._clock.station_s / period_s)
        while True:
            block = await self._table.captured(wanted)
            count = len(block.counts)
            if count:
                self._note_gap(wanted, block.first)
                self._blocks.append(block)
                wanted = block.first + count
            if count < self._table.block_samples:
                fill_s = period_s * (self._table.block_samples - 4)
                await asyncio.sleep(self._clock.wall(fill_s, 0.001, 0.2))

    def take(self) -> Stream:
        """Angles in rad, columns <axis>_angle, over station time."""
        blocks, self._blocks = self._blocks, []
        numbers = [np.arange(len(block.counts)) + block.first for block in blocks]
        ticks = np.concatenate([np.empty(0, np.int64), *numbers])
        counts = self._past_turnover([block.counts for block in blocks])
        angles = counts * (2 * np.pi / np.array(self._table.counts_per_turn))
        return Stream(
            t=ticks * self._table.period_us / 1e6,
            columns={
                f"{name}_angle": angles[:, axis] for axis, name in enumerate(self._table.names)
            },
        )

    def _past_turnover(self, blocks: list[np.ndarray]) -> np.ndarray:
        """Counts that run on where the register (int32) turns over, (n, axes)."""
        if not blocks:
            return np.empty((0, len(self._table.names)))
        if self._read is None:
            self._read = self._counts = blocks[0][0]
        read = np.concatenate([self._read[None], *blocks])
        steps = (np.diff(read, axis=0) + 2**31) % 2**32 - 2**31
        counts = self._counts + np.cumsum(steps, axis=0)
        self._read, self._counts = read[-1], counts[-1]
        return counts

    def _note_gap(self, wanted: int, first: int) -> None:
        if first > wanted:
            period_s = self._table.period_us / 1e6
            span = (wanted * period_s, first * period_s)
            self._say(Finding("encoder_gap", *span, amount=first - wanted))


class ClimateFeed:
    """The chamber, about once a station second, held against the procedure's limits."""

    def __init__(
        self, link: Link, clock: StationClock, limits: EnvironmentLimits, say: Say
    ) -> None:
        self._link = link
        self._clock = clock
        self._limits = limits
        self._say = say
        self._last_s = -math.inf
        self._readings: list[Climate] = []

    async def run(self) -> None:
        """Read for ever."""
        while True:
            climate = await read_climate(self._link)
            if climate.t > self._last_s:
                self._last_s = climate.t
                self._readings.append(climate)
                self._compare(climate)
            await asyncio.sleep(self._clock.wall(1.0, 0.01, 1.0))

    def take(self) -> Stream:
        """Temperature, humidity, supply voltage and pressure over station time."""
        readings, self._readings = self._readings, []
        values = np.array([reading.values for reading in readings]).reshape(-1, len(COLUMNS))
        return Stream(
            t=np.array([reading.t for reading in readings]),
            columns=dict(zip(COLUMNS, values.T, strict=True)),
        )

    def _compare(self, climate: Climate) -> None:
        ranges = (
            ("air_temperature", climate.values[0], self._limits.temperature_degc),
            ("air_humidity", climate.values[1], self._limits.humidity_percent),
        )
        for code, value, (low, high) in ranges:
            if not low <= value <= high:
                self._say(Finding(code, climate.t, climate.t, value))


class UnitFeed:
    """The unit's samples over its own time stamps, moved only if its clock is not the station's.

    `shifts_s` is by how much they were moved, for each time the unit was switched on: first 0,
    unless the first stamps disagree with station time by more than CLOCK_OFF_S (and by more than
    the delay of the line can explain).
    """

    def __init__(self, unit: Unit, clock: StationClock, say: Say) -> None:
        self.shifts_s = [0.0]
        self.lost_samples = 0
        self._unit = unit
        self._clock = clock
        self._say = say
        self._taken_s = clock.station_s
        self._is_off = False
        self._on_s: float | None = None
        self._begin()

    def _begin(self) -> None:
        none = np.empty(0, RECORDS[self._unit.link.frame])
        self._differences: list[float] = []
        self._decided = False
        self._held = self._last = none

    def switched_off(self) -> None:
        """The unit is to be switched off: it may be silent now."""
        self._is_off = True
        self._unit.switched_off()

    def switched_on(self, station_s: float | None) -> None:
        """It was switched on again, at a station time (s) where that is known."""
        self._is_off, self._on_s = False, station_s
        self._unit.switched_on()

    def take(self, final: bool = False) -> Stream:
        """What came since; nothing while the first stamps are still being compared."""
        bad_before = self._unit.bad_frames
        before, after = self._unit.take()
        self._note_bad(self._unit.bad_frames - bad_before)
        stream = self._timed(before, final)
        if not len(after):
            return stream
        self._begin()
        self.shifts_s.append(0.0)
        return _joined(stream, self._timed(after, final))

    def _timed(self, frames: np.ndarray, final: bool) -> Stream:
        link = self._unit.link
        if not self._decided:
            self._compare(frames)
            frames = self._held = np.concatenate([self._held, frames])
            told = self._on_s is not None and len(self.shifts_s) > 1
            enough = told or len(self._differences) >= SHIFT_TAKES
            self._decided = final or (enough and not self._is_off)
            if not self._decided:
                return to_stream(frames[:0], link)
            self._settle_shift(self._on_s if told else None)
        stream = to_stream(frames, link, round(self.shifts_s[-1] * 1e6))
        self._note_lost(np.concatenate([self._last, frames]))
        if len(frames):
            self._last = frames[-1:]
        return stream

    def _compare(self, frames: np.ndarray) -> None:
        if len(frames):
            station_s = self._clock.at(self._unit.arrived_s)
            self._differences.append(station_s - frames["stamp"][-1] / 1e6)

    def _settle_shift(self, told_s: float | None) -> None:
        """The delay of the line makes every difference too large, so the least is the best."""
        if told_s is not None:
            self.shifts_s[-1] = told_s
        elif self._differences:
            best = min(self._differences)
            if abs(best) > CLOCK_OFF_S + CLOCK_WALL_S * self._clock.speed:
                self.shifts_s[-1] = round(best, 6)

    def _note_lost(self, frames: np.ndarray) -> None:
        lost = lost_between(frames["counter"])
        for place in np.flatnonzero(lost):
            before, after = frames["stamp"][place : place + 2] / 1e6 + self.shifts_s[-1]
            self.lost_samples += int(lost[place])
            self._say(Finding("unit_lost_samples", before, after, int(lost[place])))

    def _note_bad(self, bad: int) -> None:
        now_s = self._clock.station_s
        if bad:
            self._say(Finding("unit_bad_frames", self._taken_s, now_s, bad))
        self._taken_s = now_s


def _joined(one: Stream, other: Stream) -> Stream:
    return Stream(
        np.concatenate([one.t, other.t]),
        {name: np.concatenate([one.columns[name], other.columns[name]]) for name in other.columns},
    )
