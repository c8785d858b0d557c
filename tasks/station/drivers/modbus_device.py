"""A device with registers, read and commanded by its register map."""

import asyncio
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager, nullcontext
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from schemas.base import Unusable
from schemas.described import Bank, ModbusDevice, Register
from schemas.devices import Capture, ModbusTable, TextTable
from tasks.station.clock import wall_s
from tasks.station.drivers.backend import Backend, Values
from tasks.station.drivers.modbus import ModbusLink, Order, decode, encode
from tasks.station.ports import EncoderBlock

MOST_WORDS = 120  # a request reads at most 125
LATE_S = 3.0  # a poll that comes later leaves a gap: longer than what is read again
LONG, USUAL_OF, FEWEST = 2.5, 101, 5  # times the usual one, which is the median of so many
AGAIN = 3  # times that an angle is read whose time is known too badly


@dataclass(frozen=True)
class Place:
    """Where a register stands, of one axis or of the device."""

    name: str
    axis: int | None
    address: int
    register: Register

    @property
    def end(self) -> int:
        return self.address + self.register.words


class ModbusBackend:
    """Implements Backend for `axes` axes. Raises as ModbusLink does."""

    def __init__(self, described: ModbusDevice, link: ModbusLink, axes: int) -> None:
        self.url = link.url
        self.link = link
        self.described = described
        self._axes = axes
        self._requests = lru_cache(self._plan)

    @property
    def per_axis(self) -> frozenset[str]:
        """The registers with a stride."""
        registers = self.described.registers.items()
        return frozenset(name for name, each in registers if each.stride is not None)

    def alone(self) -> AbstractAsyncContextManager[Any]:
        """Nothing is kept waiting: another's requests may stand between."""
        return nullcontext()

    async def read(self, names: frozenset[str], after: str = "") -> Values:
        """The values by name; of one moment, where they lie within one request."""
        found: dict[tuple[str, int | None], Any] = {}
        for number, request in enumerate(self._requests(names)):
            first = request[0]
            words = await self._words_of(request, after if number == 0 else "")
            for place in request:
                start = place.address - first.address
                found[place.name, place.axis] = self._value(
                    words[start : start + place.register.words], place.register
                )
        return {
            name: tuple(found[name, axis] for axis in range(self._axes))
            if name in self.per_axis
            else found[name, None]
            for name in names
        }

    async def _words_of(self, request: tuple[Place, ...], after: str) -> Sequence[int]:
        first, count = request[0], request[-1].end - request[0].address
        device, bank = self.described.device, first.register.bank
        writes = self.described.commands.get(after, ())
        if len(writes) == 1 and bank == self.described.registers[writes[0].write].bank == "holding":
            register, value = self.described.registers[writes[0].write], writes[0].value
            words = self._words((float(value) - register.offset) / register.scale, register)
            return await self.link.write_then_read(
                device, register.address, words, first.address, count
            )
        await self.command(after, {})
        return await self.link.read(device, bank, first.address, count)

    async def command(self, name: str, given: Mapping[str, float], axis: int = 0) -> None:
        """Write the command's registers, one after the other."""
        for write in self.described.commands.get(name, ()):
            value = given[write.value] if isinstance(write.value, str) else write.value
            register = self.described.registers[write.write]
            address = register.address + axis * (register.stride or 0)
            raw = (value - register.offset) / register.scale
            words = [int(raw)] if register.type == "bit" else self._words(raw, register)
            await self.link.write(self.described.device, register.bank, address, words)

    def close(self) -> None:
        """Hang up; the next request connects again."""
        self.link.close()

    def _words(self, raw: float, register: Register) -> list[int]:
        return encode(raw, register.type, *self.orders(register))

    def orders(self, register: Register) -> tuple[Order, Order]:
        """The order of a register's words, and of the bytes in each."""
        return self.described.word_order, register.byte_order or self.described.byte_order

    def _value(self, words: Sequence[int], register: Register) -> Any:
        if register.type == "bit":
            return words[0]
        raw = decode(words, register.type, *self.orders(register))
        if register.scale == 1.0 and register.offset == 0.0:
            return raw
        return raw * register.scale + register.offset

    def _places(self, names: Iterable[str]) -> list[Place]:
        places = []
        for name in names:
            register = self.described.registers[name]
            if register.stride is None:
                places.append(Place(name, None, register.address, register))
                continue
            places += [
                Place(name, axis, register.address + axis * register.stride, register)
                for axis in range(self._axes)
            ]
        return places

    def _plan(self, names: frozenset[str]) -> tuple[tuple[Place, ...], ...]:
        """The requests that read the registers; that of the time is the last."""
        requests: list[list[Place]] = []
        banks: dict[Bank, list[Place]] = {}
        for place in self._places(names):
            banks.setdefault(place.register.bank, []).append(place)
        for places in banks.values():
            requests += self._grouped(sorted(places, key=lambda place: place.address))
        requests.sort(key=lambda request: any(place.name == "time" for place in request))
        return tuple(map(tuple, requests))

    def _grouped(self, places: list[Place]) -> list[list[Place]]:
        groups: list[list[Place]] = []
        for place in places:
            near = groups and (
                place.address <= groups[-1][-1].end or self.described.reads_across_gaps
            )
            if near and place.end - groups[-1][0].address <= MOST_WORDS:
                groups[-1].append(place)
            else:
                groups.append([place])
        return groups


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
