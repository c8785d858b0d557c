"""Connects the devices of a station file, each by its description or its entry point."""

import asyncio
from dataclasses import dataclass
from importlib.metadata import entry_points
from typing import Any, TypeAlias

from schemas.base import Unusable
from schemas.described import Described, ModbusDevice, TextDevice
from schemas.procedure import Refix
from schemas.recording import ENVIRONMENT
from schemas.station import (
    SET_TEMPERATURE,
    ChamberDevice,
    FixtureDevice,
    ModbusChamber,
    ModbusFixture,
    PythonDevice,
    TableDevice,
    TextChamber,
    TextFixture,
)
from tasks.station.drivers.backend import Backend, check_expected
from tasks.station.drivers.modbus import ModbusBackend, ModbusLink
from tasks.station.drivers.table import DescribedTable
from tasks.station.drivers.text_device import TextBackend, TextLink
from tasks.station.ports import Chamber, Climate, Fixture, Table
from tasks.words import message

POLL_S = 0.02
TURN_TIMEOUT_S = 30.0  # wall time
GROUP = "mimucal.{kind}s"  # of entry points: mimucal.tables, mimucal.chambers, mimucal.fixtures
Link: TypeAlias = ModbusLink | TextLink


@dataclass(frozen=True)
class DescribedChamber:
    """Air temperature, and whatever else it measures. Raises as its backend does."""

    described: ModbusChamber | TextChamber
    backend: Backend

    async def climate(self) -> Climate:
        """Read the chamber once."""
        names = frozenset((*ENVIRONMENT, "time")) & self.described.readings
        values = await self.backend.read(names)
        measured = {name: float(values.get(name, float("nan"))) for name in ENVIRONMENT}
        return Climate(float(values.get("time", float("nan"))), **measured)

    async def set_temperature(self, degc: float) -> None:
        """Let the air go to a temperature."""
        await self.backend.command(SET_TEMPERATURE, {"temperature": degc})


@dataclass(frozen=True)
class DescribedFixture:
    """The station turns the unit over. Raises Unusable where the fixture does not arrive."""

    described: ModbusFixture | TextFixture
    backend: Backend

    async def turn(self, refix: Refix) -> float | None:
        """Turn, the supply off meanwhile where that is asked for."""
        if refix.power_off:
            await self._supply("supply_off", refix)
        attitude = zip(("qw", "qx", "qy", "qz"), refix.mount.quaternion_wxyz, strict=True)
        await self.backend.command("turn", dict(attitude))
        await self._arrival(refix)
        if not refix.power_off:
            return None
        await self._supply("supply_on", refix)
        if "supply_on_time" not in self.described.readings:
            return None
        return float((await self.backend.read(frozenset(("supply_on_time",))))["supply_on_time"])

    async def _supply(self, command: str, refix: Refix) -> None:
        if command not in self.described.commands:
            raise Unusable(
                f"{refix.name} asks for the unit's supply to be switched, and the fixture of the "
                f"station file has no command {command}: describe it there"
            )
        await self.backend.command(command, {})

    async def _arrival(self, refix: Refix) -> None:
        flag = self.described.flags.get("arrived")
        if flag is None:
            return
        for _ in range(round(TURN_TIMEOUT_S / POLL_S)):
            values = await self.backend.read(frozenset((flag.of,)))
            if flag.is_set(values[flag.of]):
                return
            await asyncio.sleep(POLL_S)
        raise Unusable(
            f"the fixture has not arrived at {refix.name} within {TURN_TIMEOUT_S:.0f} s: look "
            f"whether it is blocked",
            message("station-cause.fixture", turn=refix.name),
        )


class Devices:
    """Makes devices; those behind one URL share its connection.

    names: the table's axes, outer first. Raises Unusable where a device is not what its
    description expects, and where there is no driver of a name.
    """

    def __init__(self, names: tuple[str, ...]) -> None:
        self._names = names
        self._links: dict[str, Link] = {}
        self._drivers: list[Any] = []

    async def table(self, device: TableDevice) -> Table:
        """The table."""
        if not isinstance(device, PythonDevice):
            await check_expected(device, self._backend(device), "table")
        return self.table_unasked(device)

    def table_unasked(self, device: TableDevice) -> Table:
        """The table, whatever it is: it has not read what its description expects."""
        if isinstance(device, PythonDevice):
            table: Table = self._from_entry_point("table", device, self._names)
            return table
        return DescribedTable(device, self._backend(device), self._names)

    async def chamber(self, device: ChamberDevice, is_set: bool) -> Chamber:
        """The chamber. is_set: whether the station file has limits within which it is set."""
        if isinstance(device, PythonDevice):
            chamber: Chamber = self._from_entry_point("chamber", device)
            if is_set and not callable(getattr(chamber, SET_TEMPERATURE, None)):
                raise Unusable(
                    f"limits.chamber of the station file allows temperatures to be set, and the "
                    f"driver {device.name} of chamber.name has no method {SET_TEMPERATURE}: take "
                    f"limits.chamber out of the station file, or add the method to the driver"
                )
            return chamber
        backend = self._backend(device)
        await check_expected(device, backend, "chamber")
        return DescribedChamber(device, backend)

    async def fixture(self, device: FixtureDevice) -> Fixture:
        """The fixture."""
        if isinstance(device, PythonDevice):
            fixture: Fixture = self._from_entry_point("fixture", device)
            return fixture
        backend = self._backend(device)
        await check_expected(device, backend, "fixture")
        return DescribedFixture(device, backend)

    async def hang_up(self) -> None:
        """Hang up, in the event loop of the connections."""
        for each in (*self._links.values(), *self._drivers):
            each.close()

    def _backend(self, device: Described) -> Backend:
        axes = len(self._names)
        if isinstance(device, ModbusDevice):
            return ModbusBackend(device, self._shared(device, ModbusLink), axes)
        assert isinstance(device, TextDevice)
        return TextBackend(device, self._shared(device, TextLink), axes)

    def _shared(self, device: Any, kind: Any) -> Any:
        link = self._links.setdefault(device.url, kind(device))
        if not isinstance(link, kind):
            raise Unusable(
                f"url {device.url} is that of a Modbus device and of a text device: a connection "
                f"carries one of them, so correct the station file"
            )
        return link

    def _from_entry_point(self, kind: str, device: PythonDevice, *more: Any) -> Any:
        """One class of another package: called with its options, and a table with its axes."""
        group = GROUP.format(kind=kind)
        found = {point.name: point for point in entry_points(group=group)}
        if device.name not in found:
            there = ", ".join(sorted(found)) or "none"
            raise Unusable(
                f"there is no driver {device.name} in the entry points {group} (there are: "
                f"{there}): install its package, or correct {kind}.name of the station file"
            )
        driver = found[device.name].load()(dict(device.options), *more)
        self._drivers.append(driver)
        return driver
