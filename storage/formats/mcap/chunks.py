"""Chunks of an MCAP file: written with its summary, read again, also of a torn file."""

import mmap
import os
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from io import BytesIO
from itertools import islice
from pathlib import Path
from typing import BinaryIO, TypeVar

import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.stream_reader import get_chunk_data_stream

from storage.formats.mcap.messages import schema_text

# Writes an MCAP file: chunks of messages of equal length, then the summary.
#
# The mcap package writes message by message; here a whole block of messages becomes one chunk,
# and one chunk holds one channel, so that a reader can take it apart as an array.

MAGIC = b"\x89MCAP0\r\n"
CHUNK = 2**20  # bytes before compression
RECORD = struct.Struct("<BQ")  # opcode, length
MESSAGE = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log_time", "<u8"),
        ("publish_time", "<u8"),
    ]
)


class ChunkWriter:
    """Writes an MCAP file of ROS 2 messages to `out`; `close` makes it whole."""

    def __init__(self, out: BinaryIO) -> None:
        self._out = out
        self._crc = 0
        self._at = 0
        self._channels: dict[str, Channel] = {}
        self._schemas: dict[str, Schema] = {}
        self._counts: dict[int, int] = {}
        self._chunks: list[ChunkIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._compress = zstandard.ZstdCompressor(level=1).compress
        self._write(MAGIC + _bytes(Header(profile="ros2", library="mimucal")))

    def metadata(self, name: str, entries: Mapping[str, str]) -> None:
        """Writes a metadata record."""
        record = _bytes(Metadata(name=name, metadata=dict(entries)))
        self._metadata.append(MetadataIndex(offset=self._at, length=len(record), name=name))
        self._write(record)

    def introduce(self, topics: Mapping[str, str]) -> None:
        """Names the topics, each with its message type, of messages that belong together.

        A file that is cut off between them then tells which of them it lacks.
        """
        new = [self._register(*each) for each in topics.items() if each[0] not in self._channels]
        if new:
            self._write(b"".join(new))

    def messages(self, topic: str, stamps: np.ndarray, block: np.ndarray) -> None:
        """Writes messages of a topic that was introduced, in one chunk or more.

        stamps: (n,) int64 ns, not negative; block: (n, length) uint8, one message a row.
        """
        rows = max(1, CHUNK // (block.shape[1] + MESSAGE.itemsize))
        for start in range(0, len(block), rows):
            part = slice(start, start + rows)
            self._chunk(topic, stamps[part], block[part])

    def flush(self) -> None:
        """Puts on the disk what was written, so that it outlives the process and the power."""
        self._out.flush()
        os.fsync(self._out.fileno())

    def close(self) -> None:
        """Writes summary and footer and flushes; the stream itself stays open."""
        self._write(_bytes(DataEnd(data_section_crc=self._crc)))
        start = self._at
        summary, offsets = bytearray(), bytearray()
        for opcode, records in self._summary():
            group = b"".join(_bytes(record) for record in records)
            if group:
                place = SummaryOffset(opcode, start + len(summary), len(group))
                offsets += _bytes(place)
                summary += group
        offset_start = start + len(summary)
        summary += offsets
        footer = RECORD.pack(Opcode.FOOTER, 20) + struct.pack("<QQ", start, offset_start)
        crc = zlib.crc32(bytes(summary) + footer)
        self._write(bytes(summary) + _bytes(Footer(start, offset_start, crc)) + MAGIC)
        self.flush()

    def _write(self, data: bytes) -> None:
        self._out.write(data)
        self._crc = zlib.crc32(data, self._crc)
        self._at += len(data)

    def _chunk(self, topic: str, stamps: np.ndarray, block: np.ndarray) -> None:
        channel = self._channels[topic].id
        data = self._records(channel, stamps, block).tobytes()
        packed = self._compress(data)
        first, last = int(stamps.min()), int(stamps.max())
        chunk = _bytes(Chunk("zstd", packed, last, first, zlib.crc32(data), len(data)))
        stride = MESSAGE.itemsize + block.shape[1]
        offsets = stride * np.arange(len(stamps), dtype=np.uint64)
        index = np.column_stack([stamps.astype(np.uint64), offsets]).astype("<u8").tobytes()
        index = struct.pack("<HI", channel, len(index)) + index
        index = RECORD.pack(Opcode.MESSAGE_INDEX, len(index)) + index
        self._chunks.append(
            ChunkIndex(
                chunk_length=len(chunk),
                chunk_start_offset=self._at,
                compression="zstd",
                compressed_size=len(packed),
                message_end_time=last,
                message_index_length=len(index),
                message_index_offsets={channel: self._at + len(chunk)},
                message_start_time=first,
                uncompressed_size=len(data),
            )
        )
        self._write(chunk + index)

    def _records(self, channel: int, stamps: np.ndarray, block: np.ndarray) -> np.ndarray:
        rows, length = block.shape
        records = np.empty((rows, MESSAGE.itemsize + length), dtype=np.uint8)
        head = records[:, : MESSAGE.itemsize].view(MESSAGE)[:, 0]
        head["opcode"] = Opcode.MESSAGE
        head["length"] = length + MESSAGE.itemsize - RECORD.size
        head["channel"] = channel
        head["sequence"] = self._counts[channel] + np.arange(rows)
        head["log_time"] = head["publish_time"] = stamps
        records[:, MESSAGE.itemsize :] = block
        self._counts[channel] += rows
        return records

    def _register(self, topic: str, kind: str) -> bytes:
        """The records that introduce a new channel."""
        introduced: list[McapRecord] = []
        if kind not in self._schemas:
            text = schema_text(kind).encode()
            number = len(self._schemas) + 1
            self._schemas[kind] = Schema(id=number, data=text, encoding="ros2msg", name=kind)
            introduced.append(self._schemas[kind])
        channel = Channel(
            id=len(self._channels) + 1,
            topic=topic,
            message_encoding="cdr",
            metadata={"offered_qos_profiles": ""},  # rosbag2 looks for it
            schema_id=self._schemas[kind].id,
        )
        self._channels[topic] = channel
        self._counts[channel.id] = 0
        return b"".join(_bytes(record) for record in (*introduced, channel))

    def _summary(self) -> list[tuple[Opcode, list]]:
        statistics = Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=len(self._chunks),
            message_count=sum(self._counts.values()),
            message_start_time=min((c.message_start_time for c in self._chunks), default=0),
            message_end_time=max((c.message_end_time for c in self._chunks), default=0),
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )
        return [
            (Opcode.SCHEMA, list(self._schemas.values())),
            (Opcode.CHANNEL, list(self._channels.values())),
            (Opcode.STATISTICS, [statistics]),
            (Opcode.CHUNK_INDEX, self._chunks),
            (Opcode.METADATA_INDEX, self._metadata),
        ]


def _bytes(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    write: Callable[[RecordBuilder], None] = record.write
    write(builder)
    return builder.end()


# Reads an MCAP file front to back in whole chunks, as far as it is intact.

THREADS = 2
MAX_RUN_BYTES = 2**24  # bytes of messages outside of chunks that are taken together
MAX_CHUNK_BYTES = 2**28  # unpacked; recorders make chunks of some megabytes
CHUNKS_AHEAD = 16  # chunks that are open at the same time
COMPRESSIONS = ("zstd", "lz4", "")
PREFIX = RECORD.size + 2  # the bytes with the length and channel of a message
DESCRIPTIONS = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.METADATA)
FAULTS = (
    ArithmeticError,
    LookupError,
    MemoryError,
    RuntimeError,
    ValueError,
    struct.error,
    McapError,
    zstandard.ZstdError,
)

Piece = TypeVar("Piece")


@dataclass(frozen=True)
class Batch:
    """Messages of one channel and one length: channel id, (n,) log times in ns, (n, length)."""

    channel: int
    log_times: np.ndarray
    block: np.ndarray


@dataclass
class Contents:
    """What is known of a file beside its messages, filled while it is read."""

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    metadata: list[Metadata] = field(default_factory=list)
    damage: str = ""

    def add(self, opcode: int, body: bytes) -> None:
        """Takes up a schema, channel or metadata record, or notes that it is damaged."""
        stream = ReadDataStream(BytesIO(body))
        try:
            if opcode == Opcode.SCHEMA:
                schema = Schema.read(stream)
                self.schemas[schema.id] = schema
            elif opcode == Opcode.CHANNEL:
                channel = Channel.read(stream)
                self.channels[channel.id] = channel
            elif opcode == Opcode.METADATA:
                self.metadata.append(Metadata.read(stream))
        except FAULTS:
            self.damage = self.damage or "a damaged record"


@dataclass(frozen=True)
class _Opened:
    """A chunk taken apart: its introductions (schemas, channels), its messages, its fault."""

    introduced: list[tuple[int, bytes]]
    batches: list[Batch]
    fault: str = ""


def scan(
    path: Path, decode: Callable[[Contents, Batch], Piece], keep: Callable[[Piece], None]
) -> Contents:
    """Reads a file whole; each batch of messages goes through `decode`, and then to `keep`.

    `decode` may run in several threads; `keep` gets its results in the order of the file.
    Damage is not raised but described in `damage`, and what can be read behind it is read. Raises
    ValueError for a file that does not begin like MCAP.
    """
    if not path.stat().st_size:
        raise ValueError("is empty")
    with (
        path.open("rb") as file,
        mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data,
        ThreadPoolExecutor(THREADS) as pool,
    ):
        if data[: len(MAGIC)] != MAGIC:
            raise ValueError("is not an MCAP file")
        contents = Contents()
        chunks = _chunks(data, contents)

        def pieces(place: tuple[int, int]) -> tuple[str, list[Piece]]:
            opened = _open(data, *place)
            for opcode, body in opened.introduced:
                contents.add(opcode, body)
            return opened.fault, [decode(contents, batch) for batch in opened.batches]

        # Without a summary, a channel is known only after the chunk that introduces it.
        run = pool.map if contents.channels else map
        while group := list(islice(chunks, CHUNKS_AHEAD)):
            for fault, decoded in run(pieces, group):
                contents.damage = contents.damage or fault
                for piece in decoded:
                    keep(piece)
        return contents


def _chunks(data: mmap.mmap, contents: Contents) -> Iterator[tuple[int, int]]:
    """The places of the chunks; learns whatever else the file has at its top level."""
    chunks: list[tuple[int, int]] = []
    for opcode, start, stop in _records(data, contents):
        if opcode in (Opcode.CHUNK, Opcode.MESSAGE):
            chunks.append((start, stop))
        elif opcode in DESCRIPTIONS:
            contents.add(opcode, data[start + RECORD.size : stop])
    return _merged(data, chunks)


def _records(data: mmap.mmap, contents: Contents) -> Iterator[tuple[int, int, int]]:
    """The records (opcode, start, stop) up to the footer, or to where they make no sense."""
    at, whole = len(MAGIC), False
    while at + RECORD.size <= len(data) and not whole:
        opcode, length = RECORD.unpack_from(data, at)
        stop = at + RECORD.size + length
        if stop > len(data) or not (0 < opcode <= Opcode.DATA_END or opcode >= 0x80):
            break
        yield opcode, at, stop
        if opcode == Opcode.DATA_END:
            _check_data(data, at, contents)
        whole = opcode == Opcode.FOOTER and data[stop : stop + len(MAGIC)] == MAGIC
        at = stop
    if not whole:
        contents.damage = "it is cut off"


def _check_data(data: mmap.mmap, end: int, contents: Contents) -> None:
    if end + RECORD.size + 4 > len(data):
        return  # it is cut off
    (expected,) = struct.unpack_from("<I", data, end + RECORD.size)
    with memoryview(data) as view:
        if expected and zlib.crc32(view[:end]) != expected:
            contents.damage = "its checksum is wrong"


def _merged(data: mmap.mmap, places: list[tuple[int, int]]) -> Iterator[tuple[int, int]]:
    """Chunks as they are; messages outside of chunks in runs, which read like the inside of one."""
    run: tuple[int, int] | None = None
    for start, stop in places:
        loose = data[start] == Opcode.MESSAGE
        if run and loose and run[1] == start and stop - run[0] <= MAX_RUN_BYTES:
            run = (run[0], stop)
            continue
        if run:
            yield run
        run = (start, stop) if loose else None
        if not loose:
            yield start, stop
    if run:
        yield run


def _open(data: mmap.mmap, start: int, stop: int) -> _Opened:
    try:
        inside = data[start:stop] if data[start] == Opcode.MESSAGE else _unpacked(data, start, stop)
        return _split(inside)
    except FAULTS as error:
        return _Opened([], [], f"a chunk is damaged ({error})")


def _unpacked(data: mmap.mmap, start: int, stop: int) -> bytes:
    """What is in a chunk, with its checksum checked."""
    chunk = Chunk.read(ReadDataStream(BytesIO(data[start + RECORD.size : stop])))
    if chunk.compression not in COMPRESSIONS:
        raise ValueError(f"compression {chunk.compression} is unknown")
    _check_size(chunk)
    stream, size = get_chunk_data_stream(chunk)
    inside: bytes = stream.read(size)
    crc = chunk.uncompressed_crc
    if size != chunk.uncompressed_size or (crc and zlib.crc32(inside) != crc):
        raise ValueError("its checksum is wrong")
    return inside


def _check_size(chunk: Chunk) -> None:
    """Before room is made for a chunk: what it says of itself, and what its compression says."""
    size = chunk.uncompressed_size
    if chunk.compression == "zstd":
        size = max(size, zstandard.frame_content_size(chunk.data))
    if size > MAX_CHUNK_BYTES:
        raise ValueError(f"it says that it holds {size} bytes")


def _split(inside: bytes) -> _Opened:
    """Introductions and messages of a chunk; at once where all its messages are alike.

    The slow way, for chunks of several channels or lengths: find each message, then gather.
    """
    introduced: list[tuple[int, bytes]] = []
    starts: dict[bytes, list[int]] = {}
    flat = np.frombuffer(inside, dtype=np.uint8)
    at = 0
    while at < len(inside):
        opcode, length = RECORD.unpack_from(inside, at)
        stop = at + RECORD.size + length
        if stop > len(inside):
            raise ValueError("a record is longer than its chunk")
        if opcode != Opcode.MESSAGE:
            introduced.append((opcode, inside[at + RECORD.size : stop]))
        elif not starts and (records := _all_alike(flat[at:], stop - at)) is not None:
            return _Opened(introduced, [_batch(records)])
        else:
            starts.setdefault(inside[at : at + PREFIX], []).append(at)
        at = stop
    batches = []
    for prefix, places in starts.items():
        length = RECORD.size + RECORD.unpack_from(prefix)[1]
        batches.append(_batch(flat[np.array(places)[:, None] + np.arange(length)]))
    return _Opened(introduced, batches)


def _all_alike(flat: np.ndarray, length: int) -> np.ndarray | None:
    """The records (n, length), if all from here on have the length and channel of the first."""
    if len(flat) % length:
        return None
    records = flat.reshape(-1, length)
    return records if (records[:, :PREFIX] == records[0, :PREFIX]).all() else None


def _batch(records: np.ndarray) -> Batch:
    head = records[:, : MESSAGE.itemsize].view(MESSAGE)[:, 0]
    times = head["log_time"].astype(np.int64)
    return Batch(int(head["channel"][0]), times, records[:, MESSAGE.itemsize :])
