"""Checks every device of a station file: what it reads, and on request a small move."""

import asyncio
import math
from collections.abc import Awaitable, Callable, Iterable, Mapping
from contextlib import closing, suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from schemas.base import Unusable
from schemas.laboratory import Limits
from schemas.recording import ACCEL, ANGLE, GYRO
from schemas.station import PythonDevice, StationFile
from schemas.text import Statement
from tasks.station.clock import wall_s
from tasks.station.connected_station import StopSwitch, run_until_stopped
from tasks.station.drivers.backend import serial_of
from tasks.station.drivers.devices import Devices
from tasks.station.drivers.unit import UnitDriver, UnitLine
from tasks.station.plan import SetPoint, move_s
from tasks.station.ports import Climate, Fixture, Table, TableState
from tasks.words import Message, Sayable, message, statement

# Values that a device can possibly read: what lies beyond was read wrongly.

# Wider than any chamber, room or supply of a laboratory.
CLIMATE = {
    "temperature": (-100.0, 200.0, "°C"),
    "humidity": (0.0, 100.0, "%RH"),
    "supply_voltage": (-1000.0, 1000.0, "V"),
    "pressure": (100.0, 1300.0, "hPa"),
}
TEMPERATURE = CLIMATE["temperature"]
NEARLY_NOTHING = 1e-12  # but not 0: what words in the wrong order make of a round number
ROUNDED = 5.0  # %RH: a sensor of moist or dry air reads a little beyond
MOST_ANGLE_DEG, MOST_RATE_DEG_S = 1e8, 1e4
RATE_RAD_S, FORCE_M_S2 = 200.0, 2000.0  # of a unit whose ranges are not stated
G = 9.80665
AT_REST_M_S2 = (0.5 * G, 2.0 * G)  # of gravity, by the worst unit
SAMPLING = 0.2  # of unit_link.rate_hz
READ_WRONGLY = "check address, type, orders and scale, or the query's answer"


def check_climate(climate: Climate, read: Iterable[str]) -> None:
    """Raises Unusable, naming every value that is none or is impossible, of those that are read."""
    faults = []
    for name in CLIMATE:
        low, high, unit = CLIMATE[name]
        slack = ROUNDED if name == "humidity" else 0.0
        if name in read:
            value = getattr(climate, name)
            faults += _fault(name, value, (low - slack, high + slack), unit)
            if 0.0 < abs(value) < NEARLY_NOTHING:
                faults.append(f"{name} is {value:.2g} {unit}, which no sensor tells from 0")
    _raise("chamber", faults, READ_WRONGLY)


def check_state(state: TableState, names: tuple[str, ...]) -> None:
    """Raises Unusable, naming every angle, rate or time that is none or is impossible."""
    faults = _fault("time", state.station_s, (-1e-6, 1e12), "s")
    for name, axis in zip(names, state.axes, strict=True):
        angles = (-MOST_ANGLE_DEG, MOST_ANGLE_DEG)
        faults += _fault(f"angle of axis {name}", axis.angle_deg, angles, "deg")
        rates = (-MOST_RATE_DEG_S, MOST_RATE_DEG_S)
        faults += _fault(f"rate of axis {name}", axis.rate_deg_s, rates, "deg/s")
    _raise("table", faults, READ_WRONGLY)


def check_unit(station: StationFile, rate_hz: float, means: Mapping[str, float]) -> None:
    """Raises Unusable, naming every mean that is none or is impossible of a unit on a table at
    rest, and a sampling rate that is not the stated one.

    means: by channel, SI.
    """
    unit, stated_hz = station.unit.model_extra or {}, station.unit_link.rate_hz
    rate = math.radians(unit.get("rate_range_deg_s") or math.degrees(RATE_RAD_S))
    force = G * (unit.get("accel_range_g") or FORCE_M_S2 / G)
    faults = []
    for name, mean in means.items():
        if name in GYRO:
            faults += _fault(name, mean, (-rate, rate), "rad/s")
        elif name in ACCEL:
            faults += _fault(name, mean, (-force, force), "m/s²")
        elif name == "temperature":
            faults += _fault(name, mean, TEMPERATURE[:2], TEMPERATURE[2])
        elif name in ANGLE:
            faults += _fault(name, mean, (-math.inf, math.inf), "rad")
    if not faults and set(ACCEL) <= means.keys():
        felt = math.hypot(*(means[name] for name in ACCEL))
        faults += _fault("gravity by the accelerometers", felt, AT_REST_M_S2, "m/s²")
    sampled = ((1.0 - SAMPLING) * stated_hz, (1.0 + SAMPLING) * stated_hz)
    faults += _fault("rate_hz", rate_hz, sampled, "Hz")
    _raise("unit", faults, "check fields, units and scale, and rate_hz of unit_link")


def _fault(name: str, value: float, possible: tuple[float, float], unit: str) -> list[str]:
    low, high = possible
    if not math.isfinite(value):
        return [f"{name} is no number ({value})"]
    if low <= value <= high:
        return []
    return [f"{name} is {value:.4g} {unit} where {low:.4g} to {high:.4g} {unit} is possible"]


def _raise(what: str, faults: list[str], way_out: str) -> None:
    if faults:
        raise Unusable(f"of the {what}, {'; '.join(faults)}: {way_out} in the station file")


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
