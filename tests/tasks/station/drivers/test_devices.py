"""Devices made from descriptions, and drivers of other packages found by entry point."""

import asyncio
from importlib.metadata import EntryPoint
from typing import Any

import pytest
from pydantic import TypeAdapter, ValidationError

from schemas.base import Unusable
from schemas.described import Register
from schemas.devices import ModbusTable, PythonDevice, TableDevice
from tasks.station.drivers import devices as module
from tasks.station.drivers.devices import Devices
from tasks.station.drivers.modbus_device import ModbusBackend
from tests.tasks.station.sample_stations import sample

TABLE: TypeAdapter[Any] = TypeAdapter(TableDevice)


class Own:
    """A driver of another package."""

    def __init__(self, options: dict[str, Any], names: tuple[str, ...]) -> None:
        self.options, self.names, self.is_open = options, names, True

    def close(self) -> None:
        self.is_open = False


def test_a_driver_of_another_package_gets_its_options_and_axes_and_is_closed(monkeypatch):
    point = EntryPoint("own", f"{__name__}:Own", "mimucal.tables")
    monkeypatch.setattr(EntryPoint, "load", lambda _: Own)
    monkeypatch.setattr(module, "entry_points", lambda group: [point] * (group == point.group))

    async def use() -> Any:
        made = Devices(("a", "b"))
        table = await made.table(PythonDevice(driver="python", name="own", options={"port": 3}))
        with pytest.raises(Unusable, match=r"no driver other in .* mimucal.tables .*are: own"):
            await made.table(PythonDevice(driver="python", name="other"))
        await made.hang_up()
        return table

    table = asyncio.run(use())
    assert (table.options, table.names, table.is_open) == ({"port": 3}, ("a", "b"), False)


class OnlyMeasures:
    """A chamber of another package that measures its air and cannot set it."""

    def __init__(self, options: dict[str, Any]) -> None:
        self.options = options

    def close(self) -> None: ...


def test_a_chamber_of_another_package_that_cannot_be_set_is_refused_where_it_is_to_be(monkeypatch):
    point = EntryPoint("own", f"{__name__}:OnlyMeasures", "mimucal.chambers")
    monkeypatch.setattr(EntryPoint, "load", lambda _: OnlyMeasures)
    monkeypatch.setattr(module, "entry_points", lambda group: [point] * (group == point.group))
    made, device = Devices(("a",)), PythonDevice(driver="python", name="own")

    asyncio.run(made.chamber(device, is_set=False))
    with pytest.raises(Unusable, match=r"driver own .* no method set_temperature"):
        asyncio.run(made.chamber(device, is_set=True))


class Words:
    """A link that answers every register with its address and notes what was asked."""

    url = "nowhere"

    def __init__(self) -> None:
        self.asked: list[tuple[str, int, int]] = []

    async def read(self, device: int, bank: str, address: int, count: int) -> list[int]:
        self.asked.append((bank, address, count))
        return list(range(address, address + count))


def read(name: str, *names: str) -> tuple[dict[str, Any], list[tuple[str, int, int]]]:
    table, link = ModbusTable.model_validate(sample(name)["table"]), Words()
    backend = ModbusBackend(table, link, 3)  # type: ignore[arg-type]
    return dict(asyncio.run(backend.read(frozenset(names)))), link.asked


def test_a_state_that_may_be_read_across_gaps_is_of_one_moment():
    _, asked = read("mimucal", "status", "time", "angle", "rate", "axis_status")
    assert asked == [("holding", 3, 57)]


def test_registers_apart_are_read_apart_and_of_each_axis():
    values, asked = read("modbus_polled", "angle", "axis_state", "safety")
    assert asked == [("input", 100, 6), ("input", 140, 3), ("input", 150, 1)]
    assert values["angle"] == pytest.approx([(a + (a + 1) * 65536) / 1000 for a in (100, 102, 104)])
    assert values["axis_state"] == (140, 141, 142)
    assert values["safety"] == 150


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"commands": {}}, "commands.move_to is missing"),
        ({"flags": {"settled": {"of": "nothing"}}}, "nothing reads nothing"),
        ({"flags": {"ready": {"of": "status"}}}, "there is no flag ready"),
        ({"expect": {"serial": 1}}, "nothing reads serial"),
    ],
)
def test_a_description_that_does_not_hold_together_is_refused(change, says):
    with pytest.raises(ValidationError, match=says):
        TABLE.validate_python(sample()["table"] | change)


def test_a_bit_is_in_a_bank_of_bits_and_nothing_else_is():
    with pytest.raises(ValidationError, match="is of type bit"):
        Register(address=1, bank="coil")
