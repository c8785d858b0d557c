"""Stream readers of a run: they collect samples and return them as a stream on request."""

import asyncio
import math
from collections import deque
from collections.abc import Callable
from dataclasses import astuple, dataclass, field, fields, replace

import numpy as np

from schemas.procedure import EnvironmentLimits
from schemas.recording import Stream, joined
from schemas.unit_link import ClockComparison
from tasks.station.clock import StationClock, wall_s
from tasks.station.drivers.unit import UnitDriver, no_samples
from tasks.station.monitor import Anomaly
from tasks.station.ports import Chamber, Climate, EncoderBlock, Table

BLOCKS = 12  # spans of time of which the least delay counts
FEWEST = 4
Note = Callable[[Anomaly], None]
CLIMATE = tuple(each.name for each in fields(Climate))
MOST_BLOCKS = 2**15
FULL_WALL_S = 0.05
SHIFT_THRESHOLD_S = 0.5
LINE_DELAY_WALL_S = 0.1  # what a busy machine may delay a frame by, on the wall
# No frame need come sooner after its stamp: a USB converter's latency timer, 16 ms from the factory
# (FTDI AN232B-04), and a long frame at 115,200 baud.
LEAST_DELAY_WALL_S = 0.02
SHIFT_TAKES = 3


@dataclass
class EncoderReader:
    """Encoder angles, contiguous: a gap in the sample numbers is noted and never bridged.

    `run` may run in another thread than `take`. What is not taken waits, up to MOST_BLOCKS (some
    25 MB, an hour and a half at 100 Hz); then no more is fetched, and the table keeps what it can.
    """

    table: Table
    clock: StationClock
    note: Note
    blocks: deque[EncoderBlock] = field(default_factory=deque)

    async def run(self) -> None:
        """Fetch blocks for ever, as fast as they fill."""
        period_s = self.table.period_us / 1e6
        wanted = math.floor(self.clock.station_s / period_s)
        while True:
            while len(self.blocks) >= MOST_BLOCKS:
                await asyncio.sleep(FULL_WALL_S)
            block = await self.table.encoder(wanted)
            count = len(block.angles)
            if count:
                if block.first > wanted:
                    gap = (wanted * period_s, block.first * period_s)
                    self.note(Anomaly("encoder_gap", *gap, amount=block.first - wanted))
                self.blocks.append(block)
                wanted = block.first + count
            if count < self.table.block_samples:
                fill_s = period_s * (self.table.block_samples - 4)
                await asyncio.sleep(self.clock.wall(fill_s, 0.001, 0.2))

    def take(self) -> Stream:
        """Angles in rad, columns <axis>_angle, over station time."""
        blocks = [self.blocks.popleft() for _ in range(len(self.blocks))]
        t = np.concatenate([np.empty(0), *(block.t for block in blocks)])
        empty = np.empty((0, len(self.table.names)))
        angles = np.concatenate([empty, *(block.angles for block in blocks)])
        columns = (f"{name}_angle" for name in self.table.names)
        return Stream(t, dict(zip(columns, angles.T, strict=True)))


@dataclass
class ClimateReader:
    """The chamber, about once a station second, checked against the procedure's limits."""

    chamber: Chamber
    clock: StationClock
    limits: EnvironmentLimits
    note: Note
    last_s: float = -math.inf
    readings: list[Climate] = field(default_factory=list)

    async def run(self) -> None:
        """Read for ever."""
        while True:
            climate = await self.chamber.climate()
            if math.isnan(climate.station_s):
                climate = replace(climate, station_s=self.clock.at(wall_s()))
            if climate.station_s > self.last_s:
                self.last_s = climate.station_s
                self.readings.append(climate)
                self._compare(climate)
            await asyncio.sleep(self.clock.wall(1.0, 0.01, 1.0))

    def take(self) -> Stream:
        """Temperature, humidity, supply voltage and pressure over station time."""
        readings, self.readings = self.readings, []
        values = np.array([astuple(reading) for reading in readings]).reshape(-1, len(CLIMATE))
        every = dict(zip(CLIMATE, values.T, strict=True))
        columns = {name: column for name, column in every.items() if not np.isnan(column).all()}
        return Stream(columns.pop("station_s", np.empty(0)), columns)

    def _compare(self, climate: Climate) -> None:
        ranges = (
            ("air_temperature", climate.temperature, self.limits.temperature_degc),
            ("air_humidity", climate.humidity, self.limits.humidity_percent),
        )
        for code, value, (low, high) in ranges:
            if not low <= value <= high:
                self.note(Anomaly(code, climate.station_s, climate.station_s, value))


class UnitReader:
    """The unit's samples over its own time stamps, moved only if its clock is not the station's.

    `clock_shifts_s`: by how much they were moved, for each time the unit was switched on; first 0,
    unless the first stamps disagree with station time by more than SHIFT_THRESHOLD_S (and by more
    than the delay of the line can explain).
    """

    def __init__(self, unit: UnitDriver, clock: StationClock, note: Note) -> None:
        self.clock_shifts_s = [0.0]
        self.lost_samples = 0
        self._unit = unit
        self._clock = clock
        self._note = note
        self._taken_s = clock.station_s
        self._on_s: float | None = None
        self._moments: list[tuple[float, float, float]] = []
        self._begin()

    def _begin(self) -> None:
        none = no_samples(self._unit.link.frame)
        self._differences: list[float] = []
        self._is_shift_known = False
        self._held = self._last = none

    def switched_off(self) -> None:
        """The unit is to be switched off: it may be silent now."""
        self._unit.switched_off()

    def switched_on(self, station_s: float | None) -> None:
        """It was switched on again, at a station time (s) where that is known."""
        self._on_s = station_s
        self._unit.switched_on()

    def take(self, final: bool = False) -> Stream:
        """What came since; nothing while the first stamps are still being compared."""
        bad_before = self._unit.bad_frames
        before, after = self._unit.take()
        now_s, bad = self._clock.station_s, self._unit.bad_frames - bad_before
        if bad:
            self._note(Anomaly("unit_bad_frames", self._taken_s, now_s, bad))
        self._taken_s = now_s
        if len(after):
            self._moments.clear()
        if len(latest := after if len(after) else before):
            arrived_s = self._clock.latest_at(self._unit.arrived_s)
            doubt_s = (self._clock.took_s + LEAST_DELAY_WALL_S) * self._clock.speed
            self._moments.append((latest["stamp"][-1] / 1e6, arrived_s, doubt_s))
        stream = self._timed(before, final)
        if not len(after):
            return stream
        self._begin()
        self.clock_shifts_s.append(0.0)
        return joined([stream, self._timed(after, final)])

    def compared(self) -> ClockComparison | None:
        """The unit's clock, since it was last switched on, against the table's."""
        unit_s, arrived_s, doubt_s = np.array(self._moments).reshape(-1, 3).T
        return compared(unit_s, arrived_s, doubt_s)

    def _timed(self, frames: np.ndarray, final: bool) -> Stream:
        if not self._is_shift_known:
            self._compare(frames)
            frames = self._held = np.concatenate([self._held, frames])
            on_s = self._on_s if len(self.clock_shifts_s) > 1 else None
            enough = on_s is not None or len(self._differences) >= SHIFT_TAKES
            self._is_shift_known = final or (enough and not self._unit.is_off)
            if not self._is_shift_known:
                return self._unit.stream(frames[:0])
            self._settle_shift(on_s)
        stream = self._unit.stream(frames, round(self.clock_shifts_s[-1] * 1e6))
        self._note_lost(np.concatenate([self._last, frames]))
        if len(frames):
            self._last = frames[-1:]
        return stream

    def _compare(self, frames: np.ndarray) -> None:
        if len(frames):
            station_s = self._clock.at(self._unit.arrived_s)
            self._differences.append(station_s - frames["stamp"][-1] / 1e6)

    def _settle_shift(self, on_s: float | None) -> None:
        """A delay of the line makes a difference too large, one of the table's answer too small:
        a clock of its own shows in every one, on the same side."""
        if on_s is not None:
            self.clock_shifts_s[-1] = on_s
        elif self._differences:
            limit_s = SHIFT_THRESHOLD_S + LINE_DELAY_WALL_S * self._clock.speed
            least, most = min(self._differences), max(self._differences)
            if least > limit_s or most < -limit_s:
                self.clock_shifts_s[-1] = round(least if least > 0.0 else most, 6)

    def _note_lost(self, frames: np.ndarray) -> None:
        lost = self._unit.lost(frames)
        for place in np.flatnonzero(lost):
            before, after = frames["stamp"][place : place + 2] / 1e6 + self.clock_shifts_s[-1]
            self.lost_samples += int(lost[place])
            self._note(Anomaly("unit_lost_samples", before, after, int(lost[place])))


def compared(
    unit_s: np.ndarray, latest_s: np.ndarray, doubt_s: np.ndarray
) -> ClockComparison | None:
    """Compare stamps of a unit with the table's time when they arrived.

    unit_s: (n,) s. latest_s: (n,) s, the latest that the table's time can have been. doubt_s:
    (n,) s, by how much earlier it may have been when the unit set its stamp, in a line without
    fluctuation: the table's answer and the least delay of the line.

    A line only ever delays, so the least difference of each of BLOCKS spans is taken, and a
    straight line through these by least squares. The offset lies below it by no more than the
    median doubt of these: a rectangular distribution. None for fewer than FEWEST spans.
    """
    blocks = np.array_split(np.arange(len(unit_s)), BLOCKS)
    difference = latest_s - unit_s
    if sum(len(block) > 0 for block in blocks) < FEWEST:
        return None
    level = difference - np.polyval(np.polyfit(unit_s, difference, 1), unit_s)
    least = np.array([b[np.argmin(level[b])] for b in blocks if len(b)], dtype=int)
    at_s = float(unit_s[least].mean())
    regressors = np.column_stack([np.ones(len(least)), unit_s[least] - at_s])
    inverse = np.linalg.pinv(regressors.T @ regressors)
    most, skew = inverse @ regressors.T @ difference[least]
    residual = difference[least] - regressors @ [most, skew]
    scatter, u_skew = np.sqrt(np.diag(inverse) * (residual @ residual) / (len(least) - 2))
    half_width = float(np.median(doubt_s[least])) / 2.0
    return ClockComparison(
        at_s=at_s,
        offset_s=float(most) - half_width,
        half_width_s=half_width,
        u_offset_s=float(np.hypot(scatter, half_width / np.sqrt(3.0))),
        skew=float(skew),
        u_skew=float(u_skew),
    )
