"""Encoder samples of a table: captured by its controller, or angles that are polled."""

import asyncio
from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np

from schemas.base import Unusable
from schemas.described import Register
from schemas.station import Capture, ModbusTable, TextTable
from tasks.station.clock import wall_s
from tasks.station.drivers.backend import Backend, Values
from tasks.station.drivers.modbus import ModbusBackend, decode, encode
from tasks.station.ports import EncoderBlock

LATE_S = 5.0  # a poll that comes later leaves a gap: longer than what is read again
LONG, USUAL_OF, FEWEST = 2.5, 101, 5  # times the usual one, which is the median of so many
AGAIN = 2  # times that an angle is read whose time is known too badly


class Exchanges:
    """Tells an exchange that took unusually long: it was repeated, or the computer was busy.

    When an angle was read in it is known too badly.
    """

    def __init__(self) -> None:
        self._took_s: deque[float] = deque(maxlen=USUAL_OF)

    def is_long(self, took_s: float) -> bool:
        """Whether the next one, of so many seconds, did."""
        usual_s = float(np.median(self._took_s)) if self.are_known else np.inf
        self._took_s.append(took_s)
        return took_s > LONG * usual_s

    @property
    def are_known(self) -> bool:
        """Whether what is usual is known."""
        return len(self._took_s) >= FEWEST


class Unwrapped:
    """Angles (n, axes) in deg that continue where the encoder wraps.

    rates: (axes,) deg/s last known, by which it goes on between readings that are far apart.
    """

    def __init__(self, turnover_deg: float | None) -> None:
        self.rates: np.ndarray | None = None
        self._turnover = turnover_deg
        self._read: np.ndarray | None = None  # the last angles read, and what they have run on to
        self._angles = np.empty(0)
        self._read_s = 0.0

    def at(
        self, angle: Any, t: float, rates: np.ndarray | None = None, is_sure: bool = True
    ) -> np.ndarray:
        """The angles (axes,) of a reading at a time (s), with its rates where they are read.

        is_sure: of its time; otherwise the next one goes on from that before.
        """
        before = self.rates if self.rates is not None else rates
        after = before if rates is None else rates
        ahead = 0.0 if before is None or after is None else (before + after) / 2
        self.rates = after
        before_it = self._read, self._angles, self._read_s
        read = np.array([np.atleast_1d(angle)], float)
        angles = self(read, ahead * (t - self._read_s) if self._read is not None else 0.0)[0]
        self._read_s = t
        if not is_sure:
            self._read, self._angles, self._read_s = before_it
        return angles

    def __call__(self, read: np.ndarray, ahead: np.ndarray | float = 0.0) -> np.ndarray:
        """The angles of the next samples; ahead: by how much each is expected to have moved."""
        if self._turnover is None or not len(read):
            return read
        if self._read is None:
            self._read = self._angles = read[0]
        half = self._turnover / 2
        steps = np.diff(read, axis=0, prepend=self._read[None])
        turns = np.floor((steps - ahead + half) / self._turnover)
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
        self._device = described.device
        self._backend, self._link = backend, backend.link
        registers = described.registers
        self._wanted, self._count = registers[capture.wanted], registers[capture.count]
        self._first, self._samples = registers[capture.first], registers[capture.samples]
        self._unwrapped = Unwrapped(described.turnover)

    async def block(self, first: int) -> EncoderBlock:
        """The captured samples from number `first` on, or from the oldest one kept."""
        start, width = self._count.address, self._samples.words
        at = self._samples.address - start
        words = await self._link.write_then_read(
            self._device,
            self._wanted.address,
            encode(first, self._wanted.type, *self._backend.orders(self._wanted)),
            start,
            at + width * self._axes * self.block_samples,
        )
        count = int(self._held(words[: self._count.words], self._count))
        if not 0 <= count <= self.block_samples:
            raise Unusable(
                f"the table at {self._link.url} gives {count} samples where a block holds "
                f"{self.block_samples}: check capture in the station file"
            )
        place = self._first.address - start
        number = self._held(words[place : place + self._first.words], self._first)
        if not count:
            return EncoderBlock(int(number), np.empty((0, self._axes)), np.empty(0))
        read = self._held(words[at : at + width * self._axes * count], self._samples)
        degrees = np.reshape(read, (count, self._axes)) * self._samples.scale
        angles = np.radians(self._unwrapped(degrees + self._samples.offset))
        return EncoderBlock(
            int(number), angles, (np.arange(count) + int(number)) * self.period_us / 1e6
        )

    def _held(self, words: Sequence[int], register: Register) -> Any:
        return decode(words, register.type, *self._backend.orders(register))


class PolledEncoders:
    """The angles of a table that does not capture them, read one after another.

    The time of a sample is the table's own if it reports one, otherwise the middle of the exchange,
    since `began_s`. `time_half_width_s`: half of the longest exchange of a sample so far, the
    possible error of its time. What an exchange of unusual length gave is not kept.
    """

    block_samples = 1

    def __init__(
        self,
        described: ModbusTable | TextTable,
        backend: Backend,
        began_s: float,
        unwrapped: Unwrapped,
    ) -> None:
        self.period_us = described.poll_period_ms * 1000
        self.time_half_width_s = 0.0
        self._backend = backend
        self._names = frozenset(("angle", "time")) & described.readings
        self._unwrapped = unwrapped
        self._began_s = began_s
        self._polled_s = -np.inf
        self._exchanges = Exchanges()

    async def block(self, first: int) -> EncoderBlock:
        """One sample, a poll period after the one before; its number is `first`, or past it
        where the poll came late."""
        period_s = self.period_us / 1e6
        await asyncio.sleep(max(self._polled_s + period_s - wall_s(), 0.0))
        while not self._exchanges.are_known:
            asked_s, answered_s, _ = await self._asked()
            self._exchanges.is_long(answered_s - asked_s)
        for _ in range(AGAIN):
            asked_s, answered_s, values = await self._asked()
            if not self._exchanges.is_long(answered_s - asked_s):
                break
        late_s = asked_s - self._polled_s if np.isfinite(self._polled_s) else period_s
        skipped = round(late_s / period_s) - 1 if late_s > max(LATE_S, 2 * period_s) else 0
        self._polled_s = asked_s
        self.time_half_width_s = max(self.time_half_width_s, (answered_s - asked_s) / 2)
        t = float(values.get("time", (asked_s + answered_s) / 2 - self._began_s))
        angles = np.radians(self._unwrapped.at(values["angle"], t))
        return EncoderBlock(first + skipped, angles[None], np.array([t]))

    async def _asked(self) -> tuple[float, float, Values]:
        """When they were asked for and answered (wall time, s), and the values."""
        async with self._backend.alone():
            asked_s = wall_s()
            values = await self._backend.read(self._names)
            return asked_s, wall_s(), values
