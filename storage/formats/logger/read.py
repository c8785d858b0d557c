"""A logger's table and its protocol as a recording, with what was understood of them.

Whatever is wrong with the file is said at once. What is not written anywhere is asked for, unless
the numbers leave no doubt: gravity tells the unit of the accelerometers, the rates of the protocol
that of the gyros, the interval of the rows that of the time.
"""

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from schemas.base import Unusable
from schemas.recording import (
    ACCEL,
    ANGLE,
    AXES,
    FORMAT,
    GYRO,
    Manifest,
    Recording,
    Segment,
    Station,
    Stream,
    Unit,
)  # fmt: skip
from storage.formats.checks import MAX_TIME_S, check_stream, first
from storage.formats.convert import STANDARD_GRAVITY, Changes
from storage.formats.logger import clocks, protocol
from storage.formats.logger.clocks import Times
from storage.formats.logger.columns import Column, find_columns
from storage.formats.logger.sheet import Sheet, read_sheet
from storage.formats.logger.units import DEG, EXAMPLES, QUANTITIES, Scale, plain, scale
from storage.formats.manifest import check_controls

if TYPE_CHECKING:
    import pandas as pd

KINDS = (".csv", ".tsv", ".txt", ".log", ".dat", ".lvm", ".xlsx", ".xlsm", ".parquet", ".pq")
RATE_IN_TEXT = re.compile(
    r"(?:sampl\w*|update|output|data)[ _]*rate\D{0,20}?(\d+\.?\d*)\s*hz|\bodr\D{0,10}(\d+\.?\d*)",
    re.IGNORECASE,
)
OF_FORCE = (  # usual sizes of gravity in a unit, and the unit
    (1.0, "g"), (STANDARD_GRAVITY, "m/s2"), (1000.0, "mg"), (16384.0, "16384/g"),
    (8192.0, "8192/g"), (4096.0, "4096/g"), (2048.0, "2048/g"),
)  # fmt: skip
OF_RATE = ("deg/s", "rad/s", "mdps", "131/dps", "65.5/dps", "32.8/dps", "16.4/dps")
NEAR = 0.12  # of a usual size
LATE_START_S = 1000.0  # a clock that begins later is counted from its first row


_Try = tuple[Times | None, str, protocol.Protocol, Column | None, list[str], list[str]]


@dataclass(frozen=True)
class Row:
    """How one channel was read: its column, its unit, and how the unit is known."""

    channel: str
    column: str
    unit: str
    how: str


@dataclass(frozen=True)
class Understood:
    """A recording made of a logger's table, and what was understood of it.

    rows: of each channel. notes: what was taken for granted or left out. gravity: m/s² of one g
    and of the place. mapping: what --like repeats.
    """

    recording: Recording
    rows: tuple[Row, ...]
    notes: tuple[str, ...]
    gravity: float
    mapping: Mapping[str, object]


def is_log(path: Path) -> bool:
    """Whether a path is a table of a logger by its name."""
    return path.suffix.lower() in KINDS and not path.is_dir()


def read_log(
    path: Path,
    protocol_path: Path | None,
    columns: Mapping[str, str],
    changes: Changes,
    *,
    station: Station | None = None,
    unit: Unit | None = None,
) -> Understood:
    """Reads a logger's table; raises Unusable with all that is wrong or unclear in one sentence.

    station, unit: of an earlier run that this one is like.
    """
    sheet = read_sheet(path)
    found = find_columns(sheet, columns)
    if found.question:
        raise _unusable(sheet, [found.question])
    place = station or Station(id="unknown")
    gravity = changes.gravity or place.gravity_m_s2 or STANDARD_GRAVITY
    notes, rows = list[str](), list[Row]()
    times, how, labels, clock = _timed(sheet, found.times, protocol_path, changes, notes)
    if clock is not None:
        rows.append(Row("t", clock.name, times.unit, how))
        found = replace(found, columns={**found.columns, "t": clock})
    origin = _origin(times)
    raw = {c: sheet.numbers(one.place) for c, one in found.columns.items() if c != "t"}
    if protocol_path is not None:
        sheet.faults += [f"{protocol_path.name}: {fault}" for fault in labels.faults]
        notes += [f"{protocol_path.name}: {note}" for note in labels.notes]
    t = times.seconds - origin
    scales = dict[str, Scale]()
    for triad, name in ((GYRO, "gyro"), (ACCEL, "accel"), (ANGLE, "angle"), (("temperature",), "")):
        own = {c: found.columns[c] for c in triad if c in raw}
        if not own:
            continue
        one, said = _scale(
            name or "temperature", own, changes.units, gravity,
            {c: raw[c] for c in own}, t, labels.segments,
        )  # fmt: skip
        if one is None:
            sheet.faults.append(said)
            continue
        scales |= dict.fromkeys(own, one)
        rows += [Row(c, column.name, one.text, said) for c, column in own.items()]
    if "temperature" in raw and not np.isfinite(raw["temperature"]).all():
        notes.append("temperature is empty in some rows: left out")
        del raw["temperature"]
    if sheet.faults:
        raise _unusable(sheet)
    values = {c: v * scales[c].factor + scales[c].offset for c, v in raw.items()}
    if changes.axes is not None:
        values = changes.axes.applied(values)
    stream = _stream(sheet, t, values)
    mapping = {
        "columns": {c: one.name for c, one in found.columns.items()},
        "units": {n: scales[c].text for n, c in _one_of_each(scales).items()}
        | ({"t": times.unit} if plain(times.unit) in clocks.TIME else {}),
        **({"axes": changes.axes.text} if changes.axes else {}),
    }
    source = hashlib.sha256(path.read_bytes()).hexdigest()
    manifest = Manifest.model_validate({
        "format": FORMAT, "recording_id": path.stem,
        "unit": (unit or Unit(manufacturer="-", model="-", serial="-")).model_dump(),
        "station": {**place.model_dump(), "gravity_m_s2": gravity},
        "segments": [s.model_dump(exclude_none=True) for s in labels.segments] or None,
        "imported": {"source": path.name, "source_sha256": source, **changes.said(), **mapping},
        **({"acquired_at": _moment(origin)} if times.kind == "epoch" else {}),
    })  # fmt: skip
    check_controls(manifest.model_dump(mode="json"), str(path))
    recording = Recording(manifest, stream)
    return Understood(recording, tuple(rows), (*sheet.notes, *notes), gravity, mapping)


def _timed(
    sheet: Sheet, candidates: tuple[Column, ...], path: Path | None, changes: Changes,
    notes: list[str],
) -> tuple[Times, str, protocol.Protocol, Column | None]:  # fmt: skip
    """The times of the rows, how they are known, the protocol's lines on them, and their column.

    Of several columns of times the first on which lines of the protocol lie. Raises Unusable where
    no time can be had.
    """
    tries = list[_Try]()
    for column in candidates or (None,):
        noted: list[str] = []
        before = len(sheet.faults)
        times, how = _times(sheet, column, changes.units.get("t"), noted)
        own, sheet.faults[before:] = sheet.faults[before:], []
        if times is None:
            tries.append((None, how, protocol.Protocol(), column, noted, own))
            continue
        read = protocol.Protocol()
        if path is not None:
            read = protocol.read(path, times, _origin(times), changes.shift, is_timed=not own)
        tries.append((times, how, read, column, noted, own))
        if not own and not read.faults:
            break
    else:
        tries.sort(key=lambda one: (one[0] is None, len(one[5])))
    times, how, read, column, noted, own = tries[-1] if not _is_bad(tries[-1]) else tries[0]
    if times is None:
        raise _unusable(sheet, [how])
    notes += noted
    sheet.faults += own
    return times, how, read, column


def _is_bad(one: _Try) -> bool:
    return one[0] is None or bool(one[5]) or bool(one[2].faults)


def _unusable(sheet: Sheet, more: list[str] | None = None) -> Unusable:
    faults = [*dict.fromkeys(sheet.faults), *(more or [])]
    return Unusable(f"{sheet.path}: {'; '.join(faults)}.")


def _one_of_each(scales: Mapping[str, Scale]) -> dict[str, str]:
    return {channel.split("_")[0]: channel for channel in scales}


def _moment(origin: float) -> str:
    return str(np.datetime64(round(origin * 1e3), "ms")) + "Z"


def _origin(times: Times) -> float:
    """What the clock showed at t = 0, s: its first row where it does not begin near zero."""
    earliest = float(np.nanmin(times.seconds))
    return earliest if times.kind != "number" or abs(earliest) > LATE_START_S else 0.0


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
            return _checked(sheet, column, clocks.of_text(day + text), notes), "by its form"
    values = sheet.numbers(column.place)
    given = unit or (column.unit if plain(column.unit) in clocks.TIME else "")
    times = clocks.of_numbers(values, given, column.name)
    how = "--units" if unit else "header" if given else "by the interval of the rows"
    if times is None and stated:
        usual = float(np.median(np.diff(values)))
        factor = 1.0 / (float(stated[1] or stated[2]) * usual)
        times = Times(clocks.unwrapped(values) * factor, "number", "s")
        how = "by the rate in the preamble"
        notes.append(f"one count of {column.name} is {factor:.4g} s by the rate in the preamble")
    if times is None:
        step = float(np.median(np.diff(values)))
        return None, (
            f"{column.name} counts {step:g} from row to row: in which unit? Give --units t=s, "
            "t=ms, t=us, t=ns, or a rate as t=100Hz"
        )
    if column.unit and unit is None and given and quantity_is_odd(times):
        notes.append(f"rows are {np.nanmedian(np.diff(times.seconds)):.4g} s apart as {given}")
    return _checked(sheet, column, times, notes), how


def quantity_is_odd(times: Times) -> bool:
    """Whether rows come less often or more often than inertial units are read."""
    step = float(np.nanmedian(np.diff(times.seconds)))
    return not clocks.RATES[0] <= 1.0 / max(step, 1e-12) <= clocks.RATES[1]


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
    spread, shared = clocks.apart(seconds)
    back = np.flatnonzero(np.diff(spread) <= 0)
    if len(back):
        sheet.faults.append(
            f"column {column.name}: the time runs backwards {len(back)} times (line "
            f"{sheet.lines[back[0] + 1]}); sort the rows, or split the file where the clock was set"
        )
    elif shared:
        notes.append(f"{shared} rows share a stamp with another: spread evenly until the next")
    if spread[-1] - spread[0] > MAX_TIME_S:
        sheet.faults.append(
            f"column {column.name} lasts {(spread[-1] - spread[0]) / 86400:.0f} days as "
            f"{times.unit}; give the right one, as --units t=ms or t=us"
        )
    return replace(times, seconds=spread)


def _scale(
    name: str, own: Mapping[str, Column], given: Mapping[str, str], gravity: float,
    raw: Mapping[str, np.ndarray], t: np.ndarray, labels: tuple[Segment, ...],
) -> tuple[Scale | None, str]:  # fmt: skip
    """The unit of a triad and how it is known; or None and what to ask."""
    quantity = QUANTITIES[name]
    written = next(iter(own.values())).unit
    for text, how in ((given.get(name), "--units"), (written, "header")):
        if text and (one := scale(quantity, text, gravity)) is not None:
            return one, how
        if text and how == "--units":
            return None, f"--units {name}={text}: no such unit; it may be {EXAMPLES[quantity]}"
    if name == "temperature":
        return Scale("degC", 1.0), "taken for °C"
    values = np.array(list(raw.values()))
    if name == "accel":
        size = float(np.nanmedian(np.linalg.norm(values, axis=0)))
        for usual, text in OF_FORCE:
            if abs(size / usual - 1.0) < NEAR:
                return scale(quantity, text, gravity), f"gravity reads {size:.5g}"
    if name == "gyro" and (text := _unit_by_rates(raw, t, labels)):
        return scale(quantity, text, gravity), "by the rates of the protocol"
    stated = f" (its header says {written!r})" if written else ""
    return None, (
        f"{name}: in which unit are {', '.join(c.name for c in own.values())}?{stated} Give "
        f"--units {name}=…: {EXAMPLES[quantity]}"
    )


def _unit_by_rates(
    raw: Mapping[str, np.ndarray], t: np.ndarray, labels: tuple[Segment, ...]
) -> str | None:
    """The usual unit in which the gyros read the rates that the protocol says."""
    ratios = []
    for label in labels:
        rows = slice(*np.searchsorted(t, (label.t_start, label.t_end)))
        if label.kind != "rate" or not label.rate_deg_s or rows.stop - rows.start < 3:
            continue
        if all(channel in raw for channel in GYRO):
            means = [abs(float(np.nanmedian(raw[f"gyro_{axis}"][rows]))) for axis in AXES]
            ratios.append(abs(label.rate_deg_s) / max(*means, 1e-12))
    if not ratios:
        return None
    usual = float(np.median(ratios)) * DEG
    fits = [(abs(np.log(usual / one.factor)), text) for text in OF_RATE
            if (one := scale("rate", text, 1.0)) is not None]  # fmt: skip
    nearest = min(fits)
    return nearest[1] if nearest[0] < NEAR else None


def _stream(sheet: Sheet, t: np.ndarray, values: Mapping[str, np.ndarray]) -> Stream:
    """The unit's stream; a triad that was not recorded is null, as the format has it."""
    made = dict(values)
    for triad in (GYRO, ACCEL):
        if ANGLE[0] not in made or set(triad) & set(made):
            made |= {c: np.full(len(t), np.nan) for c in triad if c not in made}
    stream = Stream(np.rint(t * 1e9) / 1e9, made)
    if (row := first(np.diff(stream.t) <= 0)) is not None:
        raise _unusable(sheet, [f"line {sheet.lines[row + 1]} is less than a nanosecond after the "
                                "one before"])  # fmt: skip
    check_stream(str(sheet.path), "imu", stream)
    return stream
