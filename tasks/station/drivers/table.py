"""The turntable of a station file, whatever its protocol."""

import asyncio
from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from schemas.base import Unusable
from schemas.described import Register
from schemas.station import Capture, ModbusTable, TextTable
from tasks.station.clock import wall_s
from tasks.station.drivers.backend import Backend, Values
from tasks.station.drivers.modbus import ModbusBackend, decode, encode
from tasks.station.ports import TRIPS, AxisState, EncoderBlock, TableState, check_trips
from tasks.words import message

# Encoder samples of a table: captured by its controller, or angles that are polled.


LATE_S = 5.0  # a poll that comes later leaves a gap: longer than what is read again
LONG, USUAL_OF, FEWEST = 2.5, 101, 5  # times the usual one, which is the median of so many
AGAIN = 2  # times that an angle is read whose time is known too badly


class LatencyMonitor:
    """Tells an exchange that took unusually long: it was repeated, or the computer was busy.

    When an angle was read in it is known too badly.
    """

    def __init__(self) -> None:
        self._took_s: deque[float] = deque(maxlen=USUAL_OF)

    def is_long(self, took_s: float) -> bool:
        """Whether the next one, of so many seconds, did."""
        usual_s = float(np.median(self._took_s)) if self.are_known else np.inf
        self._took_s.append(took_s)
        return took_s > LONG * usual_s

    @property
    def are_known(self) -> bool:
        """Whether what is usual is known."""
        return len(self._took_s) >= FEWEST


class AngleUnwrapper:
    """Angles (n, axes) in deg that continue where the encoder wraps.

    rates: (axes,) deg/s last known, by which it goes on between readings that are far apart.
    """

    def __init__(self, turnover_deg: float | None) -> None:
        self.rates: np.ndarray | None = None
        self._turnover = turnover_deg
        self._read: np.ndarray | None = None  # the last angles read, and what they have run on to
        self._angles = np.empty(0)
        self._read_s = 0.0

    def at(
        self, angle: Any, t: float, rates: np.ndarray | None = None, is_sure: bool = True
    ) -> np.ndarray:
        """The angles (axes,) of a reading at a time (s), with its rates where they are read.

        is_sure: of its time; otherwise the next one goes on from that before.
        """
        before = self.rates if self.rates is not None else rates
        after = before if rates is None else rates
        ahead = 0.0 if before is None or after is None else (before + after) / 2
        self.rates = after
        before_it = self._read, self._angles, self._read_s
        read = np.array([np.atleast_1d(angle)], float)
        angles = self(read, ahead * (t - self._read_s) if self._read is not None else 0.0)[0]
        self._read_s = t
        if not is_sure:
            self._read, self._angles, self._read_s = before_it
        return angles

    def __call__(self, read: np.ndarray, ahead: np.ndarray | float = 0.0) -> np.ndarray:
        """The angles of the next samples; ahead: by how much each is expected to have moved."""
        if self._turnover is None or not len(read):
            return read
        if self._read is None:
            self._read = self._angles = read[0]
        half = self._turnover / 2
        steps = np.diff(read, axis=0, prepend=self._read[None])
        turns = np.floor((steps - ahead + half) / self._turnover)
        angles = self._angles + np.cumsum(steps - turns * self._turnover, axis=0)
        self._read, self._angles = read[-1], angles[-1]
        return angles


class CapturedEncoders:
    """Blocks of samples that the controller took itself, through its registers."""

    def __init__(
        self, described: ModbusTable, capture: Capture, backend: ModbusBackend, axes: int
    ) -> None:
        self.period_us = capture.period_us
        self.block_samples = capture.values // axes
        self._axes = axes
        self._device = described.device
        self._backend, self._link = backend, backend.link
        registers = described.registers
        self._wanted, self._count = registers[capture.wanted], registers[capture.count]
        self._first, self._samples = registers[capture.first], registers[capture.samples]
        self._unwrapped = AngleUnwrapper(described.turnover)

    async def block(self, first: int) -> EncoderBlock:
        """The captured samples from number `first` on, or from the oldest one kept."""
        start, width = self._count.address, self._samples.words
        at = self._samples.address - start
        words = await self._link.write_then_read(
            self._device,
            self._wanted.address,
            encode(first, self._wanted.type, *self._backend.orders(self._wanted)),
            start,
            at + width * self._axes * self.block_samples,
        )
        count = int(self._held(words[: self._count.words], self._count))
        if not 0 <= count <= self.block_samples:
            raise Unusable(
                f"the table at {self._link.url} gives {count} samples where a block holds "
                f"{self.block_samples}: check capture in the station file"
            )
        place = self._first.address - start
        number = self._held(words[place : place + self._first.words], self._first)
        if not count:
            return EncoderBlock(int(number), np.empty((0, self._axes)), np.empty(0))
        read = self._held(words[at : at + width * self._axes * count], self._samples)
        degrees = np.reshape(read, (count, self._axes)) * self._samples.scale
        angles = np.radians(self._unwrapped(degrees + self._samples.offset))
        return EncoderBlock(
            int(number), angles, (np.arange(count) + int(number)) * self.period_us / 1e6
        )

    def _held(self, words: Sequence[int], register: Register) -> Any:
        return decode(words, register.type, *self._backend.orders(register))


class PolledEncoders:
    """The angles of a table that does not capture them, read one after another.

    The time of a sample is the table's own if it reports one, otherwise the middle of the exchange,
    since `began_s`. `time_half_width_s`: half of the longest exchange of a sample so far, the
    possible error of its time. What an exchange of unusual length gave is not kept.
    """

    block_samples = 1

    def __init__(
        self,
        described: ModbusTable | TextTable,
        backend: Backend,
        began_s: float,
        unwrapped: AngleUnwrapper,
    ) -> None:
        self.period_us = described.poll_period_ms * 1000
        self.time_half_width_s = 0.0
        self._backend = backend
        self._names = frozenset(("angle", "time")) & described.readings
        self._unwrapped = unwrapped
        self._began_s = began_s
        self._polled_s = -np.inf
        self._exchanges = LatencyMonitor()

    async def block(self, first: int) -> EncoderBlock:
        """One sample, a poll period after the one before; its number is `first`, or past it
        where the poll came late."""
        period_s = self.period_us / 1e6
        await asyncio.sleep(max(self._polled_s + period_s - wall_s(), 0.0))
        while not self._exchanges.are_known:
            asked_s, answered_s, _ = await self._asked()
            self._exchanges.is_long(answered_s - asked_s)
        for _ in range(AGAIN):
            asked_s, answered_s, values = await self._asked()
            if not self._exchanges.is_long(answered_s - asked_s):
                break
        late_s = asked_s - self._polled_s if np.isfinite(self._polled_s) else period_s
        skipped = round(late_s / period_s) - 1 if late_s > max(LATE_S, 2 * period_s) else 0
        self._polled_s = asked_s
        self.time_half_width_s = max(self.time_half_width_s, (answered_s - asked_s) / 2)
        t = float(values.get("time", (asked_s + answered_s) / 2 - self._began_s))
        angles = np.radians(self._unwrapped.at(values["angle"], t))
        return EncoderBlock(first + skipped, angles[None], np.array([t]))

    async def _asked(self) -> tuple[float, float, Values]:
        """When they were asked for and answered (wall time, s), and the values."""
        async with self._backend.alone():
            asked_s = wall_s()
            values = await self._backend.read(self._names)
            return asked_s, wall_s(), values


MOVING_DEG_S = 0.01  # where a table does not say itself whether it moves
POLL_S = 0.1


@dataclass
class Settling:
    """One axis and where it was sent: settled once it has stayed within the table's tolerance."""

    described: ModbusTable | TextTable
    kind: Literal["angle", "rate", "off"] = "off"
    target: float = 0.0
    _near_since_s: float | None = field(default=None)

    def send(self, kind: Literal["angle", "rate", "off"], target: float = 0.0) -> None:
        """The axis is sent to an angle (deg) or a rate (deg/s), or to no place."""
        self.kind, self.target, self._near_since_s = kind, target, None

    def is_settled(self, station_s: float, angle_deg: float, rate_deg_s: float) -> bool:
        """Whether an axis has settled, by a reading at a station time."""
        if not self._is_near(angle_deg, rate_deg_s):
            self._near_since_s = None
            return False
        if self._near_since_s is None:
            self._near_since_s = station_s
        return station_s - self._near_since_s >= self.described.settled_s

    def _is_near(self, angle_deg: float, rate_deg_s: float) -> bool:
        rate = self.described.settled_rate
        if self.kind == "angle":
            is_still = abs(rate_deg_s) <= rate
            return is_still and abs(angle_deg - self.target) <= self.described.settled_deg
        off = abs(rate_deg_s - self.target)
        return self.kind == "rate" and off <= rate * max(abs(self.target), 1.0)


class DescribedTable:
    """A table by its description. Raises as its backend does.

    If it reports no time, station time is the wall time since the connection.
    """

    def __init__(
        self, described: ModbusTable | TextTable, backend: Backend, names: tuple[str, ...]
    ) -> None:
        self.names = names
        self._described = described
        self._backend = backend
        self._is_held = False  # by this client, from `home` to `leave`
        self._began_s = wall_s()
        self._unwrapped = AngleUnwrapper(described.turnover)
        self._exchanges = LatencyMonitor()
        self._encoders = self._encoders_of(described, backend)
        shown = {"time", "angle", "rate"} | {flag.of for flag in described.flags.values()}
        self._state_names = frozenset(shown & described.readings)
        self._settling = [Settling(described) for _ in names]
        self._before: tuple[float, np.ndarray] | None = None  # station time and angles last read

    def _encoders_of(
        self, described: ModbusTable | TextTable, backend: Backend
    ) -> CapturedEncoders | PolledEncoders:
        if (
            isinstance(described, ModbusTable)
            and described.capture is not None
            and isinstance(backend, ModbusBackend)
        ):
            return CapturedEncoders(described, described.capture, backend, len(self.names))
        return PolledEncoders(described, backend, self._began_s, self._unwrapped)

    @property
    def period_us(self) -> int:
        """Time between two encoder samples."""
        return self._encoders.period_us

    @property
    def block_samples(self) -> int:
        """How many samples one block of `encoder` holds at most."""
        return self._encoders.block_samples

    @property
    def time_half_width_s(self) -> float:
        """How far an encoder sample's time may be wrong, s; 0 where the table captures them."""
        return getattr(self._encoders, "time_half_width_s", 0.0)

    async def home(self) -> None:
        """Clear an old watchdog stop, carry out `home` until the table is homed, and hold it.

        Raises Unusable where the table is not ready to move, or another client holds it.
        """
        state = await self.state()
        if state.trips == {"watchdog"}:  # an earlier run was cut off; nothing is wrong
            await self._backend.command("reset", {})
        await self._backend.command("home", {})
        if "homed" in self._described.flags:
            await self._until_homed()
        self._is_held = True
        check_trips(await self.state(), self.names)

    async def _until_homed(self) -> None:
        flag = self._described.flags["homed"]
        end_s = wall_s() + self._described.home_timeout_s
        while wall_s() < end_s:
            read = (await self._backend.read(frozenset((flag.of,))))[flag.of]
            if all(flag.is_set(each) for each in (read if isinstance(read, tuple) else (read,))):
                return
            await asyncio.sleep(POLL_S)
        await self._stop_every_axis("stop")
        raise Unusable(
            f"the table at {self._backend.url} has not found its home within "
            f"{self._described.home_timeout_s:g} s: check whether an axis is blocked",
            message("station-cause.no-home"),
        )

    async def state(self) -> TableState:
        """The table and its axes, of one moment where they can be read in one exchange.

        It renews the hold on the table: the connection may be another than that which held it.
        """
        async with self._backend.alone():
            asked_s = wall_s()
            values = await self._backend.read(self._state_names, "hold" if self._is_held else "")
            now_s = wall_s()
        station_s = float(values.get("time", now_s - self._began_s))
        read_s = float(values.get("time", (asked_s + now_s) / 2 - self._began_s))
        is_sure = not self._exchanges.is_long(now_s - asked_s)
        reported = np.atleast_1d(np.array(values["rate"], float)) if "rate" in values else None
        angles = self._unwrapped.at(values["angle"], read_s, reported, is_sure)
        rates = self._rates(read_s, angles) if reported is None else reported
        angles = self._near_the_target(angles)
        axes = tuple(
            AxisState(
                angle_deg=float(angles[axis]),
                rate_deg_s=float(rates[axis]),
                is_moving=self._is_moving(values, axis, float(rates[axis])),
                is_settled=self._is_settled(values, axis, station_s, angles, rates),
                trips=frozenset(trip for trip in TRIPS if self._is_set(trip, values, axis, True)),
            )
            for axis in range(len(self.names))
        )
        trips = frozenset(trip for trip in TRIPS if self._is_set(trip, values, 0, False))
        return TableState(station_s, now_s, axes, trips, took_s=now_s - asked_s)

    def _rates(self, station_s: float, angles: np.ndarray) -> np.ndarray:
        """The rates by the angles since the last reading, of a table that reports none."""
        before, self._before = self._before, (station_s, angles)
        if before is None or station_s <= before[0]:
            return np.zeros(len(angles))
        return np.asarray((angles - before[1]) / (station_s - before[0]))

    def _near_the_target(self, angles: np.ndarray) -> np.ndarray:
        """The angles (axes,) deg; of axes sent to one within a turn, in the turn of that one.

        Whether half a turn was made forwards or backwards is for the controller to choose.
        """
        turn = self._described.turnover
        if turn is None or not self._described.asks_within_a_turn:
            return angles
        near = [
            each.target + (angle - each.target + turn / 2) % turn - turn / 2
            if each.kind == "angle"
            else angle
            for each, angle in zip(self._settling, angles, strict=True)
        ]
        return np.array(near)

    def _is_set(self, name: str, values: Mapping[str, Any], axis: int, of_axis: bool) -> bool:
        """Whether a flag of the axes, or one of the whole table, is set."""
        flag = self._described.flags.get(name)
        if flag is None or (flag.of in self._backend.per_axis) != of_axis:
            return False
        return flag.is_set(values[flag.of][axis] if of_axis else values[flag.of])

    def _is_moving(self, values: Mapping[str, Any], axis: int, rate: float) -> bool:
        if "moving" not in self._described.flags:
            return abs(rate) > MOVING_DEG_S
        return any(self._is_set("moving", values, axis, of_axis) for of_axis in (True, False))

    def _is_settled(
        self,
        values: Mapping[str, Any],
        axis: int,
        station_s: float,
        angles: np.ndarray,
        rates: np.ndarray,
    ) -> bool:
        if "settled" not in self._described.flags:
            angle, rate = float(angles[axis]), float(rates[axis])
            return self._settling[axis].is_settled(station_s, angle, rate)
        return any(self._is_set("settled", values, axis, of_axis) for of_axis in (True, False))

    async def move_to(self, axis: int, angle: float, rate: float, acceleration: float) -> None:
        """Send an axis to an angle (deg) at a rate (deg/s)."""
        self._settling[axis].send("angle", angle)
        given = {"angle": angle, "rate": rate, "speed": rate, "acceleration": acceleration}
        given["angle_in_turn"] = angle % (self._described.turnover or np.inf)
        await self._backend.command("move_to", given, axis)

    async def turn_at(self, axis: int, rate: float, acceleration: float) -> None:
        """Turn an axis at a rate (deg/s)."""
        self._settling[axis].send("rate", rate)
        given = {"rate": rate, "speed": abs(rate), "acceleration": acceleration}
        given["direction"] = 1.0 if rate >= 0 else -1.0
        await self._backend.command("turn_at", given, axis)

    async def oscillate(self, axis: int, amplitude: float, frequency: float, cycles: int) -> None:
        """Turn an axis to and fro by an amplitude (deg) at a frequency (Hz), so many periods."""
        self._settling[axis].send("off")
        given = {"amplitude": amplitude, "frequency": frequency, "cycles": float(cycles)}
        await self._backend.command("oscillate", given, axis)

    async def stop(self, axis: int) -> None:
        """Ramp an axis to rest."""
        self._settling[axis].send("off")
        await self._backend.command("stop", {}, axis)

    async def quick_stop(self) -> None:
        """Stop every axis on a fresh connection, by the command quick_stop where there is one."""
        self._backend.close()
        if "quick_stop" in self._described.commands:
            with suppress(Unusable):  # an older controller may not know it
                await self._stop_every_axis("quick_stop")
                return
        await self._stop_every_axis("stop")

    async def leave(self) -> None:
        """Stop every axis and let the table go, on a fresh connection."""
        self._is_held = False
        self._backend.close()
        try:
            await self._stop_every_axis("stop")
        finally:
            await self._backend.command("leave", {})

    async def _stop_every_axis(self, command: str) -> None:
        failures = []
        for axis in range(len(self.names)):
            self._settling[axis].send("off")
            try:
                await self._backend.command(command, {}, axis)
            except Unusable as failure:  # the others are to stop all the same
                failures.append(failure)
        if failures:
            raise failures[0]

    async def encoder(self, first: int) -> EncoderBlock:
        """The samples from number `first` on, or from the oldest one kept."""
        return await self._encoders.block(first)
