import asyncio
from typing import Any

import pytest

from schemas.station import AXIS_BASE, AXIS_REGISTERS, AXIS_STRIDE, TABLE_REGISTERS
from tasks.station.drivers.modbus import encode
from tasks.station.drivers.modbus_table import ModbusTable


class Hurried:
    """A link to a table that goes on by a second and a degree from one request to the next."""

    def __init__(self) -> None:
        self.requests = 0

    async def read_words(self, device: int, address: int, count: int) -> list[int]:
        self.requests += 1
        image = [0] * 200
        self._put(image, TABLE_REGISTERS, 0, {"station_time": self.requests * 1_000_000})
        for axis in range(3):
            base = AXIS_BASE + AXIS_STRIDE * axis
            values = {"status": 5, "angle": self.requests * 10_000 + axis, "rate": 1.5}
            self._put(image, AXIS_REGISTERS, base, values)
        return image[address : address + count]

    def _put(self, image: list[int], registers: Any, base: int, values: dict[str, float]) -> None:
        for register in registers:
            if register.name in values:
                start = base + register.address
                words = encode(values[register.name], register.type)
                image[start : start + len(words)] = words


def test_the_state_of_the_table_and_its_axes_is_of_one_moment():
    """Else a run that waits between two requests begins a segment before the table settled."""
    table = ModbusTable(Hurried(), ("a", "b", "c"), (3_600_000,) * 3, 10_000)  # type: ignore[arg-type]
    for _ in range(3):
        state = asyncio.run(table.state())
        for number, axis in enumerate(state.axes):
            assert axis.angle_deg == pytest.approx(state.station_s + number * 1e-4)
            assert axis.rate_deg_s == 1.5
            assert axis.is_settled
