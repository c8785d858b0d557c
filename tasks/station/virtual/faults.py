"""Faults to simulate: each a change to a sound station."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, Literal, Self

import numpy as np

from schemas.base import Unusable
from tasks.station.virtual import line_faults as line
from tasks.station.virtual import unit_faults as unit

HUNTING_RAD = np.radians(30.0 / 3600.0)
SHAKING_RAD = np.radians(0.05)


@dataclass(frozen=True)
class EncoderErrors:
    """How a table's encoders err."""

    factor: float = 1.0
    offset_rad: float = 0.0
    noise_rad: float = 0.0
    is_frozen: bool = False

    def holding(self, held: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
        """From the angles (…, axes) to those shown; held: (axes,) rad, where they froze."""
        rng = np.random.default_rng(1)

        def shown(angles: np.ndarray) -> np.ndarray:
            if self.is_frozen:
                return np.broadcast_to(held, np.shape(angles))
            scattered = self.noise_rad * rng.standard_normal(np.shape(angles))
            return np.asarray(angles * self.factor + self.offset_rad + scattered)

        return shown


SOUND = EncoderErrors()


@dataclass(frozen=True)
class Condition:
    """How the station is; the defaults are a sound one."""

    trips: frozenset[str] = frozenset()
    hunting_rad: float = 0.0
    rate_factor: float = 1.0
    claims_settled: bool = False
    encoder: EncoderErrors = SOUND
    capture_skips: int = 0
    captures_nothing: bool = False
    modbus: Literal["answers", "silent", "exception", "address", "busy", "zeros", "ones"] = (
        "answers"
    )
    modbus_delay_s: float = 0.0
    cuts_modbus_every: int = 0  # requests
    air_degc: float | None = None
    humidity_percent: float | None = None
    supply_v: float | None = None
    is_chamber_silent: bool = False
    is_chamber_frozen: bool = False
    fixture_stays: bool = False
    is_supply_cut: bool = False
    busy_s: float = 0.0  # wall time
    is_dead: bool = False
    cuts_unit: bool = False
    held_frames: int = 0  # until there are so many
    stamps: tuple[unit.Stamps, ...] = ()
    counts: tuple[unit.Counts, ...] = ()
    wire: tuple[line.Wire, ...] = ()


Change = Callable[[Condition], Condition]


def _trips(bit: str) -> Change:
    return lambda now: replace(now, trips=now.trips | {bit})


def _set(**changes: Any) -> Change:
    return lambda now: replace(now, **changes)


def _counts(change: unit.Counts) -> Change:
    return lambda now: replace(now, counts=(*now.counts, change))


def _stamps(change: unit.Stamps) -> Change:
    return lambda now: replace(now, stamps=(*now.stamps, change))


def _wire(change: line.Wire) -> Change:
    return lambda now: replace(now, wire=(*now.wire, change))


# name: what is changed, and what it is in the world
FAULTS: dict[str, tuple[Change, str]] = {
    "table_fault": (_trips("fault"), "a drive reports a fault"),
    "emergency_stop": (_trips("emergency_stop"), "somebody presses the emergency stop"),
    "interlock": (_trips("interlock"), "somebody opens the guard"),
    "never_settles": (_set(hunting_rad=HUNTING_RAD), "every axis hunts by 30″ at 3 Hz"),
    "table_shakes": (_set(hunting_rad=SHAKING_RAD), "every axis shakes by 0.05° at 3 Hz"),
    "table_rate_wrong": (_set(rate_factor=1.02), "rates are 2 % too large, and said to be right"),
    "table_slow": (_set(rate_factor=0.5), "rates are half of what was asked for"),
    "table_stalls": (_set(rate_factor=0.0), "the drives take commands and do not move"),
    "settled_too_soon": (_set(claims_settled=True), "axes are reported as settled while they move"),
    "encoder_frozen": (
        _set(encoder=EncoderErrors(is_frozen=True)),
        "the encoders stand while the table moves",
    ),
    "encoder_jumps": (_set(encoder=EncoderErrors(offset_rad=1.0)), "the encoders jump by 1 rad"),
    "encoder_scale": (_set(encoder=EncoderErrors(factor=1.01)), "the encoders count 1 % too much"),
    "encoder_noise": (
        _set(encoder=EncoderErrors(noise_rad=1e-3)),
        "the encoders scatter by 1 mrad",
    ),
    "capture_skips": (_set(capture_skips=5), "each block of captured encoders lacks five samples"),
    "capture_empty": (_set(captures_nothing=True), "no more encoder samples are captured"),
    "modbus_silent": (_set(modbus="silent"), "the controller accepts requests and never answers"),
    "modbus_exception": (_set(modbus="exception"), "every request is refused: device failure"),
    "modbus_address": (_set(modbus="address"), "every request is refused: illegal address"),
    "modbus_busy": (_set(modbus="busy"), "every request is refused: device busy"),
    "modbus_zeros": (_set(modbus="zeros"), "every register reads 0"),
    "modbus_ones": (_set(modbus="ones"), "every register reads 65535"),
    "modbus_slow": (_set(modbus_delay_s=0.2), "every answer takes 0.2 s"),
    "modbus_very_slow": (_set(modbus_delay_s=2.0), "every answer takes 2 s"),
    "modbus_cut": (_set(cuts_modbus_every=200), "each 200th request ends its connection"),
    "modbus_cut_often": (_set(cuts_modbus_every=7), "each seventh request ends its connection"),
    "chamber_hot": (_set(air_degc=30.0), "the air is at 30 °C"),
    "chamber_cold": (_set(air_degc=5.0), "the air is at 5 °C"),
    "chamber_humid": (_set(humidity_percent=95.0), "the air is at 95 %RH"),
    "chamber_silent": (_set(is_chamber_silent=True), "the chamber does not answer"),
    "chamber_frozen": (_set(is_chamber_frozen=True), "the chamber's readings stay as they were"),
    "supply_low": (_set(supply_v=4.0), "the unit's supply is at 4 V"),
    "supply_cut": (_set(is_supply_cut=True), "the unit's supply goes, and comes not back"),
    "fixture_stays": (_set(fixture_stays=True), "the fixture does not turn"),
    "busy_computer": (_set(busy_s=0.2), "the station's computer is busy for every other 0.2 s"),
    "power_cut": (_set(is_dead=True), "the station is gone: its process ends"),
    "unit_silent": (_wire(line.silence), "the unit sends nothing more"),
    "unit_garbage": (_wire(line.garble), "each 20th frame has a wrong byte and noise behind it"),
    "unit_drops": (_wire(line.drop), "the last ten of each 200 frames are lost"),
    "unit_late": (_set(held_frames=100), "frames come in bouts of a hundred"),
    "unit_repeats": (_wire(line.repeat), "each 50th frame is sent twice"),
    "unit_merges": (_wire(line.merge), "each 40th frame runs into the next: its end is lost"),
    "unit_cuts": (_wire(line.cut), "each 60th frame is cut in half"),
    "unit_swaps": (_wire(line.swap), "two neighbouring frames of each 80 change places"),
    "unit_bit_flips": (_wire(line.flip), "a bit of each 100th frame is wrong"),
    "unit_noise_line": (_wire(line.noise), "random bytes come in the place of frames"),
    "unit_cut": (_set(cuts_unit=True), "the unit's connection ends, and can be made again"),
    "stuck_channel": (_counts(unit.stick), "gyro y stands at one value"),
    "stuck_accel": (_counts(unit.stick_accel), "accelerometer z stands at one value"),
    "zero_readings": (_counts(unit.zero), "every channel reads 0"),
    "saturated_axis": (_counts(unit.saturate), "gyro x reads no more than a tenth of its range"),
    "spike": (_counts(unit.spike), "each 1500th sample is far off"),
    "outliers": (_counts(unit.outliers), "a tenth of the samples is off"),
    "wrong_sign": (_counts(unit.turn_sign), "gyro x has the wrong sign"),
    "swapped_axes": (_counts(unit.swap_axes), "gyro x and y change places"),
    "noisy_channel": (_counts(unit.scatter), "gyro z scatters by a degree per second"),
    "bias_drifts": (_counts(unit.drift), "the bias of gyro x runs away"),
    "unit_restarts": (_stamps(unit.restart), "the unit starts anew: clock and counter at 0"),
    "unit_clock_drifts": (_stamps(unit.drift_clock), "the unit's clock runs 1 % fast"),
    "unit_clock_jumps": (_stamps(unit.jump_clock), "the unit's clock jumps ahead by 1 s"),
    "unit_clock_stands": (_stamps(unit.stop_clock), "the unit's clock stands"),
}


@dataclass(frozen=True)
class StationFault:
    """A fault of FAULTS and the station time (s) from which it holds."""

    name: str
    at_seconds: float = 0.0

    @classmethod
    def parse(cls, text: str) -> Self:
        """From "NAME" or "NAME@SECONDS".

        Raises Unusable where the name is not in FAULTS or the seconds are no time.
        """
        name, at, seconds = text.partition("@")
        if name not in FAULTS:
            raise Unusable(f"there is no fault {name!r}: choose one of {', '.join(FAULTS)}")
        if not at:
            return cls(name)
        try:
            at_seconds = float(seconds)
        except ValueError:
            at_seconds = float("nan")
        if not 0.0 <= at_seconds < float("inf"):
            raise Unusable(
                f"the fault {text!r} begins at {seconds!r}: give station seconds, as in {name}@60"
            )
        return cls(name, at_seconds)

    def __str__(self) -> str:
        return f"{self.name}@{self.at_seconds!r}"


def condition(faults: Iterable[StationFault], now: float) -> Condition:
    """The station's condition at a station time (s)."""
    state = Condition()
    for fault in faults:
        if fault.at_seconds <= now:
            change, _ = FAULTS[fault.name]
            state = change(state)
    return state
