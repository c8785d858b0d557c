"""A protocol of what was done when, one line for each position or rate, as labelled segments."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path

import numpy as np

from schemas.recording import AXES, UPS, Segment
from storage.formats.logger import units
from storage.formats.logger.sheet import Sheet, read_protocol
from storage.formats.logger.units import DEG, TIME, Times, plain, scale

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


def read(path: Path, log: Times, origin: float, shift: float, *, is_timed: bool = True) -> Protocol:
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
