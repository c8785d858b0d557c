"""Writing raw recordings: a ROS 2 bag in MCAP that Foxglove and PlotJuggler open as it is."""

import threading
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Self

import numpy as np

from schemas.base import Unusable
from schemas.recording import FORMAT, Manifest, Recording, Stream, joined
from storage.formats.content import NANO, as_raw, nanoseconds
from storage.formats.mcap.cdr import encode
from storage.formats.mcap.chunk_writer import ChunkWriter
from storage.formats.mcap.topics import MESSAGES
from storage.whole_files import drafted

BLOCK = 60.0  # s, so far apart the chunks of different topics may lie in time
PERIOD = 0.5  # s, after which rows that were given are on the disk


def write_mcap(recording: Recording, path: Path) -> None:
    """Writes a recording as a ROS 2 bag; the file appears under its name only when it is whole."""
    streams = as_raw(recording).streams()
    first = min(float(stream.t[0]) for stream in streams.values())
    origin = max(0, int(np.ceil(-first))) * NANO  # MCAP knows no time before zero
    with drafted(path) as draft, draft.open("xb") as out:
        chunks = ChunkWriter(out)
        _put_manifest(chunks, recording.manifest, origin)
        for name, part in _in_blocks(streams):
            _put(chunks, name, part, origin)
        chunks.close()


class RawWriter:
    """Writes a recording while it is being made.

    Rows are on the disk about a second after they were given, whatever then becomes of the
    process; what is there can be read with `read_mcap(…, salvage=True)` even without `close`.
    A fault in writing (a full disk) is raised by the next call. Raises FileExistsError for a
    path that is taken: raw recordings are written once.
    """

    def __init__(self, path: Path) -> None:
        self._out = path.open("xb")
        self.readings = 0  # rows of the unit that were given
        self._chunks = ChunkWriter(self._out)
        self._given: list[tuple[str, Stream]] = []
        self._giving = threading.Lock()  # held for a moment only: acquisition never waits
        self._writing = threading.Lock()
        self._done = threading.Event()
        self._write_error: BaseException | None = None
        self._thread = threading.Thread(target=self._keep_flushing, daemon=True)
        self._thread.start()

    def append(self, name: str, stream: Stream) -> None:
        """Appends rows of a stream: imu, table (its encoders), reference or environment."""
        if self._write_error is not None:
            raise self._write_error
        if len(stream) and stream.t.min() < 0:
            raise Unusable(
                f"The {name} stream has a time of {stream.t.min()} s, and a raw recording knows no "
                "time before zero; count from the start of the recording."
            )
        if name == "imu":
            self.readings += len(stream)
        with self._giving:
            self._given.append((name, stream))

    def manifest(self, manifest: Manifest) -> None:
        """Writes the manifest as it is known now; the last one counts."""
        self._flush()
        with self._writing:
            _put_manifest(self._chunks, manifest, 0)
            self._chunks.flush()

    def close(self) -> None:
        """Writes what is left, and the summary."""
        if self._out.closed:
            return
        self._done.set()
        self._thread.join()
        try:
            self._flush()
            self._chunks.close()
        finally:
            self._out.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _keep_flushing(self) -> None:
        while not self._done.wait(PERIOD):
            try:
                self._flush()
            except BaseException as error:
                self._write_error = error
                return

    def _flush(self) -> None:
        if self._write_error is not None:
            raise self._write_error
        with self._writing:
            with self._giving:
                given, self._given = self._given, []
            for name, stream in _joined(given):
                _put(self._chunks, name, stream, 0)
            if given:
                self._chunks.flush()


def _put(chunks: ChunkWriter, name: str, stream: Stream, origin: int) -> None:
    stamps = nanoseconds(stream.t) + origin
    clock = {"sec": (stamps // NANO)[:, None], "nanosec": (stamps % NANO)[:, None]}
    for batch in MESSAGES[name](stream):
        numbers = dict(batch.numbers) | (clock if batch.texts else {})
        chunks.messages(batch.topic, batch.kind, stamps, encode(batch.kind, numbers, batch.texts))


def _put_manifest(chunks: ChunkWriter, manifest: Manifest, origin: int) -> None:
    text = manifest.model_dump_json()
    chunks.metadata(FORMAT, {"manifest": text, "origin_ns": str(origin)})


def _in_blocks(streams: dict[str, Stream]) -> Iterator[tuple[str, Stream]]:
    """The streams cut into pieces of BLOCK seconds, in the order of time; each row is in one."""
    first = min(stream.t[0] for stream in streams.values())
    last = max(stream.t[-1] for stream in streams.values())
    for start, stop in pairwise(np.arange(first, last + 2 * BLOCK, BLOCK)):
        for name, stream in streams.items():
            rows = stream.rows(start, stop)
            if rows.start < rows.stop:
                yield name, stream.at(rows)


def _joined(given: list[tuple[str, Stream]]) -> Iterator[tuple[str, Stream]]:
    """What was given, with pieces of the same stream and the same columns put together."""
    groups: dict[tuple[str, tuple[str, ...]], list[Stream]] = {}
    for name, stream in given:
        groups.setdefault((name, tuple(stream.columns)), []).append(stream)
    for (name, _), parts in groups.items():
        yield name, joined(parts)
