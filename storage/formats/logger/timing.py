"""The times of a log's rows, and the protocol that lies on them."""

import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from storage.formats.logger import protocol, units
from storage.formats.logger.columns import Column
from storage.formats.logger.protocol import Protocol
from storage.formats.logger.sheet import Sheet
from storage.formats.logger.units import Times, plain
from storage.formats.manifest import MAX_TIME_S

if TYPE_CHECKING:
    import pandas as pd


RATE_IN_TEXT = re.compile(
    r"(?:sampl\w*|update|output|data)[ _]*rate\D{0,20}?(\d+\.?\d*)\s*hz|\bodr\D{0,10}(\d+\.?\d*)",
    re.IGNORECASE,
)
BY_INTERVAL = "by the interval of the rows"
LONGER = 1.3  # times as long as the rows: a protocol that lasts that long tells their unit
LATE_START_S = 1000.0  # a clock that begins later is counted from its first row


@dataclass
class Timing:
    """The times of a log's rows: `times` is None where none can be had, and `how` then asks.

    column: that they stand in, if any. origin: what the clock showed at t = 0, s. protocol: its
    lines on that clock. faults: what makes the times unusable.
    """

    times: Times | None
    how: str
    column: Column | None
    origin: float = 0.0
    protocol: Protocol = field(default_factory=Protocol)
    notes: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)

    @property
    def is_good(self) -> bool:
        """Whether times are had, and lines of the protocol lie on them."""
        return self.times is not None and not self.faults and not self.protocol.faults


def timed(
    sheet: Sheet,
    candidates: tuple[Column, ...],
    path: Path | None,
    unit: str | None,
    shift: float,
) -> Timing:
    """The times of the rows by the first column on which the lines of the protocol lie."""
    tried: list[Timing] = []
    for column in candidates or (None,):
        notes, before = list[str](), len(sheet.faults)
        times, how = _times(sheet, column, unit, notes)
        faults, sheet.faults[before:] = sheet.faults[before:], []
        one = Timing(times, how, column, notes=notes, faults=faults)
        if one.times is not None:
            # What the clock showed at t = 0, s: its first row where it does not begin near zero.
            earliest = float(np.nanmin(one.times.seconds))
            one.origin = (
                earliest if one.times.kind != "number" or abs(earliest) > LATE_START_S else 0.0
            )
            if path is not None:
                one.protocol = protocol.read(
                    path, one.times, one.origin, shift, is_timed=not one.faults
                )
                if how == BY_INTERVAL and not faults:
                    one.faults += _ticks(one)
        if one.is_good:
            return one
        tried.append(one)
    return next((one for one in tried if one.times is not None), tried[0])


def _ticks(found: Timing) -> list[str]:
    """A sentence where a unit that nobody stated does not fit what the protocol lasts."""
    assert found.times is not None
    assert found.column is not None
    lines, seconds = found.protocol.segments, found.times.seconds
    lasts, step = float(seconds[-1]) - found.origin, _step(found.times)
    shortest = min((line.t_end - line.t_start for line in lines), default=np.inf)
    until = max((line.t_end for line in lines), default=0.0)
    if until < LONGER * lasts and shortest > step:
        return []
    return [
        f"column {found.column.name}: as {found.times.unit} the rows last {lasts:.4g} s, which the "
        "protocol does not fit: it may count ticks of the unit's own clock; give the rate of the "
        "rows, as --units t=100Hz, or the unit, as --units t=ms"
    ]


def _times(
    sheet: Sheet, column: Column | None, unit: str | None, notes: list[str]
) -> tuple[Times | None, str]:
    """The times of the rows on the log's own clock, and how they were read; or what to ask."""
    count = len(sheet.frame)
    stated = RATE_IN_TEXT.search(sheet.preamble)
    rate = re.fullmatch(r"([\d.]+)\s*hz", (unit or "").lower())
    hertz = float(rate[1]) if rate else 0.0
    if column is None and not hertz and stated:
        hertz = float(stated[1] or stated[2])
    if rate or column is None:
        if not hertz:
            return None, (
                "no column is a time: name it by --columns t=…, or give the rate of the rows, as "
                "--units t=100Hz"
            )
        notes.append(f"time is counted from the rows at {hertz:g} Hz")
        return Times(np.arange(count) / hertz, "number"), ""
    if not sheet.is_numeric(column.place):
        text = sheet.text(column.place)
        if text.str.contains(":").mean() > 0.5:
            day = _day_column(sheet, column)
            return _checked(sheet, column, units.of_text(day + text), notes), "by its form"
    values = sheet.numbers(column.place)
    stated_unit = next((u for u in (column.unit, column.name) if plain(u) in units.TIME), "")
    given = unit or stated_unit
    times = units.of_numbers(values, given, column.name)
    how = "--units" if unit else "header" if given else BY_INTERVAL
    if times is None and stated:
        usual = float(np.median(np.diff(values)))
        factor = 1.0 / (float(stated[1] or stated[2]) * usual)
        times = Times(units.unwrapped(values) * factor, "number", "s")
        how = "by the rate in the preamble"
        notes.append(f"one count of {column.name} is {factor:.4g} s by the rate in the preamble")
    if times is None:
        step = float(np.median(np.diff(values)))
        return None, (
            f"{column.name} counts {step:g} from row to row: in which unit? Give --units t=s, "
            "t=ms, t=us, t=ns, or a rate as t=100Hz"
        )
    if column.unit and unit is None and given and _is_odd(times):
        notes.append(f"stamps are {_step(times):.4g} s apart as {given}")
    return _checked(sheet, column, times, notes), how


def _step(times: Times) -> float:
    """The usual step between stamps that differ, s; 0 where none do."""
    steps = np.diff(times.seconds)
    steps = steps[steps > 0.0]
    return float(np.median(steps)) if len(steps) else 0.0


def _is_odd(times: Times) -> bool:
    """Whether rows come less often or more often than inertial units are read."""
    step = _step(times)
    return not units.RATES[0] <= 1.0 / max(step, 1e-12) <= units.RATES[1]


def _day_column(sheet: Sheet, column: Column) -> "pd.Series | str":
    """The days of a column of dates beside a column of times of day, or nothing."""
    for place, name in enumerate(sheet.names):
        if name.strip().lower() == "date" and place != column.place:
            return sheet.text(place) + " "
    return ""


def _checked(sheet: Sheet, column: Column, times: Times, notes: list[str]) -> Times:
    """Times that rise; what does not is a fault, and rows that share a stamp are spread."""
    seconds = times.seconds
    wrong = np.flatnonzero(~np.isfinite(seconds))
    if len(wrong):
        sheet.faults.append(
            f"column {column.name}: {len(wrong)} rows have no time that can be read (line "
            f"{sheet.lines[wrong[0]]}); correct or remove them"
        )
        return replace(times, seconds=np.arange(len(seconds)) * 0.01)
    if len(seconds) > 1 and np.ptp(seconds) == 0.0:
        sheet.faults.append(
            f"column {column.name}: every row has the same time; give the rate of the rows, as "
            "--units t=100Hz"
        )
        return replace(times, seconds=np.arange(len(seconds)) * 0.01)
    running, moved_at = units.running_on(seconds)
    begun_at = np.searchsorted(sheet.lines, sheet.begun)
    times = replace(times, breaks=units.breaks_of(times, moved_at, begun_at))
    seconds = running
    spread, shared = units.apart(seconds)
    back = np.flatnonzero(np.diff(spread) <= 0)
    if len(back):
        sheet.faults.append(
            f"column {column.name}: the time runs backwards {len(back)} times (line "
            f"{sheet.lines[back[0] + 1]}); sort the rows, or split the file where the clock was set"
        )
    elif shared:
        notes.append(f"{shared} rows share a stamp with another: spread evenly until the next")
    usual = float(np.median(np.diff(spread)))
    if not len(back) and 0.0 < usual < 1.0 / units.FASTEST:
        sheet.faults.append(
            f"column {column.name}: rows are {usual:.2g} s apart as {times.unit}, and no inertial "
            "unit is read so often; give the right one, as --units t=s or t=ms"
        )
    if spread[-1] - spread[0] > MAX_TIME_S:
        sheet.faults.append(
            f"column {column.name} lasts {(spread[-1] - spread[0]) / 86400:.0f} days as "
            f"{times.unit}; give the right one, as --units t=ms or t=us"
        )
    return replace(times, seconds=spread)
