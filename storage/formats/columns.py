"""A recording as columns: what every later step reads, one Parquet file for each stream.

The folder is a `mimu-recording/1` folder, laid out to be read fast: float64 as it is, neither
compressed nor nullable, in one row group.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from schemas.base import Unusable
from schemas.recording import Recording, Stream
from storage.formats.arrow import from_numpy, to_numpy
from storage.formats.content import digest, together
from storage.formats.manifest import MANIFEST, manifest_of
from storage.whole_files import drafted

if TYPE_CHECKING:
    import pyarrow as pa

DIGEST = b"mimucal.digest"  # in the metadata of each Parquet file


def write_columns(recording: Recording, folder: Path) -> None:
    """Writes a recording as columns into a folder that does not exist yet.

    The folder appears whole or not at all. Raises FileExistsError for one that is not empty.
    """
    content_digest = recording.digest or digest(recording)
    streams = recording.streams()
    files = {name: f"{name}.parquet" for name in streams}
    manifest = recording.manifest.model_copy(update={"streams": files})
    folder.parent.mkdir(parents=True, exist_ok=True)
    with drafted(folder) as draft:
        draft.mkdir()
        for name, stream in streams.items():
            _write(stream, draft / files[name], content_digest)
        (draft / MANIFEST).write_text(manifest.model_dump_json(indent=1), encoding="utf-8")


def read_columns(folder: Path) -> Recording:
    """Reads what `write_columns` wrote, with the digest it had; arrays are read-only.

    Raises Unusable for a folder that is not whole. The numbers are not checked again: they were
    when the recording was imported; `content.digest` computes whether they are still the same.
    """
    import pyarrow as pa

    where = str(folder / MANIFEST)
    try:
        manifest = manifest_of((folder / MANIFEST).read_bytes(), where)
        read = {name: _read(folder / file) for name, file in manifest.streams.items()}
    except (OSError, pa.ArrowException) as error:
        reason = str(error).splitlines()[0]
        raise Unusable(f"{folder} is not whole ({reason}); make the columns again.") from error
    digests = {content_digest for _, content_digest in read.values()}
    if "imu" not in read or len(digests) != 1:
        raise Unusable(f"{folder} holds files of different recordings; make the columns again.")
    recording = together(manifest, {name: stream for name, (stream, _) in read.items()})
    return replace(recording, digest=digests.pop())


def _write(stream: Stream, path: Path, content_digest: str) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns: Mapping[str, np.ndarray] = {"t": stream.t, **stream.columns}
    schema = pa.schema(
        [pa.field(name, pa.float64(), nullable=False) for name in columns], {DIGEST: content_digest}
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


def _read(path: Path) -> tuple[Stream, str]:
    import pyarrow.parquet as pq

    table: pa.Table = pq.ParquetFile(path, memory_map=True).read()
    columns = {name: to_numpy(table.column(name)) for name in table.column_names}
    content_digest = (table.schema.metadata or {}).get(DIGEST, b"").decode()
    return Stream(columns.pop("t"), columns), content_digest
