"""Reads a manifest, and checks every text and number in it."""

import json
import math
from collections.abc import Iterator, Mapping
from typing import Any
from unicodedata import category

import numpy as np
from pydantic import ValidationError

from schemas.base import Unusable, first_fault
from schemas.recording import (
    ACCEL,
    ANGLE,
    ENVIRONMENT,
    FORMAT,
    GYRO,
    TRIADS,
    Manifest,
    Segment,
    Station,
    Stream,
    TableAxis,
    Unit,
)
from storage.whole_files import check_depth

KNOWN = {n for m in (Manifest, Unit, Station, TableAxis, Segment) for n in m.model_fields}
MANIFEST = "manifest.json"
LAYOUT = "\t\n\r"  # allowed in remarks, which are fields that the format does not know


def manifest_of(text: bytes | str, where: str) -> Manifest:
    """The manifest in a JSON text; raises Unusable naming `where` and the first fault."""
    try:
        fields = json.loads(text.decode("utf-8-sig") if isinstance(text, bytes) else text)
        check_depth(fields)
        check_values(fields, where)
    except UnicodeError as error:
        raise Unusable(f"{where} is not UTF-8 text ({error}); save it as UTF-8.") from error
    except (ValueError, RecursionError) as error:
        raise Unusable(f"{where} is not JSON ({error}); correct it there.") from error
    if not isinstance(fields, dict):
        raise Unusable(f"{where} holds a {type(fields).__name__}, not a JSON object in braces.")
    if fields.get("format") != FORMAT:
        form = fields.get("format")
        raise Unusable(f"{where}: format is {form!r}; this program reads {FORMAT!r}.")
    try:
        return Manifest.model_validate(fields)
    except ValidationError as error:
        raise Unusable(f"{where}: {first_fault(error)}; correct it there.") from error


def check_values(fields: object, where: str) -> None:
    """Raises Unusable for a number that is not finite and for half a surrogate pair."""
    for place, _, value in _leaves(fields):
        if isinstance(value, float) and not math.isfinite(value):
            raise Unusable(
                f"{where}: {_plain(place)} is {value} (NaN, Infinity, or beyond 1.8e308); "
                "give a finite number there, or null where it is unknown."
            )
        beyond_ascii = isinstance(value, str) and not value.isascii()
        if beyond_ascii and any(category(sign) == "Cs" for sign in value):
            raise Unusable(
                f"{where}: {_plain(place)} is {value[:40]!a}, with half of a surrogate pair, "
                "which is no character; write the whole character."
            )


def check_controls(fields: Mapping[str, Any], where: str) -> None:
    """Raises Unusable for control characters, which no label or certificate can print.

    Tabs and line ends may stand in remarks.
    """
    for place, key, value in _leaves(fields):
        allowed = "" if key in KNOWN else LAYOUT
        if isinstance(value, str) and any(
            category(sign) == "Cc" and sign not in allowed for sign in value
        ):
            raise Unusable(
                f"{where}: {_plain(place)} is {value[:40]!a}, with a control character in it; "
                "remove that character."
            )


def _leaves(value: Any, place: str = "", key: str = "") -> Iterator[tuple[str, str, Any]]:
    """Every value that contains no others, and every name, with its path and its nearest name."""
    if isinstance(value, Mapping):
        for name, inner in value.items():
            path = f"{place}.{name}" if place else name
            yield path, name, name
            yield from _leaves(inner, path, name)
    elif isinstance(value, list | tuple):
        for number, inner in enumerate(value):
            yield from _leaves(inner, f"{place}.{number}", key)
    else:
        yield place, key, value


def _plain(place: str) -> str:
    return place[:80].encode("unicode_escape").decode() if not place.isprintable() else place[:80]


# What a recording must satisfy before anything is computed from it, whatever its source.

MAX_TIME_S = 2**51 / 1e9  # s (26 days); beyond it a float64 cannot resolve nanoseconds
MAX_VALUE = 1e9  # in rad/s, m/s², rad, °C, Pa: beyond any sensor, and its square must not overflow
REFERENCE = ("qw", "qx", "qy", "qz")
PLACE = ("px", "py", "pz")


def known_columns(name: str, manifest: Manifest) -> tuple[str, ...]:
    """The columns, beside t, that `mimu-recording/1` knows in a stream."""
    if name == "table":
        axes = manifest.station.table_axes or ()
        return tuple(f"{axis.name}_{what}" for axis in axes for what in ("angle", "rate"))
    return {
        "imu": (*GYRO, *ACCEL, "temperature", *ANGLE),
        "reference": REFERENCE + PLACE,
        "environment": ENVIRONMENT,
    }[name]


def required_columns(name: str, manifest: Manifest, present: set[str]) -> tuple[str, ...]:
    """The columns that must be present, given those that are; triads must be complete."""
    if name == "table":
        axes = manifest.station.table_axes or ()
        return tuple(f"{axis.name}_angle" for axis in axes)
    if name == "reference":
        return REFERENCE + (PLACE if present & set(PLACE) else ())
    if name == "environment":
        return ()
    begun = [triad for triad in (GYRO, ACCEL, ANGLE) if present & set(triad)]
    needed = begun if present & set(ANGLE) else [GYRO, ACCEL, *begun]
    return tuple(dict.fromkeys(column for triad in needed for column in triad))


def check_columns(where: str, name: str, manifest: Manifest, present: set[str]) -> None:
    """Raises Unusable when a stream lacks a column, or a table its axes."""
    if name == "table" and not manifest.station.table_axes:
        raise Unusable(
            f"{where}: the recording has a table stream, but station.table_axes in the manifest "
            "is null; describe the table's axes there, or leave the stream out."
        )
    for column in required_columns(name, manifest, present):
        if column not in present:
            raise Unusable(
                f"{where}: column {column} is missing; add it under this name "
                f"(found: {', '.join(sorted(present)) or 'none that is known'})."
            )


def check_stream(where: str, name: str, stream: Stream) -> None:
    """Raises Unusable for times that do not rise and for values that are not numbers."""
    if not len(stream):
        raise Unusable(f"{where}: there is no row of data; record again, or leave the stream out.")
    _check_time(where, stream.t)
    triads = {column: triad for triad in TRIADS for column in triad} if name == "imu" else {}
    for column, values in stream.columns.items():
        wrong, way_out = ~np.isfinite(values), "or remove the row"
        if column in triads and wrong.any():
            wrong &= ~absent(stream, triads[column])
            way_out = "or null in all three columns of the triad"
        if (row := first(wrong)) is not None:
            raise Unusable(
                f"{where}: column {column}, row {row + 1}: the value is {_shown(values[row])}; "
                f"give a number there, {way_out}."
            )
        if (row := first(np.abs(values) > MAX_VALUE)) is not None:
            raise Unusable(
                f"{where}: column {column}, row {row + 1}: the value is {values[row]:.6g}, which "
                f"no sensor reads (more than {MAX_VALUE:.0e}); correct it, or remove the row."
            )
    measured = name != "imu" or ANGLE[0] in stream.columns
    if not measured and all(absent(stream, triad).all() for triad in TRIADS):
        raise Unusable(
            f"{where}: columns gyro_* and accel_* are null in all {len(stream)} rows; "
            "a recording needs at least one of them."
        )


def _check_time(where: str, t: np.ndarray) -> None:
    if (row := first(~np.isfinite(t))) is not None:
        raise Unusable(
            f"{where}: column t, row {row + 1}: the value is {_shown(t[row])}; "
            "every row needs a time in seconds."
        )
    if (row := first(np.abs(t) > MAX_TIME_S)) is not None:
        raise Unusable(
            f"{where}: column t, row {row + 1}: {float(t[row])!r} s is more than 26 days: let "
            "the time start near zero, or, if it is not in seconds, import with --units t=ms, t=us "
            "or t=ns."
        )
    if (before := first(np.diff(t) <= 0)) is not None:
        row = before + 1
        runs = "runs backwards" if t[row] < t[before] else "stands still"
        raise Unusable(
            f"{where}: column t, row {row + 1}: the time {runs} ({float(t[row])!r} s after "
            f"{float(t[before])!r} s); sort the rows and remove repeated ones."
        )


def first(wrong: np.ndarray) -> int | None:
    """The first row of (n,) that is wrong, if any."""
    return int(wrong.argmax()) if wrong.any() else None


def absent(stream: Stream, triad: tuple[str, ...]) -> np.ndarray:
    """(n,) where a triad was not recorded: all three of its columns are NaN."""
    rows = np.ones(len(stream), dtype=bool)
    for column in triad:
        if column in stream.columns:
            rows &= np.isnan(stream.columns[column])
    return rows


def _shown(value: float) -> str:
    return "null or NaN" if np.isnan(value) else str(value)
