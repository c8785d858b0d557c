"""Registers over Modbus/TCP: typed, retried a few times, and with errors that speak."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Sequence
from typing import TYPE_CHECKING, Any

from schemas.base import Unusable
from schemas.station import Register, RegisterType

if TYPE_CHECKING:
    from pymodbus.client import AsyncModbusTcpClient
    from pymodbus.pdu import ModbusPDU

ATTEMPTS = 3
TIMEOUT_S = 1.0
PAUSE_S = 0.3
ILLEGAL_FUNCTION = 1
MEANINGS = {
    1: "illegal function",
    2: "illegal address",
    3: "illegal value",
    4: "device failure",
    6: "device busy: another client holds it",
}

Request = Callable[["AsyncModbusTcpClient"], Awaitable["ModbusPDU"]]


class Refused(Unusable):
    """The station answered with a Modbus exception."""

    def __init__(self, sentence: str, code: int) -> None:
        super().__init__(sentence)
        self.code = code


def decode(words: Sequence[int], kind: RegisterType) -> Any:
    """The value, or the list of values, that the words hold, high word first."""
    from pymodbus.client.mixin import ModbusClientMixin as Mixin

    return Mixin.convert_from_registers(list(words), Mixin.DATATYPE[kind.upper()])


def encode(value: float, kind: RegisterType) -> list[int]:
    """The words of a value, high word first."""
    from pymodbus.client.mixin import ModbusClientMixin as Mixin

    typed = float(value) if kind == "float32" else int(value)
    return Mixin.convert_to_registers(typed, Mixin.DATATYPE[kind.upper()])


def decode_all(words: Sequence[int], first: int, registers: Sequence[Register]) -> dict[str, Any]:
    """The values of registers by name, out of words of which the first is that of an address."""
    return {
        register.name: decode(words[start : start + register.words], register.type)
        for register in registers
        for start in (register.address - first,)
    }


class ModbusLink:
    """One Modbus/TCP connection, shared by everything that talks to a station.

    A request that gets no answer is repeated on a new connection, ATTEMPTS times in all.
    Raises Unusable, naming host and port, when there is still no answer, and Refused when the
    station answers with an exception.
    """

    def __init__(self, host: str, port: int) -> None:
        self.host = host
        self.port = port
        self._client: AsyncModbusTcpClient | None = None
        self._one_at_a_time = asyncio.Lock()
        self._combined = True
        logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # the sentences here replace it

    def close(self) -> None:
        """Hang up; the next request connects again."""
        if self._client is not None:
            self._client.close()
        self._client = None

    async def hang_up(self) -> None:
        """`close`, for those who are not in the event loop of the connection."""
        self.close()

    async def read(
        self, device: int, registers: Sequence[Register], base: int = 0
    ) -> dict[str, Any]:
        """The values of neighbouring registers (lowest first), by name."""
        first, last = registers[0].address, registers[-1]
        count = last.address + last.words - first
        return decode_all(await self.read_words(device, base + first, count), first, registers)

    async def read_words(self, device: int, address: int, count: int) -> Sequence[int]:
        """`count` holding registers from `address` on (function code 3)."""
        answer = await self._ask(
            f"reading {count} registers from {address} of device {device}",
            lambda client: client.read_holding_registers(address, count=count, device_id=device),
        )
        return answer.registers

    async def write(self, device: int, register: Register, value: float, base: int = 0) -> None:
        """Write one register of the map (function code 16)."""
        address, words = base + register.address, encode(value, register.type)
        await self._ask(
            f"writing {value:g} to {register.name} of device {device}",
            lambda client: client.write_registers(address, words, device_id=device),
        )

    async def write_then_read(
        self, device: int, register: Register, value: int, address: int, count: int
    ) -> Sequence[int]:
        """Write a register and read others: one exchange (function code 23) where it is known."""
        if self._combined:
            words = encode(value, register.type)
            try:
                answer = await self._ask(
                    f"reading {count} registers from {address} of device {device}",
                    lambda client: client.readwrite_registers(
                        read_address=address,
                        read_count=count,
                        write_address=register.address,
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
        await self.write(device, register, value)
        return await self.read_words(device, address, count)

    async def _ask(self, what: str, request: Request) -> "ModbusPDU":
        async with self._one_at_a_time:
            for attempt in range(ATTEMPTS):
                if attempt:
                    await asyncio.sleep(PAUSE_S)
                answer = await self._answer(request)
                if answer is not None:
                    break
                self.close()
        if answer is None:
            raise Unusable(
                f"the station at {self.host}:{self.port} does not answer ({what}, "
                f"{ATTEMPTS} attempts): check that it is switched on, that the network cable is "
                f"in, and that modbus_host and modbus_port of the station file are right"
            )
        if answer.isError():
            code = answer.exception_code
            raise Refused(
                f"the station at {self.host}:{self.port} refused {what} with Modbus exception "
                f"{code} ({MEANINGS.get(code, 'unknown')}): check the controller, and that its "
                f"register map is that of the station file",
                code,
            )
        return answer

    async def _answer(self, request: Request) -> "ModbusPDU | None":
        """The answer to one attempt; None if there was none in time."""
        from pymodbus.exceptions import ModbusException

        try:
            client = await self._connected()
            return await request(client) if client else None
        except (ModbusException, OSError, TimeoutError):
            return None

    async def _connected(self) -> "AsyncModbusTcpClient | None":
        from pymodbus.client import AsyncModbusTcpClient

        if self._client is not None and self._client.connected:
            return self._client
        self.close()
        client = AsyncModbusTcpClient(
            self.host, port=self.port, timeout=TIMEOUT_S, retries=0, reconnect_delay=0
        )
        if not await client.connect():
            client.close()
            return None
        self._client = client
        return client
