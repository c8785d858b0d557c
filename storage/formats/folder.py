"""Reads recordings in the exchange format `mimu-recording/1`: a folder of Parquet or CSV."""

import os
from dataclasses import replace
from io import BytesIO
from pathlib import Path, PurePosixPath

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from pyarrow import csv
from pyarrow.types import is_decimal, is_floating, is_integer, is_null

from schemas.base import Unusable
from schemas.recording import STREAMS, Manifest, Recording, Stream
from storage.formats.content import canonical, fingerprint, nanoseconds, to_numpy, together
from storage.formats.manifest import (
    MANIFEST,
    check_columns,
    check_stream,
    first,
    known_columns,
    manifest_of,
)
from storage.whole_files import text_bytes

# One stream file, Parquet or CSV, as columns of numbers.

NULLS = ("", "null", "NULL", "nan", "NaN", "NAN", "NA", "N/A")

OTHER_SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars"}  # separators that are not CSV's
PARQUET = b"PAR1"
VALUE_BYTES = 8  # of a number in memory, however short it is in the file
SHARE = 0.25  # of the memory, for one stream before anything is made of it
GB = 1e9
HEAD = 2**20  # bytes in which a header ends


class StreamTable:
    """The columns of a file; they become numbers when they are asked for."""

    def __init__(self, path: Path, table: pa.Table) -> None:
        self._path = path
        self._table = table
        self._names: list[str] = [name.strip() for name in table.column_names]

    def __contains__(self, name: str) -> bool:
        return name in self._names

    def numbers(self, name: str) -> np.ndarray:
        """A column as (n,) float64, NaN where it is null; raises Unusable for what is no number."""
        if self._names.count(name) > 1:
            raise Unusable(f"{self._path}: column {name} is there twice; keep one of them.")
        column = self._table.column(self._names.index(name))
        kind = column.type
        if kind == pa.float64():
            return to_numpy(column)
        import pyarrow.compute as pc  # late: what was kept is float64

        if pa.types.is_string(kind) and self._path.suffix.lower() == ".csv":
            column = pc.utf8_trim_whitespace(column)
            column = pc.if_else(pc.is_in(column, pa.array(NULLS)), None, column)
        elif not _is_number(kind):
            raise Unusable(
                f"{self._path}: column {name} holds {kind}, not numbers; "
                "write it as float64 (t in seconds)."
            )
        try:
            column = pc.cast(column, pa.float64(), safe=False)
        except pa.ArrowInvalid as error:
            raise self._not_a_number(name, column) from error
        return to_numpy(column)

    def _not_a_number(self, name: str, column: pa.ChunkedArray) -> Unusable:
        for row, value in enumerate(column.to_pylist(), start=1):
            try:
                float("0" if value is None else value)
            except ValueError:
                return Unusable(
                    f"{self._path}: column {name}, row {row}: {value[:40]!r} is not a number; "
                    "write a number with a decimal point, or leave it empty for null."
                )
        return Unusable(f"{self._path}: column {name} is not all numbers; write it as numbers.")


def _is_number(kind: pa.DataType) -> bool:
    """A column without any value has the type null, and counts."""
    return is_integer(kind) or is_floating(kind) or is_decimal(kind) or is_null(kind)


def read_table(path: Path) -> StreamTable:
    """Reads a Parquet or CSV file; raises Unusable for one that is empty or not what it says."""
    if not path.stat().st_size:
        raise Unusable(f"{path} is empty; export it again, or take its stream out.")
    try:
        if path.suffix.lower() == ".csv":
            _check_size(path, path.stat().st_size)
            table = _read_csv(path)
        else:
            with pq.ParquetFile(path) as file:
                _check_size(path, file.metadata.num_rows * file.metadata.num_columns * VALUE_BYTES)
                table = file.read()
    except (pa.ArrowException, OSError, ValueError) as error:
        reason = str(error).splitlines()[0].rstrip(".")
        kind = path.suffix[1:]
        raise Unusable(f"{path} cannot be read as {kind} ({reason}); export it again.") from error
    if not table.num_rows:
        raise Unusable(f"{path} has no row of data; export it again, or take its stream out.")
    return StreamTable(path, table)


def memory_bytes() -> int:
    """The computer's memory."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def _check_size(path: Path, needed: int) -> None:
    """Raises Unusable for a file that takes more than its share of the computer's memory."""
    memory = memory_bytes()
    if needed > SHARE * memory:
        raise Unusable(
            f"{path} needs {needed / GB:.1f} GB of memory and the computer has "
            f"{memory / GB:.1f} GB: split the recording, or read it on a larger computer."
        )


def _read_csv(path: Path) -> pa.Table:
    """Everything as text at first, so that a value that is no number can be named."""
    text = {name: pa.string() for name in _header(path)}
    options = csv.ConvertOptions(column_types=text, strings_can_be_null=False)
    try:
        return csv.read_csv(path, convert_options=options)
    except pa.ArrowInvalid as error:
        raise _uneven_row(path) or error from error


def _header(path: Path) -> list[str]:
    """The names in the first line that is not blank; raises Unusable for another separator."""
    with path.open("rb") as file:
        begins = file.read(HEAD)
    if begins.startswith(PARQUET):
        raise Unusable(f"{path} is a Parquet file, not CSV; let its name end in .parquet.")
    line = next((line for line in begins.splitlines() if line.strip()), b"")
    _check_text(path, line, 1)
    names: list[str] = csv.read_csv(BytesIO(line + b"\n")).column_names
    for sign, separators in OTHER_SEPARATORS.items():
        if len(names) == 1 and sign in names[0]:
            raise Unusable(
                f"{path}: the header {names[0][:60]!r} has {separators} between its names; "
                "separate fields with commas, and write numbers with a decimal point."
            )
    return names


def _check_text(path: Path, line: bytes, number: int) -> None:
    try:
        line.decode()
    except UnicodeDecodeError as error:
        raise Unusable(
            f"{path}: line {number} is not UTF-8 text (byte {line[error.start]:#04x}); export the "
            "table again as CSV in UTF-8, or name the file by what it is."
        ) from error


def _uneven_row(path: Path) -> Unusable | None:
    """What to say of the first row with too few or too many fields, if there is one.

    Raises Unusable for a line that is no text: pyarrow cannot hand over such a row.
    """
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            _check_text(path, line, number)
    uneven: list[csv.InvalidRow] = []

    def note(row: csv.InvalidRow) -> str:
        uneven.append(row)
        return "skip"

    in_order = csv.ReadOptions(use_threads=False)  # or rows have no number
    csv.read_csv(path, in_order, csv.ParseOptions(invalid_row_handler=note))
    if not uneven:
        return None
    row = uneven[0]
    return Unusable(
        f"{path}: row {row.number - 1}: {row.actual_columns} fields where the header has "
        f"{row.expected_columns}; correct the row {row.text[:60]!r}."
    )


MAX_LENGTH = 80  # characters of a name in a sentence


def read_folder(folder: Path, second: float = 1.0) -> Recording:
    """Reads a `mimu-recording/1` folder (deploy/guide/recordings.md), with its digest.

    second: s that one of its t is, where they were written in another unit.
    Times are rounded to whole nanoseconds and columns that the format does not know are left
    out. Raises Unusable, naming file, column, row (the first row of data is 1), value and the
    way out, for everything that the format does not allow.
    """
    manifest = _manifest(folder)
    streams: dict[str, Stream] = {}
    for name in manifest.streams:
        path = _path(folder, manifest, name)
        table = read_table(path)
        wanted = [column for column in known_columns(name, manifest) if column in table]
        if "t" not in table:
            raise Unusable(f"{path}: column t is missing; add the time of each row in seconds.")
        check_columns(str(path), name, manifest, set(wanted))
        t = table.numbers("t") if second == 1.0 else table.numbers("t") * second
        stream = Stream(t, {column: table.numbers(column) for column in wanted})
        check_stream(str(path), name, stream)
        if (before := first(np.diff(nanoseconds(t)) <= 0)) is not None:
            row = before + 1
            raise Unusable(
                f"{path}: column t, row {row + 1}: {float(t[row])!r} s is less than a nanosecond "
                f"after the row before; times are kept to whole nanoseconds, so remove one of them."
            )
        streams[name] = stream
    recording = canonical(together(manifest, streams))
    return replace(recording, digest=fingerprint(recording))


def _manifest(folder: Path) -> Manifest:
    path = folder / MANIFEST
    if not folder.is_dir():
        raise Unusable(f"{folder}: there is no such folder; give a folder with a {MANIFEST}.")
    try:
        text = text_bytes(path)
    except OSError as error:
        raise Unusable(
            f"{path}: the manifest cannot be read ({error.strerror}); a recording needs it."
        ) from error
    manifest = manifest_of(text, str(path))
    for name in manifest.streams:
        if name not in STREAMS:
            raise Unusable(
                f"{path}: streams.{name} is not a stream of the format; "
                f"it knows {', '.join(STREAMS)}."
            )
    if "imu" not in manifest.streams:
        raise Unusable(f"{path}: streams.imu is missing; name the file of the unit's readings.")
    return manifest


def _path(folder: Path, manifest: Manifest, name: str) -> Path:
    """The file of a stream, which must be in the folder."""
    file = manifest.streams[name]
    where = f"{folder / MANIFEST}: streams.{name} is {_short(file)}"
    given = PurePosixPath(file)
    if "\0" in file or given.is_absolute() or ".." in given.parts:
        raise Unusable(f"{where}, a path that leaves the folder; put the file beside the manifest.")
    path = folder / given
    try:
        outside = not path.resolve().is_relative_to(folder.resolve())
        there = path.is_file()
    except (OSError, RuntimeError) as error:  # a name that is too long, links in a circle
        why = error.strerror if isinstance(error, OSError) else "its links run in a circle"
        raise Unusable(f"{where}, which cannot be opened ({why}); name a file there.") from error
    if outside:
        raise Unusable(f"{where}, a link that leaves the folder; put the file itself there.")
    if given.suffix.lower() not in (".parquet", ".csv"):
        raise Unusable(f"{where}; a stream is a .parquet or a .csv file.")
    if not there:
        raise Unusable(f"{where}, but there is no such file; add it, or take the stream out.")
    return path


def _short(file: str) -> str:
    return repr(file if len(file) <= MAX_LENGTH else f"{file[:MAX_LENGTH]}…")
