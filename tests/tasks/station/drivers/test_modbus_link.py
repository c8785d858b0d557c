"""The link against small real servers of this test's own."""

import asyncio
import struct
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from pymodbus.constants import ExcCodes
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

from schemas.base import Unusable, first_fault
from schemas.described import WORDS, Connection, ModbusConnection
from tasks.station.drivers.modbus import ModbusLink, Refused, decode, encode
from tasks.station.plan import move_s, nearest_turn
from tests.tasks.station.makers import modbus_maker

READ_AND_WRITE = 23


async def serve(refused: tuple[int, ...] = (), port: int = 0) -> ModbusTcpServer:
    async def action(code: int, *_: Any) -> ExcCodes | None:
        return ExcCodes.ILLEGAL_FUNCTION if code in refused else None

    words = SimData(0, count=300, values=0, datatype=DataType.REGISTERS)
    server = ModbusTcpServer([SimDevice(1, [words], action=action)], address=("127.0.0.1", port))
    assert await server.listen()
    return server


def port_of(server: ModbusTcpServer) -> int:
    return server.transport.sockets[0].getsockname()[1]


def on_a_server(
    use: Callable[[ModbusLink, ModbusTcpServer], Awaitable[None]], refused: tuple[int, ...] = ()
) -> None:
    async def run() -> None:
        server = await serve(refused)
        link = ModbusLink(Connection(url=f"socket://127.0.0.1:{port_of(server)}"))
        try:
            await use(link, server)
        finally:
            link.close()
            server.close()

    asyncio.run(run())


@given(st.sampled_from(["uint16", "uint32", "int32", "uint64"]), st.data())
def test_whole_numbers_survive_their_words(kind, data):
    bits = 16 * WORDS[kind]
    low, high = (-(2 ** (bits - 1)), 2 ** (bits - 1)) if kind == "int32" else (0, 2**bits)
    value = data.draw(st.integers(low, high - 1))
    assert len(encode(value, kind)) == WORDS[kind]
    assert decode(encode(value, kind), kind) == value


@pytest.mark.parametrize("refused", [(), (READ_AND_WRITE,)], ids=["combined", "one after another"])
def test_capture_works_with_and_without_the_combined_function(refused):
    async def use(link: ModbusLink, server: ModbusTcpServer) -> None:
        for number in (70_000, 70_019):
            words = await link.write_then_read(1, 100, encode(number, "uint32"), 100, 2)
            assert decode(words, "uint32") == number

    on_a_server(use, refused)


def test_exception_answer_is_refused_at_once_with_its_meaning():
    async def use(link: ModbusLink, server: ModbusTcpServer) -> None:
        with pytest.raises(
            Refused, match=r"reading 2 of bank holding from 900 .* 2 \(illegal address\)"
        ):
            await link.read(1, "holding", 900, 2)

    on_a_server(use)


@pytest.mark.parametrize(
    ("code", "says"),
    [
        (5, r"5 \(acknowledge: .*\): wait until it has finished"),
        (8, r"8 \(memory parity error\)"),
        (10, r"10 \(gateway path unavailable: .*\): check the gateway"),
        (11, r"11 \(gateway target silent: .*\): check that the device is on"),
    ],
)
def test_an_exception_is_said_in_words_with_its_own_way_out(code, says):
    async def refuse(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        request = await reader.readexactly(12)
        writer.write(request[:4] + bytes([0, 3, request[6], 0x83, code]))
        await writer.drain()
        writer.close()

    async def run() -> None:
        server = await asyncio.start_server(refuse, "127.0.0.1", 0)
        link = ModbusLink(
            Connection(url=f"socket://127.0.0.1:{server.sockets[0].getsockname()[1]}")
        )
        try:
            with pytest.raises(Refused, match=says):
                await link.read(1, "holding", 0, 1)
        finally:
            link.close()
            server.close()

    asyncio.run(run())


@pytest.mark.parametrize("word_order", ["big", "little"])
@pytest.mark.parametrize("byte_order", ["big", "little"])
@pytest.mark.parametrize(
    ("kind", "code"), [("uint16", "H"), ("int32", "i"), ("float32", "f"), ("float64", "d")]
)
def test_words_and_bytes_have_an_order_of_their_own(word_order, byte_order, kind, code):
    octets = struct.pack(f">{code}", 12345)
    words = [octets[place : place + 2] for place in range(0, len(octets), 2)]
    if word_order == "little":
        words.reverse()
    sent = [int.from_bytes(word, byte_order) for word in words]
    assert decode(sent, kind, word_order, byte_order) == 12345
    assert encode(12345, kind, word_order, byte_order) == sent


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("tcp://192.168.1.5:502", r"no scheme tcp://.*socket://host:port"),
        ("modbus://192.168.1.5", r"no scheme modbus://"),
        ("socket://192.168.1.5", r"no host and port"),
        ("socket://192.168.1.5:70000", r"no host and port"),
        ("socket://user:secret@192.168.1.5:502", r"no user and no password"),
    ],
)
def test_a_url_that_no_line_is_opened_by_is_one_sentence(url, says):
    with pytest.raises(ValidationError, match=says) as refused:
        ModbusConnection(url=url)
    assert "secret" not in first_fault(refused.value)


def test_link_connects_again_when_the_server_comes_back():
    async def use(link: ModbusLink, server: ModbusTcpServer) -> None:
        await link.read(1, "holding", 0, 1)
        server.close()
        await asyncio.sleep(0.05)
        again = await serve(port=int(link.url.rpartition(":")[2]))
        try:
            assert len(await link.read(1, "holding", 0, 1)) == 1
        finally:
            link.close()
            again.close()

    on_a_server(use)


def test_lost_connection_names_host_port_and_the_way_out():
    async def use(link: ModbusLink, server: ModbusTcpServer) -> None:
        await link.read(1, "holding", 0, 1)
        server.close()
        with pytest.raises(Unusable, match=r"127.0.0.1:\d+ does not answer .* check that"):
            await link.read(1, "holding", 0, 1)

    on_a_server(use)


def test_an_answer_is_not_awaited_on_a_connection_that_ended():
    connections = []

    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        connections.append(writer)
        request = await reader.readexactly(12)
        if len(connections) > 1:
            writer.write(request[:4] + bytes([0, 5]) + request[6:8] + bytes([2, 4, 210]))
            await writer.drain()
        writer.close()

    async def run() -> None:
        server = await asyncio.start_server(answer, "127.0.0.1", 0)
        port = server.sockets[0].getsockname()[1]
        link = ModbusLink(Connection(url=f"socket://127.0.0.1:{port}", timeout_s=30))
        try:
            assert await asyncio.wait_for(link.read(1, "holding", 0, 1), 5.0) == [1234]
        finally:
            link.close()
            server.close()

    asyncio.run(run())
    assert len(connections) == 2


@given(st.floats(-1e5, 1e5), st.floats(-360, 360))
def test_nearest_turn_is_the_same_attitude_at_most_half_a_turn_away(angle, target):
    found = nearest_turn(angle, target)
    assert abs(found - angle) <= 180 + 1e-6
    assert (found - target) / 360 == pytest.approx(round((found - target) / 360), abs=1e-9)


def test_duration_of_a_move_is_that_of_the_trapezoid():
    assert move_s(90, 90, 120) == pytest.approx(90 / 90 + 90 / 120)
    assert move_s(-30, 90, 120) == pytest.approx(2 * (30 / 120) ** 0.5)


@pytest.mark.parametrize("turns", range(9))
def test_a_serial_line_that_is_closed_while_it_is_opened_can_be_opened_again(turns):
    url, end = modbus_maker.over_serial(modbus_maker.ModbusMaker())

    async def close_after_some_turns_of_the_loop() -> None:
        link = ModbusLink(Connection(url=url))
        reading = asyncio.ensure_future(link.read(7, "input", 100, 6))
        for _ in range(turns):
            await asyncio.sleep(0)
        link.close()
        await link.write(7, "coil", 30, [0])
        assert len(await reading) == 6
        link.close()

    asyncio.run(close_after_some_turns_of_the_loop())
    end()
