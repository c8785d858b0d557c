"""Registers over Modbus/TCP and Modbus/RTU: typed, retried, with clear errors."""

import asyncio
import logging
import struct
from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager, nullcontext
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal, TypeAlias

from pymodbus import FramerType
from pymodbus.client import AsyncModbusSerialClient, AsyncModbusTcpClient
from pymodbus.client.mixin import ModbusClientMixin as Mixin
from pymodbus.exceptions import ModbusException
from pymodbus.pdu import ModbusPDU

from schemas.base import Unusable
from schemas.described import (
    BIT_BANKS,
    Bank,
    Connection,
    ModbusConnection,
    ModbusDevice,
    Register,
    RegisterType,
)
from tasks.station.drivers.backend import Values
from tasks.words import message

Client: TypeAlias = AsyncModbusSerialClient | AsyncModbusTcpClient
LOG = logging.getLogger("mimucal.station.connection")
ATTEMPTS = 3
PAUSE_S = 0.3
CANCEL_AGAIN_S = 0.05  # asyncio.wait_for may swallow a cancellation
ILLEGAL_FUNCTION = 1
MAP = "check the controller, and that its register map is that of the station file"
MEANINGS = {  # and the way out
    1: ("illegal function", MAP),
    2: ("illegal address", MAP),
    3: ("illegal value", MAP),
    4: ("device failure", MAP),
    5: ("acknowledge: it needs long for what it was told before", "wait until it has finished"),
    6: ("device busy: another client holds it", "end the other client, or wait for it"),
    7: ("negative acknowledge", MAP),
    8: ("memory parity error", "have the controller's memory looked at"),
    10: (
        "gateway path unavailable: the gateway has no way to the device",
        "check the gateway's own settings",
    ),
    11: (
        "gateway target silent: the gateway is there and the device behind it does not answer",
        "check that the device is on, its wiring to the gateway, and device in the station file",
    ),
}

Request = Callable[[Client], Awaitable[ModbusPDU]]
Order = Literal["big", "little"]


class Refused(Unusable):
    """The station answered with a Modbus exception."""

    def __init__(self, sentence: str, code: int) -> None:
        super().__init__(sentence)
        self.code = code


def decode(
    words: Sequence[int], kind: RegisterType, order: Order = "big", byte_order: Order = "big"
) -> Any:
    """The value, or the list of values, that the words hold."""
    turned = _bytes_in_order(words, byte_order)
    return Mixin.convert_from_registers(turned, Mixin.DATATYPE[kind.upper()], order)


def _bytes_in_order(words: Sequence[int], order: Order) -> list[int]:
    """Words whose high byte is first, of those in an order, and the other way round."""
    return [word >> 8 | (word & 0xFF) << 8 if order == "little" else word for word in words]


def encode(
    value: float, kind: RegisterType, order: Order = "big", byte_order: Order = "big"
) -> list[int]:
    """The words of a value. Raises Unusable for one that the type does not hold."""
    typed = float(value) if kind.startswith("float") else round(value)
    try:
        words = Mixin.convert_to_registers(typed, Mixin.DATATYPE[kind.upper()], order)
    except (struct.error, OverflowError) as error:
        raise Unusable(
            f"{value:g} does not fit a register of type {kind}: correct its type or its scale"
        ) from error
    return _bytes_in_order(words, byte_order)


class ModbusLink:
    """One Modbus connection, over TCP or a serial line, shared by everything on it.

    A request that gets no answer, or whose connection ends, is repeated on a new one, ATTEMPTS
    times in all.
    Raises Unusable, naming the connection, when there is still no answer, and Refused when the
    station answers with an exception.
    """

    def __init__(self, connection: Connection) -> None:
        self.url = connection.url
        self._where = f"the station at {connection.url.removeprefix('socket://')}"
        self._connection = connection
        self._client: Client | None = None
        self._asked: asyncio.Future[ModbusPDU] | None = None
        self._one_at_a_time = asyncio.Lock()
        self._is_closed = True
        self._combined = True
        logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # the sentences here replace it

    def close(self) -> None:
        """Hang up; the next request connects again.

        A connection that is just being made is ended by whom it is made for: pymodbus would keep
        it, and a serial line with it, for good.
        """
        self._is_closed = True
        if self._one_at_a_time.locked():
            self._give_up()
        else:
            self._hang_up()

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
        self._client = None

    async def read(self, device: int, bank: Bank, address: int, count: int) -> Sequence[int]:
        """`count` words, or bits as 0 and 1, of a bank from `address` on."""

        def request(client: Client) -> Awaitable[ModbusPDU]:
            ask = {
                "holding": client.read_holding_registers,
                "input": client.read_input_registers,
                "coil": client.read_coils,
                "discrete": client.read_discrete_inputs,
            }[bank]
            return ask(address, count=count, device_id=device)

        what = f"reading {count} of bank {bank} from {address} of device {device}"
        answer = await self._ask(what, request)
        got = answer.bits if bank in BIT_BANKS else answer.registers
        if len(got) < count:
            raise Unusable(
                f"{self._where} answered {what} with {len(got)}: check that its "
                f"register map is that of the station file"
            )
        return [int(each) for each in got[:count]]

    async def write(self, device: int, bank: Bank, address: int, words: list[int]) -> None:
        """Write neighbouring registers (function code 16), or one coil (5)."""

        def request(client: Client) -> Awaitable[ModbusPDU]:
            if bank == "coil":
                return client.write_coil(address, bool(words[0]), device_id=device)
            return client.write_registers(address, words, device_id=device)

        await self._ask(f"writing {words} to bank {bank} at {address} of device {device}", request)

    async def write_then_read(
        self, device: int, to: int, words: list[int], address: int, count: int
    ) -> Sequence[int]:
        """Write registers and read others: one exchange (function code 23) where it is known."""
        if self._combined:
            try:
                answer = await self._ask(
                    f"reading {count} of bank holding from {address} of device {device}",
                    lambda client: client.readwrite_registers(
                        read_address=address,
                        read_count=count,
                        write_address=to,
                        values=words,
                        device_id=device,
                    ),
                )
            except Refused as refusal:
                if refusal.code != ILLEGAL_FUNCTION:
                    raise
                self._combined = False
            else:
                return answer.registers
        await self.write(device, "holding", to, words)
        return await self.read(device, "holding", address, count)

    async def _ask(self, what: str, request: Request) -> ModbusPDU:
        async with self._one_at_a_time:
            for attempt in range(ATTEMPTS):
                if attempt:
                    LOG.warning("no answer", extra={"of": self.url, "request": what})
                if attempt > 1:  # at first perhaps the connection alone was cut
                    await asyncio.sleep(PAUSE_S)
                answer = await self._answer(request)
                if answer is not None:
                    break
        if answer is None:
            raise Unusable(
                f"{self._where} does not answer ({what}, {ATTEMPTS} attempts): check "
                f"that it is switched on, that the cable is in, and that url and device of the "
                f"station file are right",
                message("station-cause.silent", device=self.url),
            )
        if answer.isError():
            code = answer.exception_code
            meaning, way_out = MEANINGS.get(code, ("none of the standard's", MAP))
            raise Refused(
                f"{self._where} refused {what} with Modbus exception {code} ({meaning}): {way_out}",
                code,
            )
        return answer

    async def _answer(self, request: Request) -> ModbusPDU | None:
        """The answer to one attempt; None if there was none in time."""
        asked = self._asked = asyncio.ensure_future(self._exchange(request))
        try:
            await asyncio.wait([asked])
            return None if asked.cancelled() else asked.result()
        except (ModbusException, OSError, TimeoutError):
            return None
        finally:
            while not asked.done():  # the next request must not find this one on the line
                asked.cancel()
                await asyncio.wait([asked], timeout=CANCEL_AGAIN_S)
            _ = asked.cancelled() or asked.exception()  # asyncio reports what nobody looked at

    def _give_up(self, is_connected: bool = False) -> None:
        """Wait no longer for an answer; of pymodbus, which waits on where a connection ends."""
        if self._asked is not None and not is_connected:
            self._asked.cancel()

    async def _exchange(self, request: Request) -> ModbusPDU:
        """Ask on the connection there is, or on a new one; without an answer none is left."""
        try:
            if self._is_closed or not (self._client and self._client.connected):
                await self._connect()
            assert self._client is not None
            return await request(self._client)
        except BaseException:
            try:  # pymodbus sets a serial line up in the next turns, and fails if it is closed
                await asyncio.sleep(0)
                await asyncio.sleep(0)
            finally:
                self._hang_up()
            raise

    async def _connect(self) -> None:
        self._hang_up()
        self._is_closed, self._client = False, self._new_client()
        if not await self._client.connect() or self._is_closed:
            raise ConnectionError(f"{self._where} cannot be connected to")
        LOG.info("connected", extra={"of": self.url})

    def _new_client(self) -> Client:
        line = self._connection
        if address := host_and_port(self.url):
            host, port = address
            is_rtu = isinstance(line, ModbusConnection) and line.framing == "rtu"
            return AsyncModbusTcpClient(
                host, port=port, framer=FramerType.RTU if is_rtu else FramerType.SOCKET,
                timeout=line.timeout_s, retries=0, reconnect_delay=0,
                trace_connect=self._give_up,
            )  # fmt: skip
        return AsyncModbusSerialClient(
            self.url,
            baudrate=line.baudrate,
            parity=line.parity,
            stopbits=line.stopbits,
            timeout=line.timeout_s,
            retries=0,
            reconnect_delay=0,
            trace_connect=self._give_up,
        )


def host_and_port(url: str) -> tuple[str, int] | None:
    """Where a URL `socket://host:port` leads to; None for a serial device."""
    if not url.startswith("socket://"):
        return None
    host, _, port = url.removeprefix("socket://").rstrip("/").rpartition(":")
    return host.strip("[]"), int(port)


# A device with registers, read and commanded by its register map.

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
