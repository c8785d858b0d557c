"""Reads recordings in the exchange format `mimu-recording/1`: a folder of Parquet or CSV."""

from dataclasses import replace
from pathlib import Path, PurePosixPath

import numpy as np

from schemas.base import Unusable
from schemas.recording import STREAMS, Manifest, Recording, Stream
from storage.formats.checks import check_columns, check_stream, first, known_columns
from storage.formats.content import as_raw, fingerprint, nanoseconds, together
from storage.formats.manifest import MANIFEST, manifest_of
from storage.formats.stream_file import read_table
from storage.whole_files import text_bytes

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
    recording = as_raw(together(manifest, streams))
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
