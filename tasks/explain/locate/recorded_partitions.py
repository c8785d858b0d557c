"""Partitions of a run by time and by what was recorded: temperatures, humidity, supply."""

from collections.abc import Iterator, Sequence

import numpy as np

from schemas.discrepancy import Dimension
from schemas.recording import ACCEL, ANGLE, GYRO, Recording
from tasks.explain.locate.partition import Partition
from tasks.words import Message, Sayable, message

PARTS = 10  # of the range of a signal
UNITS = {"temperature": " °C", "humidity": " %", "supply_voltage": " V", "pressure": " hPa"}


def by_time(t: np.ndarray) -> Partition:
    """By tenths of the run."""
    return _by_value("time", t, message("locate-time"), " s")


def by_records(recording: Recording, t: np.ndarray) -> Iterator[Partition]:
    """By the unit's own temperature and by every other signal that was recorded."""
    imu, room = recording.imu, recording.environment
    for name, signal in imu.columns.items():
        own = np.interp(t, imu.t, signal)
        if name == "temperature":
            yield _by_value("temperature", own, message("locate-unit-temperature"), " °C")
        elif name not in (*GYRO, *ACCEL, *ANGLE):
            yield _by_value("recorded", own, name, "")
    for name, signal in (room.columns if room is not None else {}).items():
        known = np.isfinite(signal)
        if room is not None and known.any():
            own = np.interp(t, room.t[known], signal[known])
            title = message(f"locate-air-{name}") if name in UNITS else name
            yield _by_value("recorded", own, title, UNITS.get(name, ""))


def _by_value(dimension: Dimension, signal: np.ndarray, variable: Sayable, unit: str) -> Partition:
    """By equal parts of a signal's range."""
    known = np.isfinite(signal)
    values = signal[known] if known.any() else np.zeros(1)
    edges = np.linspace(values.min(), values.max(), PARTS + 1)
    cell = np.where(known, np.searchsorted(edges[1:-1], signal), -1)
    cells = tuple(
        message("locate-at-value", value=_formatted(middle, edges) + unit)
        for middle in 0.5 * (edges[1:] + edges[:-1])
    )

    def circumstance(chosen: Sequence[int]) -> Message:
        low, high = (_formatted(edges[k], edges) for k in (chosen[0], chosen[-1] + 1))
        return message("locate-values-between", low=low, high=high + unit)

    return Partition(dimension, cell, True, variable, cells, circumstance, dimension != "time")


def _formatted(value: float, edges: np.ndarray) -> str:
    """A value with as many decimals as resolve hundredths of the range."""
    span = max(float(np.ptp(edges)), 1e-9)
    return f"{value:.{max(0, 2 - int(np.floor(np.log10(span))))}f}"
