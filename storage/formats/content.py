"""The content of a recording, independent of its files: its canonical form and its digest."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from schemas.base import Unusable
from schemas.recording import ANGLE, TRIADS, Manifest, Recording, Stream
from storage.formats.manifest import MANIFEST, PLACE, known_columns, manifest_of
from storage.formats.mcap.messages import ENVIRONMENT_TOPICS, present
from storage.whole_files import drafted

NANO = 1_000_000_000
SPACED = 1021  # prime: no page or row group holds a multiple of it


def nanoseconds(t: np.ndarray) -> np.ndarray:
    """Times in s as whole nanoseconds, int64."""
    return np.rint(np.asarray(t) * 1e9).astype(np.int64)


def canonical(recording: Recording) -> Recording:
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
        for scalar in ENVIRONMENT_TOPICS
        if scalar.column in columns
    }


_EACH = {"imu": _imu, "reference": _reference, "environment": _environment}


def digest(recording: Recording) -> str:
    """SHA-256 (hex) of the content of a recording, the same from Parquet, CSV and MCAP.

    Over the manifest as canonical JSON, without `streams`, which only names files, and without
    nulls; then for each stream in alphabetical order its name, its column names, t as int64 ns and
    the columns as float64, all little-endian, with one NaN.
    """
    return fingerprint(canonical(recording))


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


# A recording as columns, which every later step reads: one Parquet file for each stream.
#
# The folder is a `mimu-recording/1` folder, laid out to be read fast: float64 as it is, neither
# compressed nor nullable, in one row group.

# In the metadata of each Parquet file: of the content, and of what was written.
DIGEST, CHECK_SUM = b"mimucal.digest", b"mimucal.check_sum"
BUFFER = 1 << 16  # bytes read at once: they are copied while they are in the processor's cache


def write_columns(recording: Recording, folder: Path) -> None:
    """Writes a recording as columns into a folder that does not exist yet.

    The folder appears whole or not at all. Raises FileExistsError for one that is not empty.
    """
    marks = {DIGEST: recording.digest or digest(recording), CHECK_SUM: check_sum(recording)}
    streams = recording.streams()
    files = {name: f"{name}.parquet" for name in streams}
    manifest = recording.manifest.model_copy(update={"streams": files})
    folder.parent.mkdir(parents=True, exist_ok=True)
    with drafted(folder) as draft:
        draft.mkdir()
        for name, stream in streams.items():
            path = draft / files[name]
            columns: Mapping[str, np.ndarray] = {"t": stream.t, **stream.columns}
            schema = pa.schema(
                [pa.field(name, pa.float64(), nullable=False) for name in columns], marks
            )
            table = pa.table([from_numpy(values) for values in columns.values()], schema=schema)
            pq.write_table(
                table,
                path,
                compression="none",
                use_dictionary=False,
                write_statistics=False,
                row_group_size=max(1, len(stream)),
                data_page_size=2**20,
            )
        (draft / MANIFEST).write_text(manifest.model_dump_json(indent=1), encoding="utf-8")


def read_columns(folder: Path) -> Recording:
    """Reads what `write_columns` wrote, with the digest it had; arrays are read-only.

    Raises Unusable for a folder that is not whole, or in which something was damaged since.
    """
    where = str(folder / MANIFEST)
    try:
        manifest = manifest_of((folder / MANIFEST).read_bytes(), where)
        read = {name: _read(folder / file) for name, file in manifest.streams.items()}
    except (OSError, pa.ArrowException) as error:
        reason = str(error).splitlines()[0]
        raise Unusable(f"{folder} is not whole ({reason}); make the columns again.") from error
    marks = {each for _, each in read.values()}
    if "imu" not in read or len(marks) != 1:
        raise Unusable(f"{folder} holds files of different recordings; make the columns again.")
    recording = together(manifest, {name: stream for name, (stream, _) in read.items()})
    content_digest, written = marks.pop()
    # Columns of earlier versions have no check sum.
    if (check_sum(recording) if written else fingerprint(recording)) != (written or content_digest):
        raise Unusable(f"{folder} is not what was written there; make the columns again.")
    return replace(recording, digest=content_digest)


def _read(path: Path) -> tuple[Stream, tuple[str, str]]:
    """The stream, with the digest and the check sum in its file."""
    # By one thread: what bounds it is the memory, and workers share the processors.
    with pq.ParquetFile(path, buffer_size=BUFFER, pre_buffer=False) as file:
        table: pa.Table = file.read(use_threads=False)
    columns = {name: to_numpy(table.column(name)) for name in table.column_names}
    metadata = table.schema.metadata or {}
    marks = metadata.get(DIGEST, b"").decode(), metadata.get(CHECK_SUM, b"").decode()
    return Stream(columns.pop("t"), columns), marks


def to_numpy(column: pa.ChunkedArray) -> np.ndarray:
    """(n,) float64, NaN where the column is null; without a copy where it has one chunk."""
    if column.null_count:
        import pyarrow.compute as pc  # late: what was kept has no nulls

        column = pc.fill_null(column, from_numpy(np.array([np.nan]))[0])
    parts = [np.from_dlpack(chunk) for chunk in column.chunks]
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def from_numpy(values: np.ndarray) -> pa.Array:
    """The values (n,) as float64 without nulls."""
    data = pa.py_buffer(np.ascontiguousarray(values, dtype=np.float64))
    return pa.Array.from_buffers(pa.float64(), len(values), [None, data])
