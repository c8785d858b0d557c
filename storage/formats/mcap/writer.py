"""Writes raw recordings: a ROS 2 bag in MCAP that Foxglove and PlotJuggler can open directly."""

import os
import threading
import time
from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta
from itertools import pairwise
from pathlib import Path
from typing import Self

import numpy as np

from schemas.base import Unusable
from schemas.recording import FORMAT, Manifest, Recording, Stream, joined
from storage.formats.content import NANO, canonical, nanoseconds
from storage.formats.mcap.chunks import ChunkWriter
from storage.formats.mcap.messages import MESSAGES, encode
from storage.whole_files import drafted

BLOCK = 60.0  # s: largest distance in time between chunks of different topics
PERIOD = 0.5  # s, between two flushes to the disk
PATIENCE = 10.0  # s for which a disk may delay writing
LAST_SECOND = 2**31 - 1  # of the stamps of ROS 2, in 2038
EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


def write_mcap(recording: Recording, path: Path) -> None:
    """Writes a recording as a ROS 2 bag; the file appears under its name only when it is whole."""
    streams = canonical(recording).streams()
    first = min(float(stream.t[0]) for stream in streams.values())
    last = max(float(stream.t[-1]) for stream in streams.values())
    origin = _origin(recording.manifest, first, last)
    with drafted(path) as draft, draft.open("xb") as out:
        chunks = ChunkWriter(out)
        _put_manifest(chunks, recording.manifest, origin)
        for name, part in _in_blocks(streams):
            _put(chunks, name, part, origin)
        chunks.close()


class RawWriter:
    """Writes a recording while it is being made; its stamps count from the manifest's day.

    Rows are on the disk PERIOD and two flushes of it after they were given, at the latest: within
    two seconds on a disk that flushes in 0.6 s, whatever then becomes of the process or of the
    power. What is there can be read with `read_mcap(…, salvage=True)` even without `close`.

    A fault in writing (a full disk), or a disk that keeps rows waiting for longer than PATIENCE,
    is raised as OSError by the next call; no call waits for the disk but `close`. Raises
    FileExistsError for a path that is taken: raw recordings are written once.
    """

    def __init__(self, path: Path, clock: Callable[[], float] = time.monotonic) -> None:
        self._out = path.open("xb")
        _keep_name(path)
        self._clock = clock
        self.readings = 0  # rows of the unit that were given
        self._chunks = ChunkWriter(self._out)
        self._origin: int | None = None  # ns, once something is written
        self._given: list[tuple[str, Stream]] = []
        self._manifest: Manifest | None = None  # the last that was given and is not written
        self._oldest: float | None = None  # when the first was given that is not on the disk
        self._giving = threading.Lock()  # held for a moment only: acquisition never waits
        self._writing = threading.Lock()
        self._done = threading.Event()
        self._write_error: BaseException | None = None
        self._thread = threading.Thread(target=self._keep_flushing, daemon=True)
        self._thread.start()

    def append(self, name: str, stream: Stream) -> None:
        """Appends rows of a stream: imu, table (its encoders), reference or environment."""
        if len(stream) and stream.t.min() < 0:
            raise Unusable(
                f"The {name} stream has a time of {stream.t.min()} s, and a raw recording knows no "
                "time before zero; count from the start of the recording."
            )
        self._check_disk()
        with self._giving:
            self._given.append((name, stream))
            self._oldest = self._clock() if self._oldest is None else self._oldest
        if name == "imu":
            self.readings += len(stream)

    def manifest(self, manifest: Manifest) -> None:
        """Writes the manifest as it is known now; the last one counts, the first tells the day."""
        self._check_disk()
        with self._giving:
            self._manifest = manifest

    def close(self) -> None:
        """Writes what is left, and the summary."""
        if self._out.closed:
            return
        self._done.set()
        self._thread.join()
        try:
            self._flush()
            self._chunks.close()
        except OSError as error:
            self._write_error = error
            raise
        finally:
            self._out.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    @property
    def is_broken(self) -> bool:
        """Whether the disk refused what was recorded, or keeps it waiting for too long."""
        oldest = self._oldest
        is_late = oldest is not None and self._clock() - oldest > PATIENCE
        return self._write_error is not None or is_late

    def _check_disk(self) -> None:
        if self._write_error is not None:
            raise self._write_error
        if self.is_broken:
            raise OSError(f"the disk has not taken what was recorded for {PATIENCE:g} s")

    def _keep_flushing(self) -> None:
        pause = PERIOD
        while not self._done.wait(pause):
            began = self._clock()
            try:
                self._flush()
            except BaseException as error:
                self._write_error = error
                return
            pause = max(0.0, PERIOD - (self._clock() - began))

    def _flush(self) -> None:
        if self._write_error is not None:
            raise self._write_error
        with self._writing:
            with self._giving:
                given, self._given = self._given, []
                manifest, self._manifest = self._manifest, None
                oldest = self._oldest
            if self._origin is None and (given or manifest is not None):
                self._origin = 0 if manifest is None else _origin(manifest, 0.0, 0.0)
                self._put_manifest(manifest)  # without it, rows have no unit and no station
            for name, stream in _joined(given):
                _put(self._chunks, name, stream, self._origin or 0)
            self._put_manifest(manifest)  # after the rows of the segments that it lists
            if given or manifest is not None:
                self._chunks.flush()
            with self._giving:
                if self._oldest == oldest:
                    self._oldest = self._clock() if self._given else None

    def _put_manifest(self, manifest: Manifest | None) -> None:
        if manifest is not None:
            _put_manifest(self._chunks, manifest, self._origin or 0)


def _origin(manifest: Manifest, first: float, last: float) -> int:
    """The stamp in ns of t = 0 in a file of times from first to last, s.

    That of `acquired_at`, where it is known and the stamps of ROS 2 can say it; else zero, or
    what takes it that neither MCAP nor ROS 2 knows a time before zero.
    """
    earliest = max(0, int(np.ceil(-first))) * NANO
    try:
        day = datetime.fromisoformat((manifest.model_extra or {})["acquired_at"])
        since = (day - EPOCH) // timedelta(microseconds=1) * 1000
    except (KeyError, TypeError, ValueError):  # not stated, or without an offset from UTC
        return earliest
    return since if earliest <= since <= (LAST_SECOND - max(last, 0.0)) * NANO else earliest


def _keep_name(path: Path) -> None:
    """Has the file's name on the disk, too: a power cut must not cost the whole file."""
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def _put(chunks: ChunkWriter, name: str, stream: Stream, origin: int) -> None:
    stamps = nanoseconds(stream.t) + origin
    clock = {"sec": (stamps // NANO)[:, None], "nanosec": (stamps % NANO)[:, None]}
    batches = tuple(MESSAGES[name](stream))
    chunks.introduce({batch.topic: batch.kind for batch in batches})
    for batch in batches:
        numbers = dict(batch.numbers) | (clock if batch.texts else {})
        chunks.messages(batch.topic, stamps, encode(batch.kind, numbers, batch.texts))


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
