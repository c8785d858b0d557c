"""Checks every device of a station file: what it reads, and on request a small move."""

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import closing, suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from schemas.base import Unusable
from schemas.devices import PythonDevice
from schemas.limits import Limits
from schemas.station import StationFile
from schemas.text import Statement
from tasks.station.clock import wall_s
from tasks.station.drivers.devices import Devices
from tasks.station.drivers.identity import serial_of
from tasks.station.drivers.unit import UnitDriver
from tasks.station.drivers.unit_line import UnitLine
from tasks.station.plan import SetPoint, move_s
from tasks.station.ports import Climate, Fixture, Table, TableState
from tasks.station.possible import CLIMATE, check_climate, check_state, check_unit
from tasks.station.stopping import StopSwitch, run_until_stopped
from tasks.words import Message, Sayable, message, statement

MOVE_DEG = 1.0
MOVE_RATE_DEG_S = 5.0
MOVE_ACCELERATION_DEG_S2 = 10.0
MOVE_MARGIN_S = 20.0
POLL_S = 0.1
ENCODER_S = 1.0
UNIT_S = 2.0
LEAVE_S = 5.0


@dataclass(frozen=True)
class Trial:
    """One thing that was tried: what came of it, or why it does not work."""

    device: str
    tried: str
    works: bool
    found: Statement


def check_station(
    station: StationFile, move: bool, stop: StopSwitch | None = None
) -> tuple[Trial, ...]:
    """Try every device; with `move`, turn each axis by MOVE_DEG and back.

    Raises StopRequested where the switch was pressed; the table is then stopped.
    """
    return run_until_stopped(_check(station, move), stop or StopSwitch())


async def _check(station: StationFile, move: bool) -> tuple[Trial, ...]:
    names = tuple(axis.name for axis in station.station.table_axes or ())
    devices, trials = Devices(names), _Trials()
    try:
        found = devices.table(station.table)
        table: Table | None = await trials.of("table", "found", found, _is_one)
        if table is not None:
            await _check_table(table, trials, station.limits if move else None)
        await trials.of("chamber", "climate", _climate_of(devices, station), _climate)
        if station.fixture != "by_hand":
            fixture: Awaitable[Fixture] = devices.fixture(station.fixture)
            await trials.of("fixture", "found", fixture, _is_one)
        for alone in station.per_unit():
            name = f"unit {alone.unit.serial}" if station.other_units else "unit"
            if alone.unit_link.identify is not None:
                await trials.of(name, "serial", _serial(alone), _itself)
            await trials.of(name, "samples", _unit(alone), _itself)
    finally:
        await devices.hang_up()
    return tuple(trials.made)


class _Trials:
    def __init__(self) -> None:
        self.made: list[Trial] = []

    async def of(
        self, device: str, tried: str, work: Awaitable[Any], found: Callable[[Any], Sayable]
    ) -> Any:
        """What the work gives; None where it does not work."""
        try:
            given = await work
            sentence = statement(found(given))
        except Unusable as fault:
            self.made.append(Trial(device, tried, False, statement(str(fault))))
            return None
        self.made.append(Trial(device, tried, True, sentence))
        return given


async def _check_table(table: Table, trials: _Trials, move: Limits | None) -> None:
    await trials.of("table", "state", table.state(), lambda state: _state(state, table.names))
    await trials.of("table", "encoder", _encoder(table), _itself)
    if move is None:
        return
    try:
        await trials.of("table", "home", table.home(), lambda _: message("station-check-homed"))
        if not trials.made[-1].works:
            return
        for axis, name in enumerate(table.names):
            await trials.of("table", f"move {name}", _move(table, axis, move), _itself)
    finally:
        with suppress(Unusable, OSError, TimeoutError):
            await asyncio.wait_for(table.leave(), LEAVE_S)


async def _encoder(table: Table) -> Message:
    """Samples over ENCODER_S of wall time, or one block's where they are captured."""
    first, times = 0, np.empty(0)
    end_s = wall_s() + ENCODER_S
    while wall_s() < end_s and len(times) < 2 * table.block_samples + 2:
        block = await table.encoder(first)
        first = block.first + len(block.t)
        times = np.concatenate([times, block.t])
    if len(times) < 2:
        raise Unusable(
            f"the table gave {len(times)} encoder samples in {ENCODER_S:g} s: check capture or "
            f"poll_period_ms of the station file"
        )
    every_ms = f"{1e3 * float(np.median(np.diff(times))):.1f}"
    if not table.time_half_width_s:
        return message("station-check-captured", every=every_ms)
    half_width_ms = f"{1e3 * table.time_half_width_s:.1f}"
    return message("station-check-polled", every=every_ms, half_width=half_width_ms)


async def _move(table: Table, axis: int, limits: Limits) -> Message:
    """Turn by MOVE_DEG and back, the other way where the limits leave no room."""
    start = (await table.state()).axes[axis].angle_deg
    highest = min(
        (each.angle_deg[1] for _, each in limits.of(table.names[axis]) if each.angle_deg),
        default=np.inf,
    )
    away = MOVE_DEG if start + MOVE_DEG <= highest else -MOVE_DEG
    reached = []
    for angle in (start + away, start):
        target = SetPoint(axis, "angle", angle)
        await table.move_to(axis, angle, MOVE_RATE_DEG_S, MOVE_ACCELERATION_DEG_S2)
        seconds = move_s(MOVE_DEG, MOVE_RATE_DEG_S, MOVE_ACCELERATION_DEG_S2) + MOVE_MARGIN_S
        end_s = wall_s() + seconds
        while not target.is_reached((state := await table.state()).axes[axis]):
            if wall_s() > end_s:
                at = state.axes[axis].angle_deg
                raise Unusable(
                    f"axis {table.names[axis]} was sent to {angle:.4f} deg and has not settled "
                    f"after {seconds:.0f} s (it is at {at:.4f} deg): check that the axis is free, "
                    f"and move_to, the scale of angle and the flags in the station file"
                )
            await asyncio.sleep(POLL_S)
        reached.append(abs(state.axes[axis].angle_deg - angle))
    return message(
        "station-check-moved", angle=f"{MOVE_DEG:g}", within=f"{3600 * max(reached):.1f}"
    )


async def _unit(station: StationFile) -> Message:
    """The samples of UNIT_S of wall time."""
    with closing(UnitLine(station.unit_link)) as line:
        unit, began_s = UnitDriver(station.unit_link, line), wall_s()
        taken: list[np.ndarray] = []
        while wall_s() - began_s < UNIT_S or not taken:
            await asyncio.sleep(POLL_S)
            taken += [samples for samples in unit.take() if len(samples)]
        samples = np.concatenate(taken)
    means = unit.stream(samples).stack(tuple(station.unit_link.frame.channels)).mean(axis=0)
    channels = dict(zip(station.unit_link.frame.channels, means.tolist(), strict=True))
    seconds = max((samples["stamp"][-1] - samples["stamp"][0]) / 1e6, 1e-9)
    rate_hz = (len(samples) - 1) / seconds
    check_unit(station, rate_hz, channels)
    return message(
        "station-check-unit",
        rate=f"{rate_hz:.1f}",
        bad=unit.bad_frames,
        means=tuple(f"{name} {mean:.4g}" for name, mean in channels.items()),
    )


async def _serial(station: StationFile) -> Message:
    """The serial number that the unit tells, whichever the station file names."""
    link = station.unit_link
    assert link.identify is not None
    serial = serial_of(link, link.identify)
    return message("station-check-serial", serial=serial, named=station.unit.serial)


async def _climate_of(devices: Devices, station: StationFile) -> Climate:
    is_set = station.limits.chamber is not None
    climate = await (await devices.chamber(station.chamber, is_set)).climate()
    if isinstance(station.chamber, PythonDevice):  # NaN where it does not measure
        read = frozenset(name for name in CLIMATE if not np.isnan(getattr(climate, name)))
    else:
        read = station.chamber.readings
    check_climate(climate, read)
    return climate


def _itself(found: Message) -> Message:
    return found


def _is_one(_: Any) -> Message:
    return message("station-check-found")


def _state(state: TableState, names: tuple[str, ...]) -> Message:
    check_state(state, names)
    axes = tuple(
        f"{name} {axis.angle_deg:.4f}°, {axis.rate_deg_s:.4f} °/s"
        for name, axis in zip(names, state.axes, strict=True)
    )
    trips = tuple(sorted(state.trips.union(*(axis.trips for axis in state.axes))))
    return message("station-check-state", axes=axes, trips=trips, count=len(trips))


def _climate(climate: Climate) -> Message:
    values = {
        "°C": climate.temperature,
        "%RH": climate.humidity,
        "V": climate.supply_voltage,
        "hPa": climate.pressure,
    }
    known = tuple(f"{value:g} {unit}" for unit, value in values.items() if not np.isnan(value))
    return message("station-check-climate", values=known)
