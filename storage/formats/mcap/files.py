"""The files of a bag: one MCAP file, parts of a split bag, SQLite storage, zstd around either."""

import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import groupby
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

import numpy as np
import zstandard
from mcap.records import Channel, Schema

from schemas.base import Unusable
from storage.formats.mcap.chunk_reader import MAX_CHUNK_BYTES, Batch, Contents, scan

METADATA = "metadata.yaml"  # beside the files of a rosbag2 folder
SUFFIXES = (".mcap", ".db3", ".mcap.zstd", ".db3.zstd")
SQLITE = b"SQLite format 3\0"
ZSTD = b"\x28\xb5\x2f\xfd"
BUFFER = 2**20
MESSAGES = 20_000  # rows of a database taken together

Piece = TypeVar("Piece")


def bag_files(folder: Path) -> tuple[Path, ...]:
    """The files of a rosbag2 folder in the order of its metadata; none where it has no metadata.

    Raises Unusable for metadata that names no file that is there, or that leaves open which.
    """
    described = folder / METADATA
    if not described.exists():
        return ()
    import yaml

    try:
        known = yaml.safe_load(described.read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
        names = [str(name) for name in known["relative_file_paths"]]
    except (OSError, ValueError, KeyError, TypeError, yaml.YAMLError) as error:
        alone = [file for file in folder.iterdir() if file.name.lower().endswith(SUFFIXES)]
        if len(alone) == 1:
            return tuple(alone)
        raise Unusable(
            f"{folder} holds {len(alone)} MCAP files or databases, and {METADATA} does not say in "
            f"which order ({type(error).__name__}); run `ros2 bag reindex {folder}`, or give one "
            "of them."
        ) from error
    files = tuple(folder / Path(name).name for name in names)
    missing = [file.name for file in files if not file.is_file()]
    if missing or not files:
        raise Unusable(
            f"{described} names {', '.join(missing) or 'no file'}, which is not there; copy the "
            "bag whole, or give one of its files."
        )
    return files


def scan_file(
    path: Path, decode: Callable[[Contents, Batch], Piece], keep: Callable[[Piece], None]
) -> Contents:
    """Reads one file of a bag, whatever its storage, as `scan` reads MCAP."""
    with path.open("rb") as file:
        begins = file.read(len(SQLITE))
    if begins.startswith(ZSTD):
        with _unpacked(path) as whole:
            return scan_file(whole, decode, keep)
    if begins.startswith(SQLITE):
        return _scan_database(path, decode, keep)
    return scan(path, decode, keep)


@contextmanager
def _unpacked(path: Path) -> Iterator[Path]:
    """The file inside of one that is compressed as a whole, for as long as it is read."""
    with TemporaryDirectory() as folder:
        inside = Path(folder) / path.name.removesuffix(".zstd").removesuffix(".zst")
        try:
            with path.open("rb") as packed, inside.open("wb") as file:
                zstandard.ZstdDecompressor().copy_stream(packed, file, BUFFER, BUFFER)
        except zstandard.ZstdError as error:
            raise ValueError(f"cannot be unpacked ({error}); try `zstd -d {path}`") from error
        yield inside


def _scan_database(
    path: Path, decode: Callable[[Contents, Batch], Piece], keep: Callable[[Piece], None]
) -> Contents:
    contents = Contents()
    connection = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro&immutable=1", uri=True)
    try:
        topics = connection.execute("SELECT id, name, type, serialization_format FROM topics")
        for topic, name, kind, encoding in topics.fetchall():
            contents.schemas[topic] = Schema(id=topic, name=kind, encoding="", data=b"")
            contents.channels[topic] = Channel(
                id=topic, topic=name, message_encoding=encoding, metadata={}, schema_id=topic
            )
        rows = connection.execute(
            "SELECT topic_id, length(data), timestamp, data FROM messages "
            "ORDER BY topic_id, length(data), timestamp, id"
        )
        for (topic, _), alike in groupby(rows, key=lambda row: row[:2]):
            for batch in _batches(topic, alike):
                keep(decode(contents, batch))
    except sqlite3.DatabaseError as error:
        if not contents.channels:
            raise ValueError(
                f"is a database without the tables of a bag ({error}); convert it with `ros2 bag "
                "convert`"
            ) from error
        contents.damage = f"the database is damaged: {error}"
    finally:
        connection.close()
    return contents


def _batches(topic: int, rows: Iterator[tuple[int, int, int, bytes]]) -> Iterator[Batch]:
    """Messages of one topic and stored length, unpacked where each is compressed by itself."""
    unpack = zstandard.ZstdDecompressor()
    times: list[int] = []
    blocks: list[bytes] = []

    def batch() -> Batch:
        block = np.frombuffer(b"".join(blocks), np.uint8).reshape(len(blocks), -1)
        return Batch(topic, np.array(times, np.int64), block)

    for _, _, time, data in rows:
        if data[:4] == ZSTD:
            data = unpack.decompress(data, max_output_size=MAX_CHUNK_BYTES)
        if blocks and (len(data) != len(blocks[0]) or len(blocks) == MESSAGES):
            yield batch()
            times, blocks = [], []
        times.append(time)
        blocks.append(data)
    if blocks:
        yield batch()
