"""The times of a log's rows, and the protocol that lies on them."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from schemas.recording import AXES, UPS, Segment
from storage.formats.logger import units
from storage.formats.logger.columns import Column
from storage.formats.logger.sheet import Sheet, read_protocol
from storage.formats.logger.units import DEG, TIME, Times, plain, scale
from storage.formats.manifest import MAX_TIME_S

if TYPE_CHECKING:
    import pandas as pd

# A protocol of what was done when, one line for each position or rate, as labelled segments.


NAMES: Mapping[str, tuple[str, ...]] = {
    "start": ("start", "begin", "from", "t_start", "start_time", "time", "t"),
    "end": ("end", "stop", "to", "until", "t_end", "end_time"),
    "duration": ("duration", "length", "dwell", "hold"),
    "up": ("up", "position", "axis_up", "orientation"),
    "turn_deg": ("turn_deg", "turn", "heading_deg", "heading"),
    "axis": ("axis", "rate_axis", "about"),
    "rate_deg_s": ("rate_deg_s", "rate", "speed", "rate_dps"),
    "angle_deg": ("angle_deg", "angle"),
    "name": ("name", "label", "what", "segment"),
}
SIGNED = re.compile(r"[+\-]?[xyz][+\-]?")
DOWN = "down"
LISTED = 3
OUTSIDE_S = 1.0  # s by which a line may begin outside of the recording


@dataclass
class Protocol:
    """Labelled segments on the log's clock, notes on how the protocol was read, and its faults."""

    segments: tuple[Segment, ...] = ()
    notes: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)


def protocol_on(
    path: Path, log: Times, origin: float, shift: float, *, is_timed: bool = True
) -> Protocol:
    """The segments of a protocol, in s since `origin` on the log's clock, `shift` s later.

    log: the times of the log's rows, s on its own clock. is_timed: whether these are right.
    """
    protocol = Protocol()
    sheet = read_protocol(path)
    places = _places(sheet, protocol)
    if "start" not in places:
        protocol.faults.append(f"column start is missing (found {', '.join(sheet.names)})")
        return protocol
    offset, scale = _clock(sheet, places, log, origin, protocol)
    lines = [_Line(sheet, places, k, scale, offset) for k in range(len(sheet.frame))]
    segments: list[Segment] = []
    for k, line in enumerate(lines):
        later = lines[k + 1] if k + 1 < len(lines) else None
        segment = line.segment(shift, later, {s.name for s in segments}, protocol.faults)
        if segment is not None:
            segments.append(segment)
    last = float(np.nanmax(log.seconds)) - origin
    outside = [s.name for s in segments if s.t_end > last + 1e-6 or s.t_start < -1e-6]
    if segments and len(outside) == len(segments) and is_timed:
        protocol.faults.append(
            f"none of its {len(segments)} lines lies within the recording, which lasts {last:.6g} "
            f"s (the first starts at {segments[0].t_start:.6g} s); give --shift"
        )
    elif outside:
        protocol.notes.append(f"{len(outside)} lines reach beyond the recording: {_some(outside)}")
    protocol.segments = tuple(sorted(segments, key=lambda s: s.t_start))
    return protocol


def _places(sheet: Sheet, protocol: Protocol) -> dict[str, int]:
    bare = [re.sub(r"[\[(].*", "", name).strip().lower().replace(" ", "_") for name in sheet.names]
    places: dict[str, int] = {}
    shorter = [re.sub(r"_(s|ms|us|sec|min)$", "", name) for name in bare]
    for wanted, names in NAMES.items():
        for name, written in product(names, (bare, shorter)):
            if name in written and wanted not in places:
                places[wanted] = written.index(name)
    unread = [n for k, n in enumerate(sheet.names) if k not in places.values() and n]
    if unread:
        protocol.notes.append(f"columns of the protocol not read: {', '.join(unread)}")
    return places


def _clock(
    sheet: Sheet, places: Mapping[str, int], log: Times, origin: float, protocol: Protocol
) -> tuple[float, float]:
    """What is taken off the protocol's starts, s, and what they are multiplied by before."""
    starts = _Line.times(sheet, places["start"])
    seconds = starts.seconds[np.isfinite(starts.seconds)]
    first, last = float(np.nanmin(log.seconds)), float(np.nanmax(log.seconds))
    if not len(seconds):
        return 0.0, 1.0
    if starts.kind == "epoch" or (starts.kind == "of day" and log.kind == "epoch"):
        day = 0.0 if starts.kind == "epoch" else np.floor(first / units.DAY_S) * units.DAY_S
        return origin - day, 1.0
    unit = next(
        (u for u in re.findall(r"[_(\[ ](\w+)[)\]]?$", sheet.names[places["start"]]) if u in TIME),
        None,
    )
    unit = sheet.units[places["start"]] or unit
    scales = [TIME[plain(unit)]] if unit and plain(unit) in TIME else [1.0, TIME.get(log.unit, 1.0)]
    tried = [
        (factor, taken) for factor in dict.fromkeys(scales) for taken in (origin, origin - first)
    ]
    within = [
        np.mean(np.abs(factor * seconds - taken + origin - 0.5 * (first + last))
                < 0.5 * (last - first) + OUTSIDE_S)
        for factor, taken in tried
    ]  # fmt: skip
    if not any(within):
        return (0.0 if first > seconds.max() else origin), scales[0]
    factor, taken = tried[int(np.argmax(within))]
    if taken != origin:
        protocol.notes.append("its times are counted from the first row of the log")
    if factor != 1.0:
        protocol.notes.append(f"its times are read as {unit or log.unit}")
    return taken, factor


@dataclass
class _Line:
    """One line of the protocol."""

    sheet: Sheet
    places: Mapping[str, int]
    row: int
    scale: float
    offset: float

    @staticmethod
    def times(sheet: Sheet, place: int) -> Times:
        """Numbers as they are; other times by the clock that they are of."""
        import pandas as pd

        text = sheet.text(place)
        numbers = pd.to_numeric(text.str.replace(",", "."), errors="coerce").to_numpy(float)
        if np.isfinite(numbers).any():
            return Times(numbers, "number")
        return units.of_text(text)

    def degrees(self, name: str, faults: list[str]) -> float | None:
        """A rate or an angle in deg/s or deg, whatever unit stands in its header."""
        value = self.number(name, faults)
        if value is None:
            return None
        inside = re.search(r"[\[(]([^\])]+)", self.sheet.names[self.places[name]])
        quantity = "rate" if name == "rate_deg_s" else "angle"
        unit = scale(quantity, inside[1], 1.0) if inside else None
        return value if unit is None else value * unit.factor / DEG

    def text(self, name: str) -> str:
        value = "" if name not in self.places else self.sheet.text(self.places[name])[self.row]
        return "" if value.lower() in ("nan", "none", "-", "–") else value

    def number(self, name: str, faults: list[str]) -> float | None:
        text = self.text(name).replace(",", ".").replace("−", "-").rstrip("°").removesuffix("°/s")
        try:
            return float(text) if text else None
        except ValueError:
            faults.append(f"line {self.where}: {name} is {text!r}, no number")
            return None

    @property
    def where(self) -> int:
        return int(self.sheet.lines[self.row])

    def time(self, name: str) -> float | None:
        if name not in self.places or not self.text(name):
            return None
        value = float(self.times(self.sheet, self.places[name]).seconds[self.row])
        return value * self.scale if np.isfinite(value) else None

    def segment(
        self, shift: float, later: "_Line | None", taken: set[str], faults: list[str]
    ) -> Segment | None:
        """The labelled segment; what is wrong with the line is added to the faults."""
        start, end, lasts = self.time("start"), self.time("end"), self.time("duration")
        if start is None:
            if any(self.text(name) for name in self.places):
                faults.append(f"line {self.where}: start is {self.text('start')!r}, no time")
            return None
        if end is None and lasts is None:
            faults.append(f"line {self.where}: {self._no_end()}")
            return None
        lasts = end - start if lasts is None and end is not None else lasts or 0.0
        if end is not None and abs(start + lasts - end) > OUTSIDE_S:
            faults.append(
                f"line {self.where}: end and duration contradict each other; leave one of them out"
            )
            return None
        end = start + lasts if end is None else end
        if not end > start:
            faults.append(f"line {self.where}: it starts at {start:g} s and ends at {end:g} s")
            return None
        begun = len(faults)
        up = self._signed("up", faults)
        axis = (self.text("axis").lower().strip("+- ") or None) if self.text("axis") else None
        if axis is not None and axis not in AXES:
            faults.append(f"line {self.where}: axis is {axis!r}; write x, y or z")
        rate, angle = self.degrees("rate_deg_s", faults), self.degrees("angle_deg", faults)
        if (rate or angle) and axis is None:
            faults.append(f"line {self.where}: a rate or an angle needs the axis that it is about")
        if rate and angle:
            faults.append(f"line {self.where}: a rate is held or an angle turned; leave one out")
        if len(faults) > begun:
            return None
        kind = "rate" if rate else "rotation" if angle else "static"
        turn = self.number("turn_deg", faults)
        named = {
            "rate": f"rate_{axis}_{rate or 0.0:+g}",
            "rotation": f"turn_{axis}_{angle or 0:+g}",
        }
        name = self.text("name") or named.get(
            kind, f"position_{up or 'aslant'}" + ("" if turn is None else f"_{turn:03g}")
        )
        unique = next(
            n for n in (name, *(f"{name}_{k}" for k in range(2, 10_000))) if n not in taken
        )
        return Segment.model_validate({
            "name": unique, "kind": kind, "up": up, "turn_deg": turn if kind == "static" else None,
            "axis": axis if kind != "static" else None, "rate_deg_s": rate or None,
            "angle_deg": angle if kind == "rotation" else None,
            "t_start": start - self.offset + shift, "t_end": end - self.offset + shift,
        })  # fmt: skip

    def _no_end(self) -> str:
        given = [(name, self.text(name)) for name in ("end", "duration") if self.text(name)]
        texts = [f"{name} is {text!r}, no time" for name, text in given]
        return " and ".join(texts) or "neither end nor duration"

    def _signed(self, name: str, faults: list[str]) -> str | None:
        """An axis with its sign: +x, x+, X up, -z, z down."""
        text = self.text(name).lower().replace("−", "-").replace(" ", "")
        if not text:
            return None
        falls = DOWN in text
        bare = re.sub(r"up|down|axis", "", text)
        if not SIGNED.fullmatch(bare):
            faults.append(f"line {self.where}: {name} is {text!r}; write +x, -x, +y, -y, +z or -z")
            return None
        sign = "-" if ("-" in bare) != falls else "+"
        up = sign + bare.strip("+-")
        assert up in UPS
        return up


def _some(names: list[str]) -> str:
    more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    return ", ".join(names[:LISTED]) + more


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
                one.protocol = protocol_on(
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
