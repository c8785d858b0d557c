"""Faults to simulate: each a change to a sound station."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, Literal, Self

import numpy as np

from schemas.base import Unusable

# What a faulty line does to the unit's frames.

Wire = Callable[[np.ndarray, list[bytes]], list[bytes]]  # (numbers (n,), frames) -> frames

GARBAGE_EVERY = 20
DROPPED_FROM, DROPPED_EVERY = 190, 200  # the last ten of each two hundred


def silence(numbers: np.ndarray, sent: list[bytes]) -> list[bytes]:
    return []


def drop(numbers: np.ndarray, sent: list[bytes]) -> list[bytes]:
    keep = numbers % DROPPED_EVERY < DROPPED_FROM
    return [frame for frame, kept in zip(sent, keep, strict=True) if kept]


def _each(every: int, change: Callable[[bytes, int], bytes]) -> Wire:
    """A change of the frames whose number is a multiple of `every`."""

    def transmit(numbers: np.ndarray, sent: list[bytes]) -> list[bytes]:
        return [
            change(frame, number) if number % every == 0 else frame
            for number, frame in zip(numbers.tolist(), sent, strict=True)
        ]

    return transmit


def _random_bytes(frame: bytes, number: int) -> bytes:
    return np.random.default_rng(number).bytes(len(frame))


def _flip(frame: bytes, number: int) -> bytes:
    place, bit = number % len(frame), number // 100 % 8
    return frame[:place] + bytes([frame[place] ^ 1 << bit]) + frame[place + 1 :]


garble = _each(
    GARBAGE_EVERY,
    lambda frame, _: frame[:20] + bytes([frame[20] ^ 0x5A]) + frame[21:] + b"\xaa\x55\x00",
)
repeat = _each(50, lambda frame, _: frame + frame)
merge = _each(40, lambda frame, _: frame[:-3])
cut = _each(60, lambda frame, _: frame[: len(frame) // 2])
flip = _each(100, _flip)
noise = _each(1, _random_bytes)


def swap(numbers: np.ndarray, sent: list[bytes]) -> list[bytes]:
    swapped = list(sent)
    for place in np.flatnonzero(numbers[:-1] % 80 == 0).tolist():
        swapped[place], swapped[place + 1] = swapped[place + 1], swapped[place]
    return swapped


# Faults of a unit: changes to its counts and to its clock.

# (numbers (n,), counts (n, 6)) -> counts; (numbers (n,), stamps (n,) us, first) -> both
Counts = Callable[[np.ndarray, np.ndarray], np.ndarray]
Stamps = Callable[[np.ndarray, np.ndarray, int], tuple[np.ndarray, np.ndarray]]

SPIKE_COUNTS = 100_000
SPIKE_EVERY = 1500  # samples
OUTLIER_COUNTS = 3000
CEILING_COUNTS = 2**19 // 10
SCATTER_COUNTS = 1000
DRIFT_COUNTS = 5  # per sample


def _channel(column: int, change: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Counts:
    """A change of one channel, by the numbers of the samples (n,) and its counts (n,)."""

    def changed(numbers: np.ndarray, counts: np.ndarray) -> np.ndarray:
        made = counts.copy()
        made[:, column] = change(numbers, made[:, column])
        return made

    return changed


def _scatter(numbers: np.ndarray, values: np.ndarray) -> np.ndarray:
    hashed = (numbers.astype(np.int64) * 2_654_435_761) % 2**32 / 2**32 - 0.5
    return values + np.rint(hashed * 2 * SCATTER_COUNTS).astype(values.dtype)


stick = _channel(1, lambda _, values: np.full_like(values, 12345))
stick_accel = _channel(5, lambda _, values: np.full_like(values, 12345))
saturate = _channel(0, lambda _, values: np.clip(values, -CEILING_COUNTS, CEILING_COUNTS))
turn_sign = _channel(0, lambda _, values: -values)
scatter = _channel(2, _scatter)
drift = _channel(0, lambda numbers, values: values + (numbers * DRIFT_COUNTS).astype(values.dtype))


def zero(numbers: np.ndarray, counts: np.ndarray) -> np.ndarray:
    return np.zeros_like(counts)


def spike(numbers: np.ndarray, counts: np.ndarray) -> np.ndarray:
    spiked = counts.copy()
    spiked[numbers % SPIKE_EVERY == SPIKE_EVERY - 1, :] += SPIKE_COUNTS
    return spiked


def outliers(numbers: np.ndarray, counts: np.ndarray) -> np.ndarray:
    off = counts.copy()
    off[numbers % 10 == 0, :3] += OUTLIER_COUNTS
    return off


def swap_axes(numbers: np.ndarray, counts: np.ndarray) -> np.ndarray:
    return counts[:, [1, 0, 2, 3, 4, 5]]


def restart(numbers: np.ndarray, stamps: np.ndarray, first: int) -> tuple[np.ndarray, np.ndarray]:
    since = numbers - first
    period = stamps[0] / max(int(numbers[0]), 1)
    return since, np.rint(since * period).astype(np.uint64)


def _clock(change: Callable[[np.ndarray, np.ndarray, float, int], np.ndarray]) -> Stamps:
    """A change of the stamps, by the numbers, the stamps, the time (us) between two, and first."""

    def changed(
        numbers: np.ndarray, stamps: np.ndarray, first: int
    ) -> tuple[np.ndarray, np.ndarray]:
        period = stamps[0] / max(int(numbers[0]), 1)
        return numbers, change(numbers, stamps, period, first).astype(np.uint64)

    return changed


drift_clock = _clock(
    lambda numbers, stamps, period, first: np.rint(stamps + 0.01 * period * (numbers - first))
)
jump_clock = _clock(lambda _, stamps, __, ___: stamps + np.uint64(1_000_000))
stop_clock = _clock(lambda _, stamps, period, first: np.full(len(stamps), round(first * period)))


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
        """Makes the angles (…, axes) those that are shown; held: (axes,) rad, where they froze."""
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
    stamps: tuple[Stamps, ...] = ()
    counts: tuple[Counts, ...] = ()
    wire: tuple[Wire, ...] = ()


Change = Callable[[Condition], Condition]


def _trips(bit: str) -> Change:
    return lambda now: replace(now, trips=now.trips | {bit})


def _set(**changes: Any) -> Change:
    return lambda now: replace(now, **changes)


def _counts(change: Counts) -> Change:
    return lambda now: replace(now, counts=(*now.counts, change))


def _stamps(change: Stamps) -> Change:
    return lambda now: replace(now, stamps=(*now.stamps, change))


def _wire(change: Wire) -> Change:
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
    "unit_silent": (_wire(silence), "the unit sends nothing more"),
    "unit_garbage": (_wire(garble), "each 20th frame has a wrong byte and noise behind it"),
    "unit_drops": (_wire(drop), "the last ten of each 200 frames are lost"),
    "unit_late": (_set(held_frames=100), "frames come in bouts of a hundred"),
    "unit_repeats": (_wire(repeat), "each 50th frame is sent twice"),
    "unit_merges": (_wire(merge), "each 40th frame runs into the next: its end is lost"),
    "unit_cuts": (_wire(cut), "each 60th frame is cut in half"),
    "unit_swaps": (_wire(swap), "two neighbouring frames of each 80 change places"),
    "unit_bit_flips": (_wire(flip), "a bit of each 100th frame is wrong"),
    "unit_noise_line": (_wire(noise), "random bytes come in the place of frames"),
    "unit_cut": (_set(cuts_unit=True), "the unit's connection ends, and can be made again"),
    "stuck_channel": (_counts(stick), "gyro y stands at one value"),
    "stuck_accel": (_counts(stick_accel), "accelerometer z stands at one value"),
    "zero_readings": (_counts(zero), "every channel reads 0"),
    "saturated_axis": (_counts(saturate), "gyro x reads no more than a tenth of its range"),
    "spike": (_counts(spike), "each 1500th sample is far off"),
    "outliers": (_counts(outliers), "a tenth of the samples is off"),
    "wrong_sign": (_counts(turn_sign), "gyro x has the wrong sign"),
    "swapped_axes": (_counts(swap_axes), "gyro x and y change places"),
    "noisy_channel": (_counts(scatter), "gyro z scatters by a degree per second"),
    "bias_drifts": (_counts(drift), "the bias of gyro x runs away"),
    "unit_restarts": (_stamps(restart), "the unit starts anew: clock and counter at 0"),
    "unit_clock_drifts": (_stamps(drift_clock), "the unit's clock runs 1 % fast"),
    "unit_clock_jumps": (_stamps(jump_clock), "the unit's clock jumps ahead by 1 s"),
    "unit_clock_stands": (_stamps(stop_clock), "the unit's clock stands"),
}


@dataclass(frozen=True)
class StationFault:
    """A fault of FAULTS and the station time (s) from which it holds."""

    name: str
    at_seconds: float = 0.0

    @classmethod
    def parse(cls, text: str) -> Self:
        """Reads "NAME" or "NAME@SECONDS".

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
