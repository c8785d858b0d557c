"""Faults to simulate: a table of rows, each a change to a station that is sound."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Literal, Self

import numpy as np

from schemas.base import Unusable

Counts = Callable[[np.ndarray, np.ndarray], np.ndarray]
Wire = Callable[[np.ndarray, list[bytes]], list[bytes]]

HUNTING_RAD = np.radians(30.0 / 3600.0)
STUCK_COLUMN = 1  # gyro y
SPIKE_COUNTS = 100_000
SPIKE_EVERY = 1500  # samples
GARBAGE_EVERY = 20
DROPPED_FROM, DROPPED_EVERY = 190, 200  # the last ten of each two hundred


@dataclass(frozen=True)
class Condition:
    """How the station is; the defaults are a sound one."""

    trips: frozenset[str] = frozenset()
    hunting_rad: float = 0.0
    rate_factor: float = 1.0
    modbus: Literal["answers", "silent", "exception"] = "answers"
    air_degc: float | None = None
    fixture_stays: bool = False
    counts: tuple[Counts, ...] = ()
    wire: tuple[Wire, ...] = ()


def _stick(numbers: np.ndarray, counts: np.ndarray) -> np.ndarray:
    stuck = counts.copy()
    stuck[:, STUCK_COLUMN] = 12345
    return stuck


def _spike(numbers: np.ndarray, counts: np.ndarray) -> np.ndarray:
    spiked = counts.copy()
    spiked[numbers % SPIKE_EVERY == SPIKE_EVERY - 1, :] += SPIKE_COUNTS
    return spiked


def _silence(numbers: np.ndarray, sent: list[bytes]) -> list[bytes]:
    return []


def _garble(numbers: np.ndarray, sent: list[bytes]) -> list[bytes]:
    """Every twentieth frame has a wrong byte, and noise on the line behind it."""
    return [
        frame[:20] + bytes([frame[20] ^ 0x5A]) + frame[21:] + b"\xaa\x55\x00"
        if number % GARBAGE_EVERY == 0
        else frame
        for number, frame in zip(numbers.tolist(), sent, strict=True)
    ]


def _drop(numbers: np.ndarray, sent: list[bytes]) -> list[bytes]:
    keep = numbers % DROPPED_EVERY < DROPPED_FROM
    return [frame for frame, kept in zip(sent, keep, strict=True) if kept]


def _trips(bit: str) -> Callable[[Condition], Condition]:
    return lambda now: replace(now, trips=now.trips | {bit})


FAULTS: dict[str, Callable[[Condition], Condition]] = {
    "table_fault": _trips("fault"),
    "emergency_stop": _trips("emergency_stop"),
    "interlock": _trips("interlock"),
    "never_settles": lambda now: replace(now, hunting_rad=HUNTING_RAD),
    "modbus_silent": lambda now: replace(now, modbus="silent"),
    "modbus_exception": lambda now: replace(now, modbus="exception"),
    "unit_silent": lambda now: replace(now, wire=(*now.wire, _silence)),
    "unit_garbage": lambda now: replace(now, wire=(*now.wire, _garble)),
    "unit_drops": lambda now: replace(now, wire=(*now.wire, _drop)),
    "stuck_channel": lambda now: replace(now, counts=(*now.counts, _stick)),
    "spike": lambda now: replace(now, counts=(*now.counts, _spike)),
    "chamber_hot": lambda now: replace(now, air_degc=30.0),
    "fixture_stays": lambda now: replace(now, fixture_stays=True),
    "table_rate_wrong": lambda now: replace(now, rate_factor=1.02),
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
            state = FAULTS[fault.name](state)
    return state
