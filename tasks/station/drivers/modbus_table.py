"""The turntable through its register map."""

from collections.abc import Mapping

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
    MAP_VERSION,
    MODES,
    TABLE_DEVICE,
    TABLE_IDENT,
    TABLE_REGISTERS,
    TABLE_STATUS,
)
from tasks.station.clock import wall_s
from tasks.station.drivers.modbus import ModbusLink, decode, decode_all
from tasks.station.ports import TRIPS, AxisState, EncoderBlock, TableState, check_trips

WATCHDOG_MS = 5000

_TABLE = {register.name: register for register in TABLE_REGISTERS}
_AXIS = {register.name: register for register in AXIS_REGISTERS}
_CAPTURE = {register.name: register for register in CAPTURE_REGISTERS}


class ModbusTable:
    """A table of the documented register map, found by `find`. Raises as ModbusLink does."""

    def __init__(
        self, link: ModbusLink, names: tuple[str, ...], turns: tuple[int, ...], period_us: int
    ) -> None:
        self.names = names
        self.period_us = period_us
        self.block_samples = CAPTURE_VALUES // len(names)
        self._link = link
        self._is_held = False  # by this client, from `home` to `leave`
        self._turns = turns  # encoder counts in one, of each axis
        self._read: np.ndarray | None = None  # the last counts read, and where they run on to
        self._counts = np.zeros(len(names), np.int64)

    @classmethod
    async def find(cls, link: ModbusLink, names: tuple[str, ...]) -> "ModbusTable":
        """Read what the table is.

        Raises Unusable where it is no table of this map or has another number of axes.
        """
        head = await link.read(TABLE_DEVICE, TABLE_REGISTERS)
        where = f"the station at {link.host}:{link.port}"
        if head["ident"] != TABLE_IDENT or head["map_version"] != MAP_VERSION:
            raise Unusable(
                f"{where} has ident {head['ident']:#06x} and map version {head['map_version']} "
                f"where a mimucal table has {TABLE_IDENT:#06x} and {MAP_VERSION}: check "
                f"modbus_host and modbus_port of the station file"
            )
        if head["axes"] != len(names):
            raise Unusable(
                f"{where} has {head['axes']} axes where the station file lists {len(names)} in "
                f"station.table_axes: correct the station file"
            )
        if head["capture_period"] == 0:
            raise Unusable(f"{where} has a capture_period of 0: set one at the controller")
        axes = [
            await link.read(TABLE_DEVICE, AXIS_REGISTERS, _base(axis)) for axis in range(len(names))
        ]
        turns = tuple(axis["counts_per_turn"] for axis in axes)
        if 0 in turns:
            raise Unusable(
                f"{where} says that axis {names[turns.index(0)]} has 0 encoder counts in a turn: "
                f"set counts_per_turn at the controller"
            )
        return cls(link, names, turns, head["capture_period"])

    async def home(self) -> None:
        """Clear an old watchdog stop and hold the table by its watchdog; the encoders are absolute.

        Raises Unusable where the table is not ready to move, or another client holds it.
        """
        state = await self.state()
        if state.trips == {"watchdog"}:  # an earlier run was cut off; nothing is wrong
            await self._command("reset")
        self._is_held = True
        check_trips(await self.state(), self.names)

    async def state(self) -> TableState:
        """One request, so that all of it is of one moment; it renews the hold on the table."""
        first, last = _TABLE["status"].address, AXIS_REGISTERS[-1]
        end = _base(len(self.names) - 1) + last.address + last.words
        if self._is_held:  # the connection may be another than that which held it before
            words = await self._link.write_then_read(
                TABLE_DEVICE, _TABLE["watchdog"], WATCHDOG_MS, first, end - first
            )
        else:
            words = await self._link.read_words(TABLE_DEVICE, first, end - first)
        head = decode_all(words, first, (_TABLE["status"], _TABLE["station_time"]))
        axes = [
            decode_all(words, first - _base(axis), AXIS_REGISTERS)
            for axis in range(len(self.names))
        ]
        return TableState(
            station_s=head["station_time"] / 1e6,
            wall_s=wall_s(),
            axes=tuple(
                AxisState(
                    angle_deg=axis["angle"] * 360.0 / turn,
                    rate_deg_s=axis["rate"],
                    is_moving=bool(axis["status"] & AXIS_STATUS["moving"]),
                    is_settled=bool(axis["status"] & AXIS_STATUS["settled"]),
                    trips=_trips(axis["status"], AXIS_STATUS),
                )
                for axis, turn in zip(axes, self._turns, strict=True)
            ),
            trips=_trips(head["status"], TABLE_STATUS),
        )

    async def move_to(self, axis: int, angle: float, rate: float, acceleration: float) -> None:
        """Send an axis to an angle (deg) at a rate (deg/s)."""
        await self._write(axis, "target_angle", angle)
        await self._start(axis, "angle", rate, acceleration)

    async def turn_at(self, axis: int, rate: float, acceleration: float) -> None:
        """Turn an axis at a rate (deg/s)."""
        await self._start(axis, "rate", rate, acceleration)

    async def stop(self, axis: int) -> None:
        """Ramp an axis to rest."""
        await self._write(axis, "mode", MODES["stop"])

    async def leave(self) -> None:
        """Stop every axis and let the table go, on a fresh connection."""
        self._is_held = False
        self._link.close()
        await self._command("stop")
        await self._link.write(TABLE_DEVICE, _TABLE["watchdog"], 0)

    async def encoder(self, first: int) -> EncoderBlock:
        """The captured samples from number `first` on, or from the oldest one kept."""
        start, axes = _CAPTURE["capture_count"].address, len(self.names)
        wanted = _CAPTURE["capture_samples"].address - start + 2 * axes * self.block_samples
        words = await self._link.write_then_read(
            TABLE_DEVICE, _CAPTURE["capture_from"], first, start, wanted
        )
        count = min(words[0], self.block_samples)
        samples = np.array(words[3 : 3 + 2 * axes * count], ">u2").view(">i4")
        counts = samples.astype(np.int64).reshape(count, axes)
        angles = self._past_turnover(counts) * (2 * np.pi / np.array(self._turns))
        return EncoderBlock(decode(words[1:3], "uint32"), angles)

    def _past_turnover(self, read: np.ndarray) -> np.ndarray:
        """Counts (n, axes) that run on where the register (int32) turns over."""
        if not len(read):
            return read
        if self._read is None:
            self._read = self._counts = read[0]
        steps = (np.diff(read, axis=0, prepend=self._read[None]) + 2**31) % 2**32 - 2**31
        counts = self._counts + np.cumsum(steps, axis=0)
        self._read, self._counts = read[-1], counts[-1]
        return counts

    async def _start(self, axis: int, mode: str, rate: float, acceleration: float) -> None:
        await self._write(axis, "target_rate", rate)
        await self._write(axis, "acceleration_limit", acceleration)
        await self._write(axis, "mode", MODES[mode])

    async def _write(self, axis: int, name: str, value: float) -> None:
        await self._link.write(TABLE_DEVICE, _AXIS[name], value, _base(axis))

    async def _command(self, name: str) -> None:
        await self._link.write(TABLE_DEVICE, _TABLE["command"], COMMANDS[name])


def _base(axis: int) -> int:
    return AXIS_BASE + axis * AXIS_STRIDE


def _trips(status: int, bits: Mapping[str, int]) -> frozenset[str]:
    return frozenset(trip for trip in TRIPS if status & bits.get(trip, 0))
