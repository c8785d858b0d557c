"""The chamber and the fixture through their register maps."""

import asyncio
from dataclasses import dataclass

from schemas.base import Unusable
from schemas.procedure import Refix
from schemas.station import (
    CHAMBER_DEVICE,
    CHAMBER_REGISTERS,
    FIXTURE_DEVICE,
    FIXTURE_REGISTERS,
    FIXTURE_STATUS,
)
from tasks.station.drivers.modbus import ModbusLink
from tasks.station.ports import Climate

POLL_S = 0.02
TURN_TIMEOUT_S = 30.0  # wall time

_FIXTURE = {register.name: register for register in FIXTURE_REGISTERS}


@dataclass(frozen=True)
class ModbusChamber:
    """Air temperature and humidity, supply voltage and pressure. Raises as ModbusLink does."""

    link: ModbusLink

    async def climate(self) -> Climate:
        """Read the chamber once."""
        values = await self.link.read(CHAMBER_DEVICE, CHAMBER_REGISTERS)
        return Climate(values.pop("station_time") / 1e6, **values)


@dataclass(frozen=True)
class ModbusFixture:
    """The station turns the unit over. Raises Unusable where the fixture does not arrive."""

    link: ModbusLink

    async def turn(self, refix: Refix) -> float | None:
        """Turn, the supply off meanwhile where that is asked for."""
        if refix.power_off:
            await self._write("supply", 0)
        for name, value in zip(("qw", "qx", "qy", "qz"), refix.mount.quaternion_wxyz, strict=True):
            await self._write(name, value)
        await self._write("turn", 1)
        await self._arrival(refix)
        if not refix.power_off:
            return None
        await self._write("supply", 1)
        return float(await self._read("supply_on_time")) / 1e6

    async def _arrival(self, refix: Refix) -> None:
        for _ in range(round(TURN_TIMEOUT_S / POLL_S)):
            if await self._read("status") & FIXTURE_STATUS["ready"]:
                return
            await asyncio.sleep(POLL_S)
        raise Unusable(
            f"the fixture has not arrived at {refix.name} within {TURN_TIMEOUT_S:.0f} s: look "
            f"whether it is blocked"
        )

    async def _read(self, name: str) -> int:
        values = await self.link.read(FIXTURE_DEVICE, [_FIXTURE[name]])
        return int(values[name])

    async def _write(self, name: str, value: float) -> None:
        await self.link.write(FIXTURE_DEVICE, _FIXTURE[name], value)
