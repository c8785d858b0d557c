"""A logger's table and its protocol as a recording, with what was understood of them.

Whatever is wrong with the file is said at once. What is not written anywhere is asked for, unless
the numbers leave no doubt: gravity tells the unit of the accelerometers, the rates of the protocol
that of the gyros, the interval of the rows that of the time.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydantic import TypeAdapter

from schemas.base import Unusable
from schemas.recording import (
    ACCEL,
    ANGLE,
    FORMAT,
    GYRO,
    SEEN,
    SI_PER_UNIT,
    Manifest,
    Recording,
    Station,
    Stream,
    Unit,
)
from schemas.text import Seen
from storage.formats.convert import STANDARD_GRAVITY, Changes
from storage.formats.logger import units
from storage.formats.logger.columns import (
    Column,
    find_columns,
    scale_of,
    several_sensors,
    without_marks,
)
from storage.formats.logger.sheet import Sheet, read_sheet
from storage.formats.logger.tables import readers
from storage.formats.logger.timing import timed
from storage.formats.logger.units import Scale, is_in_g, plain
from storage.formats.manifest import check_controls, check_stream, first

STANDARD_G = (
    f"g is the standard {STANDARD_GRAVITY} m/s², for the local one was not given: biases in m/s² "
    "may be wrong by 0.3 % of themselves; give --gravity"
)
NO_GRAVITY = (
    "local gravity was not given: scale factors of accelerometers, which are ratios to it, are not "
    "determined; give --gravity"
)


@dataclass(frozen=True)
class ChannelRead:
    """How one channel was read: its column, its unit, and how the unit is known."""

    channel: str
    column: str
    unit: str
    how: str


@dataclass(frozen=True)
class Understood:
    """A recording made of a logger's table, and what was understood of it.

    rows: of each channel. notes: what was taken for granted or left out. gravity: m/s² of one g
    and of the place. mapping: what --like repeats. breaks: where the clock did not run on; lines:
    of the file, (n,) of the rows.
    """

    recording: Recording
    rows: tuple[ChannelRead, ...]
    notes: tuple[str, ...]
    gravity: float
    mapping: Mapping[str, object]
    breaks: tuple[units.ClockBreak, ...]
    lines: np.ndarray


def is_log(path: Path) -> bool:
    """Whether a path is a table of a logger by its name."""
    return path.suffix.lower() in readers() and not path.is_dir()


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
    stated = changes.gravity or place.gravity_m_s2
    gravity = stated or STANDARD_GRAVITY
    notes, rows = list[str](), list[ChannelRead]()
    timing = timed(sheet, found.times, protocol_path, changes.units.get("t"), changes.shift)
    if timing.times is None:
        raise _unusable(sheet, [timing.how])
    notes += timing.notes
    sheet.faults += timing.faults
    used = dict(found.columns)
    if timing.column is not None:
        rows.append(ChannelRead("t", timing.column.name, timing.times.unit, timing.how))
        used["t"] = timing.column
    labels = timing.protocol
    raw, seen = _readings(sheet, used, timing.times.seconds)
    if protocol_path is not None:
        sheet.faults += [f"{protocol_path.name}: {fault}" for fault in labels.faults]
        notes += [f"{protocol_path.name}: {note}" for note in labels.notes]
    t = timing.times.seconds - timing.origin
    scales = dict[str, Scale]()
    for triad, name in ((GYRO, "gyro"), (ACCEL, "accel"), (ANGLE, "angle"), (("temperature",), "")):
        own = {c: used[c] for c in triad if c in raw}
        if not own:
            continue
        one, how = scale_of(
            name or "temperature", own, changes.units, gravity,
            {c: raw[c] for c in own}, t, labels.segments,
        )  # fmt: skip
        if one is None:
            sheet.faults.append(how)
            continue
        scales |= dict.fromkeys(own, one)
        rows += [ChannelRead(c, column.name, one.text, how) for c, column in own.items()]
    if not np.isfinite(raw.get("temperature", 0.0)).all():
        notes.append("temperature is empty in some rows: left out")
        del raw["temperature"]
    if sheet.faults:
        raise _unusable(sheet)
    values = {c: v * scales[c].factor + scales[c].offset for c, v in raw.items()}
    if changes.axes is not None:
        values = changes.axes.applied(values)
    stream = _stream(sheet, t, values)
    mapping = {
        "columns": {c: one.name for c, one in used.items()},
        "units": {n: scales[c].text for n, c in _one_of_each(scales).items()}
        | ({"t": timing.times.unit} if plain(timing.times.unit) in units.TIME else {}),
        **({"axes": changes.axes.text} if changes.axes else {}),
    }
    source = hashlib.sha256(path.read_bytes()).hexdigest()
    manifest = Manifest.model_validate({
        "format": FORMAT, "recording_id": path.stem,
        "unit": (unit or Unit(manufacturer="-", model="-", serial="-")).model_dump(),
        "station": {**place.model_dump(), "gravity_m_s2": _local_gravity(stated, scales, notes)},
        "segments": [s.model_dump(exclude_none=True) for s in labels.segments] or None,
        "imported": {
            "source": path.name, "source_sha256": source, **changes.as_fields(), **mapping,
            SI_PER_UNIT: {n: scales[c].factor for n, c in _one_of_each(scales).items()},
            **({SEEN: TypeAdapter(list[Seen]).dump_python(seen, mode="json")} if seen else {}),
        },
        **changes.of_table(),
        **({"acquired_at": _moment(timing.origin)} if timing.times.kind == "epoch" else {}),
    })  # fmt: skip
    check_controls(manifest.model_dump(mode="json"), str(path))
    recording = Recording(manifest, stream)
    return Understood(
        recording, tuple(rows), (*sheet.notes, *notes), gravity, mapping, timing.times.breaks,
        sheet.lines,
    )  # fmt: skip


def _readings(
    sheet: Sheet, used: Mapping[str, Column], seconds: np.ndarray
) -> tuple[dict[str, np.ndarray], list[Seen]]:
    """The channels as they were written, without what is no reading; what is wrong with them is
    added to the sheet's faults.

    seconds: (n,) of the rows, where no column of numbers tells their stamps.
    """
    before = len(sheet.faults)
    raw = {c: sheet.numbers(one.place) for c, one in used.items() if c != "t"}
    shared = _rows_of_both(raw)
    if shared is not None:
        del sheet.faults[before:]
    if shared == 0:
        sheet.faults.append(
            "each row holds gyros or accelerometers, and none holds both: give one row for each "
            "stamp, with all six"
        )
    raw, seen = without_marks(_whole_triads(raw))
    stamped = "t" in used and sheet.is_numeric(used["t"].place)
    stamps = sheet.numbers(used["t"].place) if stamped else seconds
    sheet.faults += several_sensors(sheet, {one.place for one in used.values()}, raw, stamps)
    return raw, seen


def _rows_of_both(raw: Mapping[str, np.ndarray]) -> int | None:
    """How many rows hold both triads, where some lack a whole one, as of a sensor that is read less
    often; None where rows lack a part of one.
    """
    lost = {c: np.isnan(values) for c, values in raw.items() if c in GYRO + ACCEL}
    alike = all(np.array_equal(lost[c], lost.get(c[:-1] + "x", lost[c])) for c in lost)
    return int((~np.any(list(lost.values()), axis=0)).sum()) if lost and alike else None


def _whole_triads(values: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The values; a row that lacks one of a triad's three has none of them."""
    made = dict(values)
    triads: tuple[tuple[str, ...], ...] = (GYRO, ACCEL, ANGLE)
    for triad in triads:
        if set(triad) <= set(made):
            lost = np.isnan([made[c] for c in triad]).any(axis=0)
            made |= {c: np.where(lost, np.nan, made[c]) for c in triad}
    return made


def _local_gravity(
    stated: float | None, scales: Mapping[str, Scale], notes: list[str]
) -> float | None:
    """As stated; of readings in g the standard one, for scale factors, which are ratios to gravity,
    do not depend on what one g is; else not known."""
    if stated is not None:
        return stated
    in_g = ACCEL[0] in scales and is_in_g(scales[ACCEL[0]].text)
    notes.append(STANDARD_G if in_g else NO_GRAVITY)
    return STANDARD_GRAVITY if in_g else None


def _unusable(sheet: Sheet, more: list[str] | None = None) -> Unusable:
    faults = [*dict.fromkeys(sheet.faults), *(more or [])]
    return Unusable(f"{sheet.path}: {'; '.join(faults)}.")


def _one_of_each(scales: Mapping[str, Scale]) -> dict[str, str]:
    return {channel.split("_")[0]: channel for channel in scales}


def _moment(origin: float) -> str:
    return str(np.datetime64(round(origin * 1e3), "ms")) + "Z"


def _stream(sheet: Sheet, t: np.ndarray, values: Mapping[str, np.ndarray]) -> Stream:
    """The unit's stream; a triad that was not recorded is null, as the format has it."""
    made = dict(values)
    for triad in (GYRO, ACCEL):
        if ANGLE[0] not in made or set(triad) & set(made):
            made |= {c: np.full(len(t), np.nan) for c in triad if c not in made}
    stream = Stream(np.rint(t * 1e9) / 1e9, made)
    if (row := first(np.diff(stream.t) <= 0)) is not None:
        raise _unusable(
            sheet, [f"line {sheet.lines[row + 1]} is less than a nanosecond after the one before"]
        )
    check_stream(str(sheet.path), "imu", stream)
    return stream
