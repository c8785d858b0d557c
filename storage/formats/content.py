"""The content of a recording, independent of its files: its canonical form and its digest."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from schemas.recording import ANGLE, TRIADS, Manifest, Recording, Stream
from storage.formats.checks import PLACE, known_columns
from storage.formats.mcap.topics import ENVIRONMENT, present

NANO = 1_000_000_000
SPACED = 1021  # prime: no page or row group holds a multiple of it


def nanoseconds(t: np.ndarray) -> np.ndarray:
    """Times in s as whole nanoseconds, int64."""
    return np.rint(np.asarray(t) * 1e9).astype(np.int64)


def as_raw(recording: Recording) -> Recording:
    """The recording exactly as it comes back from raw MCAP.

    Whole nanoseconds; only columns the format knows; humidity and pressure to 15 digits; both
    triads, NaN where not recorded, unless an AHRS's angles stand in for one that is null in
    every row; no stream without a column.
    """
    streams: dict[str, Stream] = {}
    for name, stream in recording.streams().items():
        known = known_columns(name, recording.manifest)
        columns = {n: np.asarray(stream.columns[n], float) for n in known if n in stream.columns}
        if name in _EACH:
            columns = _EACH[name](columns, len(stream))
        if columns:
            streams[name] = Stream(nanoseconds(stream.t) / 1e9, columns)
    return replace(together(recording.manifest, streams), extra=recording.extra)


def together(manifest: Manifest, streams: Mapping[str, Any]) -> Recording:
    """A recording of a manifest and its streams by name; `imu` is among them."""
    return Recording(manifest, **streams)


def _imu(columns: dict[str, np.ndarray], rows: int) -> dict[str, np.ndarray]:
    kept = dict(columns)
    for triad in TRIADS:
        values = {n: columns.get(n, np.full(rows, np.nan)) for n in triad}
        if ANGLE[0] in columns and not present(values):
            kept = {n: v for n, v in kept.items() if n not in triad}
        else:
            kept |= values
    return kept


def _reference(columns: dict[str, np.ndarray], rows: int) -> dict[str, np.ndarray]:
    place = present({n: v for n, v in columns.items() if n in PLACE})
    return {n: v for n, v in columns.items() if n not in PLACE} | place


def _environment(columns: dict[str, np.ndarray], rows: int) -> dict[str, np.ndarray]:
    return {
        scalar.column: scalar.from_ros(scalar.to_ros(columns[scalar.column]))
        for scalar in ENVIRONMENT
        if scalar.column in columns
    }


_EACH = {"imu": _imu, "reference": _reference, "environment": _environment}


def digest(recording: Recording) -> str:
    """SHA-256 (hex) of the content of a recording, the same from Parquet, CSV and MCAP.

    Over the manifest as canonical JSON, without `streams`, which only names files, and without
    nulls; then for each stream in alphabetical order its name, its column names, t as int64 ns and
    the columns as float64, all little-endian, with one NaN.
    """
    return fingerprint(as_raw(recording))


def fingerprint(recording: Recording) -> str:
    """The digest of a recording that is already as raw MCAP gives it."""
    hasher = hashlib.sha256(_manifest_text(recording.manifest))
    for name, stream in sorted(recording.streams().items()):
        names = sorted(stream.columns)
        hasher.update(json.dumps([name, len(stream), names]).encode())
        hasher.update(nanoseconds(stream.t).astype("<i8").data)
        for column in names:
            hasher.update(_one_nan(stream.columns[column]).data)
    return hasher.hexdigest()


def check_sum(recording: Recording) -> str:
    """SHA-256 (hex) of sums over the content of a recording: it reveals damage, but not forgery.

    Several times as fast as the digest. The 64 bits of every SPACED-th number are added up, so that
    neither a changed number nor one in another's place goes unnoticed.
    """
    hasher = hashlib.sha256(_manifest_text(recording.manifest))
    for name, stream in sorted(recording.streams().items()):
        names = sorted(stream.columns)
        hasher.update(json.dumps([name, len(stream), names]).encode())
        for values in (stream.t, *(stream.columns[column] for column in names)):
            words = np.ascontiguousarray(values, dtype="<f8").view("<u8")
            whole = len(words) // SPACED * SPACED
            hasher.update(words[:whole].reshape(-1, SPACED).sum(axis=0).data)
            hasher.update(words[whole:].data)
    return hasher.hexdigest()


def _manifest_text(manifest: Manifest) -> bytes:
    fields: Mapping = manifest.model_dump(mode="json", exclude={"streams"}, exclude_none=True)
    return json.dumps(fields, sort_keys=True, separators=(",", ":")).encode()


def _one_nan(values: np.ndarray) -> np.ndarray:
    values = np.ascontiguousarray(values, dtype="<f8")
    absent = np.isnan(values)
    return np.where(absent, np.nan, values) if absent.any() else values
