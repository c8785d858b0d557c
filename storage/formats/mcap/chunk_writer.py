"""Writes an MCAP file: chunks of messages of equal length, then the summary.

The mcap package writes message by message; here a whole block of messages becomes one chunk,
and one chunk holds one channel, so that a reader can take it apart as an array.
"""

import os
import struct
import zlib
from collections.abc import Callable, Mapping
from typing import BinaryIO

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
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

from storage.formats.mcap.definitions import schema_text

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

    def messages(self, topic: str, kind: str, stamps: np.ndarray, block: np.ndarray) -> None:
        """Writes messages in one chunk or more.

        stamps: (n,) int64 ns, not negative; block: (n, length) uint8, one message a row.
        """
        rows = max(1, CHUNK // (block.shape[1] + MESSAGE.itemsize))
        for start in range(0, len(block), rows):
            part = slice(start, start + rows)
            self._chunk(topic, kind, stamps[part], block[part])

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

    def _chunk(self, topic: str, kind: str, stamps: np.ndarray, block: np.ndarray) -> None:
        head = b"" if topic in self._channels else self._register(topic, kind)
        channel = self._channels[topic].id
        data = head + self._records(channel, stamps, block).tobytes()
        packed = self._compress(data)
        first, last = int(stamps.min()), int(stamps.max())
        chunk = _bytes(Chunk("zstd", packed, last, first, zlib.crc32(data), len(data)))
        stride = MESSAGE.itemsize + block.shape[1]
        offsets = len(head) + stride * np.arange(len(stamps), dtype=np.uint64)
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
        """The records that introduce a new channel, for the head of its first chunk."""
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
