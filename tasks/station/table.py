"""The turntable through its register map: state, moves, rates, captured encoders."""

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from schemas.base import Unusable
from schemas.station import (
    AXIS_BASE,
    AXIS_REGISTERS,
    AXIS_STATUS,
    AXIS_STRIDE,
    CAPTURE_REGISTERS,
    CAPTURE_VALUES,
    COMMANDS,
    MODES,
    TABLE_DEVICE,
    TABLE_REGISTERS,
    TABLE_STATUS,
    Register,
)
from tasks.station.modbus import Link, decode

IDENT = 0x4D54
MAP_VERSION = 1
WATCHDOG_MS = 5000

_TABLE = {register.name: register for register in TABLE_REGISTERS}
_AXIS = {register.name: register for register in AXIS_REGISTERS}
_CAPTURE = {register.name: register for register in CAPTURE_REGISTERS}

WAYS_OUT = {
    "fault": "read the fault at the controller, clear it there and start again",
    "emergency_stop": "make the table safe, release the emergency stop, reset the table and "
    "start again",
    "interlock": "close the guard, reset the table and start again",
    "watchdog": "the table heard nothing for too long and stopped itself, so check the network, "
    "reset the table and start again",
}


@dataclass(frozen=True)
class AxisState:
    """One axis: bits of AXIS_STATUS, angle (deg, past whole turns), rate (deg/s)."""

    status: int
    angle_deg: float
    rate_deg_s: float

    def has(self, bit: str) -> bool:
        return bool(self.status & AXIS_STATUS[bit])


@dataclass(frozen=True)
class TableState:
    """The table at a station time (s), read at a wall time (time.monotonic, s)."""

    station_s: float
    wall_s: float
    status: int
    axes: tuple[AxisState, ...]


@dataclass(frozen=True)
class Block:
    """Captured encoder counts, (n, axes): sample `first` + i is station time that × period."""

    first: int
    counts: np.ndarray


class Table:
    """A table that has been found to be one. Angles and rates in degrees, as its registers are."""

    def __init__(
        self, link: Link, names: tuple[str, ...], counts_per_turn: tuple[int, ...], period_us: int
    ) -> None:
        self.link = link
        self.names = names
        self.counts_per_turn = counts_per_turn
        self.period_us = period_us
        self.block_samples = CAPTURE_VALUES // len(names)

    @classmethod
    async def find(cls, link: Link, names: tuple[str, ...]) -> "Table":
        """Read what the table is, clear an old watchdog stop and start the watchdog.

        Raises Unusable where it is no table of this map, has another number of axes, or is
        not ready to move.
        """
        head = await link.read(TABLE_DEVICE, TABLE_REGISTERS)
        where = f"the station at {link.host}:{link.port}"
        if head["ident"] != IDENT or head["map_version"] != MAP_VERSION:
            raise Unusable(
                f"{where} has ident {head['ident']:#06x} and map version {head['map_version']} "
                f"where a mimucal table has {IDENT:#06x} and {MAP_VERSION}: check modbus_host and "
                f"modbus_port of the station file"
            )
        if head["axes"] != len(names):
            raise Unusable(
                f"{where} has {head['axes']} axes where the station file lists {len(names)} in "
                f"station.table_axes: correct the station file"
            )
        if head["capture_period"] == 0:
            raise Unusable(f"{where} has a capture_period of 0: set one at the controller")
        turns = [
            (await link.read(TABLE_DEVICE, [_AXIS["counts_per_turn"]], _base(axis)))[
                "counts_per_turn"
            ]
            for axis in range(len(names))
        ]
        if 0 in turns:
            raise Unusable(
                f"{where} says that axis {names[turns.index(0)]} has 0 encoder counts in a turn: "
                f"set counts_per_turn at the controller"
            )
        table = cls(link, names, tuple(turns), head["capture_period"])
        tripped = head["status"] & sum(TABLE_STATUS[bit] for bit in WAYS_OUT)
        if tripped == TABLE_STATUS["watchdog"]:  # an earlier run was cut off; nothing is wrong
            await table.command("reset")
        await link.write(TABLE_DEVICE, _TABLE["watchdog"], WATCHDOG_MS)
        check(await table.state(), names)
        return table

    async def state(self) -> TableState:
        """The table and its axes now: one request, so that all of it is of one moment."""
        first, last = _TABLE["status"].address, AXIS_REGISTERS[-1]
        end = _base(len(self.names) - 1) + last.address + last.words
        words = await self.link.read_words(TABLE_DEVICE, first, end - first)
        wall_s = time.monotonic()

        def value(register: Register, base: int = 0) -> Any:
            start = base + register.address - first
            return decode(words[start : start + register.words], register.type)

        return TableState(
            station_s=value(_TABLE["station_time"]) / 1e6,
            wall_s=wall_s,
            status=value(_TABLE["status"]),
            axes=tuple(
                AxisState(
                    status=value(_AXIS["status"], _base(axis)),
                    angle_deg=value(_AXIS["angle"], _base(axis)) * 360.0 / turn,
                    rate_deg_s=value(_AXIS["rate"], _base(axis)),
                )
                for axis, turn in enumerate(self.counts_per_turn)
            ),
        )

    async def go_to(self, axis: int, angle: float, rate: float, acceleration: float) -> None:
        """Send an axis to an angle (deg) at a rate (deg/s)."""
        await self._set(axis, "target_angle", angle)
        await self._drive(axis, "angle", rate, acceleration)

    async def hold_rate(self, axis: int, rate: float, acceleration: float) -> None:
        """Turn an axis at a rate (deg/s)."""
        await self._drive(axis, "rate", rate, acceleration)

    async def ramp_to_rest(self, axis: int) -> None:
        await self._set(axis, "mode", MODES["stop"])

    async def command(self, name: str) -> None:
        """A command of COMMANDS to the whole table."""
        await self.link.write(TABLE_DEVICE, _TABLE["command"], COMMANDS[name])

    async def leave(self) -> None:
        """Stop every axis and switch the watchdog off, on a fresh connection."""
        self.link.close()
        await self.command("stop")
        await self.link.write(TABLE_DEVICE, _TABLE["watchdog"], 0)

    async def captured(self, first: int) -> Block:
        """The captured samples from number `first` on, or from the oldest one kept."""
        start = _CAPTURE["capture_count"].address
        samples = _CAPTURE["capture_samples"].address
        axes = len(self.names)
        words = await self.link.write_then_read(
            TABLE_DEVICE,
            _CAPTURE["capture_from"],
            first,
            start,
            samples - start + 2 * axes * self.block_samples,
        )
        count = min(words[0], self.block_samples)
        block_first = decode(words[1:3], "uint32")
        values = decode(words[3 : 3 + 2 * axes * count], "int32") if count else []
        return Block(block_first, np.array(values, dtype=np.int64).reshape(count, axes))

    async def _drive(self, axis: int, mode: str, rate: float, acceleration: float) -> None:
        await self._set(axis, "target_rate", rate)
        await self._set(axis, "acceleration_limit", acceleration)
        await self._set(axis, "mode", MODES[mode])

    async def _set(self, axis: int, name: str, value: float) -> None:
        await self.link.write(TABLE_DEVICE, _AXIS[name], value, _base(axis))


def check(state: TableState, names: tuple[str, ...]) -> None:
    """Raises Unusable, naming axis and bit, if a state shows that the table will not move."""
    for bit, way_out in WAYS_OUT.items():
        mask = AXIS_STATUS.get(bit, 0)
        for name, axis in zip(names, state.axes, strict=True):
            if axis.status & mask:
                raise Unusable(f"axis {name} of the table reports {bit}: {way_out}")
        if state.status & TABLE_STATUS[bit]:
            raise Unusable(f"the table reports {bit}: {way_out}")


def _base(axis: int) -> int:
    return AXIS_BASE + axis * AXIS_STRIDE
