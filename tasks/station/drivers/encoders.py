"""A table's encoders over time: captured by its controller, or polled."""

import asyncio

import numpy as np

from schemas.base import Unusable
from schemas.devices import Capture, ModbusTable, TextTable
from tasks.station.clock import wall_s
from tasks.station.drivers.backend import Backend
from tasks.station.drivers.modbus import decode, encode
from tasks.station.drivers.modbus_device import ModbusBackend
from tasks.station.ports import EncoderBlock

LATE_PERIODS = 5.0  # a poll that comes later leaves a gap


class Unwrapped:
    """Angles (n, axes) in deg that continue where the encoder wraps."""

    def __init__(self, turnover_deg: float | None) -> None:
        self._turnover = turnover_deg
        self._read: np.ndarray | None = None  # the last angles read, and what they have run on to
        self._angles = np.empty(0)

    def __call__(self, read: np.ndarray) -> np.ndarray:
        """The angles of the next samples."""
        if self._turnover is None or not len(read):
            return read
        if self._read is None:
            self._read = self._angles = read[0]
        half = self._turnover / 2
        steps = np.diff(read, axis=0, prepend=self._read[None])
        turns = np.floor((steps + half) / self._turnover)
        angles = self._angles + np.cumsum(steps - turns * self._turnover, axis=0)
        self._read, self._angles = read[-1], angles[-1]
        return angles


class CapturedEncoders:
    """Blocks of samples that the controller took itself, through its registers."""

    def __init__(
        self, described: ModbusTable, capture: Capture, backend: ModbusBackend, axes: int
    ) -> None:
        self.period_us = capture.period_us
        self.block_samples = capture.values // axes
        self._axes = axes
        self._order = described.word_order
        self._device = described.device
        self._link = backend.link
        registers = described.registers
        self._wanted, self._count = registers[capture.wanted], registers[capture.count]
        self._first, self._samples = registers[capture.first], registers[capture.samples]
        self._unwrapped = Unwrapped(described.turnover_deg)

    async def block(self, first: int) -> EncoderBlock:
        """The captured samples from number `first` on, or from the oldest one kept."""
        start, width = self._count.address, self._samples.words
        at = self._samples.address - start
        words = await self._link.write_then_read(
            self._device,
            self._wanted.address,
            encode(first, self._wanted.type, self._order),
            start,
            at + width * self._axes * self.block_samples,
        )
        count = int(decode(words[: self._count.words], self._count.type, self._order))
        if not 0 <= count <= self.block_samples:
            raise Unusable(
                f"the table at {self._link.url} gives {count} samples where a block holds "
                f"{self.block_samples}: check capture in the station file"
            )
        place = self._first.address - start
        number = decode(words[place : place + self._first.words], self._first.type, self._order)
        if not count:
            return EncoderBlock(int(number), np.empty((0, self._axes)), np.empty(0))
        read = decode(words[at : at + width * self._axes * count], self._samples.type, self._order)
        degrees = np.reshape(read, (count, self._axes)) * self._samples.scale
        angles = np.radians(self._unwrapped(degrees + self._samples.offset))
        return EncoderBlock(
            int(number), angles, (np.arange(count) + int(number)) * self.period_us / 1e6
        )


class PolledEncoders:
    """The angles of a table that does not capture them, read one after another.

    The time of a sample is the table's own if it reports one, otherwise the middle of the exchange,
    since `began_s`. `time_half_width_s`: half of the longest exchange so far, the possible error of
    a sample's time.
    """

    block_samples = 1

    def __init__(
        self, described: ModbusTable | TextTable, backend: Backend, began_s: float
    ) -> None:
        self.period_us = described.poll_period_ms * 1000
        self.time_half_width_s = 0.0
        self._backend = backend
        self._names = frozenset(("angle", "time")) & described.readings
        self._unwrapped = Unwrapped(described.turnover_deg)
        self._began_s = began_s
        self._polled_s = -np.inf

    async def block(self, first: int) -> EncoderBlock:
        """One sample, a poll period after the one before; its number is `first`, or past it
        where the poll came late."""
        period_s = self.period_us / 1e6
        await asyncio.sleep(max(self._polled_s + period_s - wall_s(), 0.0))
        asked_s = wall_s()
        values = await self._backend.read(self._names)
        answered_s = wall_s()
        late = (asked_s - self._polled_s) / period_s if np.isfinite(self._polled_s) else 1.0
        skipped = round(late) - 1 if late > LATE_PERIODS else 0
        self._polled_s = asked_s
        self.time_half_width_s = max(self.time_half_width_s, (answered_s - asked_s) / 2)
        angles = np.radians(self._unwrapped(np.array([values["angle"]], float)))
        middle_s = (asked_s + answered_s) / 2 - self._began_s
        return EncoderBlock(first + skipped, angles, np.array([values.get("time", middle_s)]))
