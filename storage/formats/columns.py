"""A recording as columns, which every later step reads: one Parquet file for each stream.

The folder is a `mimu-recording/1` folder, laid out to be read fast: float64 as it is, neither
compressed nor nullable, in one row group.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from schemas.base import Unusable
from schemas.recording import Recording, Stream
from storage.formats.content import check_sum, digest, fingerprint, together
from storage.formats.manifest import MANIFEST, manifest_of
from storage.whole_files import drafted

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
