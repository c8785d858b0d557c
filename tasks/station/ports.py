"""The interfaces a run needs of a station: table, chamber, fixture and unit.

A driver is one class behind one of these; `drivers` holds those that there are.
"""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from schemas.base import Unusable
from schemas.procedure import Refix
from tasks.words import message

# What makes a table refuse to move, by the names that a driver reports, and the way out of it.
TRIPS = {
    "fault": "read the fault at the controller, clear it there and start again",
    "emergency_stop": "make the table safe, release the emergency stop, reset the table and "
    "start again",
    "interlock": "close the guard, reset the table and start again",
    "watchdog": "the table heard nothing for too long and stopped itself, so check the network, "
    "reset the table and start again",
}

Ask = Callable[[Refix], Awaitable[None]]  # has a person turn the unit over


@dataclass(frozen=True)
class AxisState:
    """One axis: angle (deg, past whole turns), rate (deg/s), and what its drive reports."""

    angle_deg: float
    rate_deg_s: float
    is_moving: bool
    is_settled: bool
    trips: frozenset[str] = frozenset()


@dataclass(frozen=True)
class TableState:
    """The table at one moment: station time (s), and wall time (`clock.wall_s`) of the reading.

    took_s: wall time from the question to the answer, in which the moment lies.
    """

    station_s: float
    wall_s: float
    axes: tuple[AxisState, ...]
    trips: frozenset[str] = frozenset()
    took_s: float = 0.0


@dataclass(frozen=True)
class EncoderBlock:
    """Angles (n, axes) in rad, past whole turns: row i is that of sample number `first` + i.

    t: (n,) s, station time of the samples.
    """

    first: int
    angles: np.ndarray
    t: np.ndarray


class Table(Protocol):
    """A turntable, in degrees; its axes are outer first. Raises Unusable where it cannot.

    Encoder samples come about every `period_us`, of every axis at once.
    """

    @property
    def names(self) -> tuple[str, ...]: ...

    @property
    def period_us(self) -> int: ...

    @property
    def block_samples(self) -> int:
        """How many samples one block of `encoder` holds at most."""

    @property
    def time_half_width_s(self) -> float:
        """How far an encoder sample's time may be wrong, s; 0 where the table captures them."""

    async def home(self) -> None:
        """Make it ready to move, its angles known."""

    async def move_to(self, axis: int, angle: float, rate: float, acceleration: float) -> None:
        """Send an axis to an angle (deg) at a rate (deg/s) with an acceleration (deg/s²)."""

    async def turn_at(self, axis: int, rate: float, acceleration: float) -> None:
        """Turn an axis at a rate (deg/s)."""

    async def stop(self, axis: int) -> None:
        """Ramp an axis to rest."""

    async def state(self) -> TableState:
        """The table and its axes, all of one moment."""

    async def encoder(self, first: int) -> EncoderBlock:
        """The encoder samples from number `first` on, or from the oldest one kept."""

    async def leave(self) -> None:
        """Stop every axis and hand the table back, even if the connection had failed."""


Oscillate = Callable[[int, float, float, int], Awaitable[None]]


def oscillating(table: Table) -> Oscillate:
    """How a table turns an axis to and fro: by an amplitude (deg), a frequency (Hz) and a number of
    periods. Raises Unusable for one that cannot.
    """
    found: Oscillate | None = getattr(table, "oscillate", None)
    if found is None:
        raise Unusable("the driver of this table has no method oscillate: leave oscillations out")
    return found


@dataclass(frozen=True)
class Climate:
    """One reading of the chamber at a station time (s): °C, %RH, V and hPa.

    NaN: not measured; for the time: not reported.
    """

    station_s: float
    temperature: float
    humidity: float
    supply_voltage: float
    pressure: float


class Chamber(Protocol):
    """What measures the air around the unit, and its supply; some set the air's temperature."""

    async def climate(self) -> Climate: ...

    async def set_temperature(self, degc: float) -> None:
        """Let the air go to a temperature, and return at once."""


class Fixture(Protocol):
    """What can bring the unit to another attitude on the table."""

    async def turn(self, refix: Refix) -> float | None:
        """Do it; the station time (s) at which the unit was switched on again, where known."""


class Line(Protocol):
    """The bytes that the unit sends."""

    @property
    def broken(self) -> str | None:
        """Why nothing more will come, as a sentence; None while the line is sound."""

    def received(self) -> tuple[bytes, float]:
        """What came since the last call, and the wall time at which the last of it came."""

    def end(self) -> None:
        """Read what is on the line now, and no more."""


def check_trips(state: TableState, names: tuple[str, ...]) -> None:
    """Raises Unusable, naming axis and trip, if a state shows that the table will not move."""
    of_axes = {f"axis {n} of the table": a.trips for n, a in zip(names, state.axes, strict=True)}
    for trip, way_out in TRIPS.items():
        for what, trips in (of_axes | {"the table": state.trips}).items():
            if trip in trips:
                cause = message(f"station-cause.{trip.replace('_', '-')}")
                raise Unusable(f"{what} reports {trip}: {way_out}", cause)
