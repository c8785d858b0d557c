"""The unit turned over in its fixture: by a person who says so, or by the station itself."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Protocol

from schemas.base import Unusable
from schemas.procedure import Procedure, Refix
from schemas.recording import Mount
from schemas.station import FIXTURE_DEVICE, FIXTURE_REGISTERS, FIXTURE_STATUS, StationFile
from tasks.station.modbus import Link

Ask = Callable[[Refix], Awaitable[None]]
POLL_S = 0.02
LONGEST_S = 30.0  # wall time that a commanded fixture may take

_REGISTERS = {register.name: register for register in FIXTURE_REGISTERS}


class Fixture(Protocol):
    """What can bring the unit to another attitude."""

    async def turn(self, refix: Refix) -> float | None:
        """Do it; the station time (s) at which the unit was switched on again, where known."""
        ...


class ByHand:
    """A person does it, the supply too, and says when it is done."""

    def __init__(self, ask: Ask) -> None:
        self._ask = ask

    async def turn(self, refix: Refix) -> float | None:
        await self._ask(refix)
        return None


class Commanded:
    """The station does it. Raises Unusable as Link does, and where the fixture does not arrive."""

    def __init__(self, link: Link) -> None:
        self._link = link

    async def turn(self, refix: Refix) -> float | None:
        if refix.power_off:
            await self._set("supply", 0)
        for name, value in zip(("qw", "qx", "qy", "qz"), refix.mount.quaternion_wxyz, strict=True):
            await self._set(name, value)
        await self._set("turn", 1)
        await self._arrival(refix)
        if not refix.power_off:
            return None
        await self._set("supply", 1)
        told = await self._link.read(FIXTURE_DEVICE, [_REGISTERS["supply_on_time"]])
        return float(told["supply_on_time"]) / 1e6

    async def _arrival(self, refix: Refix) -> None:
        for _ in range(round(LONGEST_S / POLL_S)):
            told = await self._link.read(FIXTURE_DEVICE, [_REGISTERS["status"]])
            if told["status"] & FIXTURE_STATUS["ready"]:
                return
            await asyncio.sleep(POLL_S)
        raise Unusable(
            f"the fixture has not arrived at {refix.name} within {LONGEST_S:.0f} s: look whether "
            f"it is blocked"
        )

    async def _set(self, name: str, value: float) -> None:
        await self._link.write(FIXTURE_DEVICE, _REGISTERS[name], value)


def fixture_of(station: StationFile, link: Link, ask: Ask | None) -> Fixture | None:
    """Who turns the unit over at a station; None where a person has to and none is there."""
    if station.fixture == "commanded":
        return Commanded(link)
    return ByHand(ask) if ask is not None else None


def check_attended(procedure: Procedure, station: StationFile, ask: Ask | None) -> None:
    """Raises Unusable where a unit is to be turned over by a person and none is there."""
    refixes = sum(isinstance(step, Refix) for step in procedure.steps)
    if refixes and station.fixture == "by_hand" and ask is None:
        raise Unusable(
            f"procedure {procedure.name} has the unit turned over by hand {refixes} times, and "
            f"nobody is at a terminal to be asked: run it in a terminal and without --json, or on "
            f"a station whose fixture is commanded"
        )


def mount_in(fixture: Mount, inside: Mount) -> Mount:
    """Attitude of the unit on the payload: that of the fixture, then that of the unit in it."""
    from scipy.spatial.transform import Rotation

    outer, inner = (
        Rotation.from_quat(mount.quaternion_wxyz, scalar_first=True) for mount in (fixture, inside)
    )
    return Mount(quaternion_wxyz=tuple((outer * inner).as_quat(scalar_first=True).tolist()))
