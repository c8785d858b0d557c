"""A device with registers, read and commanded by its register map."""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager, nullcontext
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from schemas.described import Bank, ModbusDevice, Register
from tasks.station.drivers.backend import Values
from tasks.station.drivers.modbus import ModbusLink, Order, decode, encode

MOST_WORDS = 120  # a request reads at most 125


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
