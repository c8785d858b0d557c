"""Devices made from descriptions, and drivers of other packages found by entry point."""

import asyncio
from importlib.metadata import EntryPoint
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from schemas.base import Unusable
from schemas.described import Register
from schemas.station import ModbusTable, PythonDevice, StationFile, TableDevice
from tasks.station.drivers import devices as module
from tasks.station.drivers.devices import Devices
from tasks.station.drivers.modbus import ModbusBackend
from tasks.station.drivers.table import AngleUnwrapper
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


@pytest.mark.parametrize(
    ("name", "change", "says"),
    [
        ("text_table", {"commands": {"stop": ["STOP"]}}, r"commands.stop has no \{axis\}"),
        ("text_table", {"commands": {"move_to": ["MOVE 1 {angle}"]}}, r"commands.move_to has no"),
        ("text_table", {"axes": ["A", "B"]}, "3 axes, and in table axes lists 2"),
        ("text_table", {"queries": [{"ask": "P?", "answer": "{angle[0]},{angle[1]} {status:x}"}]},
         r"no query reads the angle of each axis, \{angle\[0\]\} to \{angle\[2\]\}"),
        ("text_table", {"acknowledge": "OK", "errors": {"ask": "E?", "none": "0"}},
         "acknowledge and errors"),
        ("text_table", {"commands": {"move_to": ["MOVE {axis} {angle_in_turn}"]}},
         "give turnover_deg"),
        ("text_table", {"turnover_deg": 360.0, "counter_bits": 24}, "turnover_deg and counter"),
        ("modbus_polled", {"commands": {"stop": [{"write": "drives_on", "value": 0}]}},
         "commands.stop writes no register with a stride"),
    ],
)  # fmt: skip
def test_what_is_not_of_each_axis_is_refused(name, change, says):
    fields = sample(name)
    fields["table"]["expect"] = {}
    commands = fields["table"]["commands"] | change.get("commands", {})
    fields["table"] |= change | {"commands": commands}
    with pytest.raises(ValidationError, match=says):
        StationFile.model_validate(fields)


def test_one_axis_needs_no_name_for_it():
    fields = sample("text_table")
    fields["station"]["table_axes"] = fields["station"]["table_axes"][:1]
    lines = {"move_to": ["MOVE {angle:.4f}"], "turn_at": ["JOG {rate:.4f}"], "stop": ["STOP"]}
    query = {"ask": "POS?", "answer": "{angle}"}
    fields["table"] |= {
        "axes": [],
        "expect": {},
        "flags": {},
        "commands": lines,
        "queries": [query],
    }
    assert StationFile.model_validate(fields).table.readings == {"angle"}


def test_a_counter_of_a_stated_width_turns_over_where_it_is_full():
    table = sample("three_letter_table")["table"]
    made = TABLE.validate_python(table)
    assert made.turnover == pytest.approx(2**26 * 1e-4)
    unwrapped = AngleUnwrapper(made.turnover)
    read = [3355.0, -3355.0, -3350.0, 3356.0]
    on = [unwrapped.at([angle], float(t))[0] for t, angle in enumerate(read)]
    assert on == pytest.approx([3355.0, 3355.8864, 3360.8864, 3356.0])


def test_an_angle_within_a_turn_runs_on_by_the_rate_over_a_gap():
    unwrapped, rate = AngleUnwrapper(360.0), 300.0
    for t in (0.0, 0.05, 0.1, 1.3, 1.35, 3.0):  # 1.3 s is more than a turn
        angle = unwrapped.at([rate * t % 360.0], t, np.array([rate]))[0]
        assert angle == pytest.approx(rate * t)


def test_a_bit_is_in_a_bank_of_bits_and_nothing_else_is():
    with pytest.raises(ValidationError, match="is of type bit"):
        Register(address=1, bank="coil")
