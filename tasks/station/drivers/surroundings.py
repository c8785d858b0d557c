"""The chamber and the fixture of a station file, whatever their protocol."""

import asyncio
from dataclasses import dataclass

from schemas.base import Unusable
from schemas.devices import ModbusChamber, ModbusFixture, TextChamber, TextFixture
from schemas.procedure import Refix
from schemas.station import SET_TEMPERATURE
from tasks.station.drivers.backend import Backend
from tasks.station.ports import Climate

POLL_S = 0.02
TURN_TIMEOUT_S = 30.0  # wall time
MEASURED = ("temperature", "humidity", "supply_voltage", "pressure")


@dataclass(frozen=True)
class DescribedChamber:
    """Air temperature, and whatever else it measures. Raises as its backend does."""

    described: ModbusChamber | TextChamber
    backend: Backend

    async def climate(self) -> Climate:
        """Read the chamber once."""
        names = frozenset((*MEASURED, "time")) & self.described.readings
        values = await self.backend.read(names)
        measured = {name: float(values.get(name, float("nan"))) for name in MEASURED}
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
            f"whether it is blocked"
        )
