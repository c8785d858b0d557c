"""The unit's frames: found in a stream of bytes, checked, and turned into SI."""

from binascii import crc_hqx
from dataclasses import dataclass

import numpy as np

from schemas.recording import Stream
from schemas.station import FRAMES, TRIADS, AnyLink, Frame

COUNTER_TURN = 2**32
_CRC_OF_BYTE = np.array([crc_hqx(bytes([byte]), 0) for byte in range(256)], dtype=np.uint16)


def record(frame: Frame) -> np.dtype:
    """The frame as a numpy record, with a field for each triad's counts."""
    triads = [(name, "<i4" if code == "i" else "<i8", 3) for name, code in frame.triads]
    head = [("sync", "<u2"), ("counter", "<u4"), ("stamp", "<u8")]
    return np.dtype([*head, *triads, ("temperature", "<i2"), ("crc", "<u2")])


RECORDS = {kind: record(frame) for kind, frame in FRAMES.items()}


@dataclass(frozen=True)
class FrameSearch:
    """Frames found in some bytes: records (n,), how many were bad, and bytes left over."""

    frames: np.ndarray
    bad: int
    rest: bytes


def find_frames(data: bytes, kind: str) -> FrameSearch:
    """Every frame of a kind of FRAMES with a right check sum, wherever it starts.

    `rest` goes before the next bytes.

    A stretch of a frame's length that begins with the sync word, has a wrong check sum and
    touches no good frame counts as a bad one. The search goes on at the next byte, so that
    garbage costs no frame whose own bytes are intact.
    """
    size = FRAMES[kind].size
    if len(data) < size:
        return FrameSearch(np.empty(0, RECORDS[kind]), 0, data)
    octets = np.frombuffer(data, np.uint8)
    starts = _sync_places(octets, FRAMES[kind])
    rows = np.lib.stride_tricks.sliding_window_view(octets, size)[starts]
    good = crc16(rows[:, :-2]) == rows[:, -2:].copy().view("<u2")[:, 0]
    taken = _without_overlap(starts[good], size)
    frames = octets[taken[:, None] + np.arange(size)].view(RECORDS[kind])[:, 0]
    end = int(taken[-1]) + size if len(taken) else 0
    # two frames long, so that what a bad one touches is known when it is counted
    rest_from = max(end, len(data) - 2 * size + 1, 0)
    bad = _apart(starts[~good & (starts < rest_from)], taken, size)
    return FrameSearch(frames, bad, data[rest_from:])


def crc16(rows: np.ndarray) -> np.ndarray:
    """CRC-16/XMODEM of each row of octets, (n, k) -> (n,) uint16; binascii.crc_hqx, start 0."""
    crc = np.zeros(len(rows), np.uint16)
    for column in rows.T:
        crc = (crc << np.uint16(8)) ^ _CRC_OF_BYTE[(crc >> np.uint16(8)) ^ column]
    return crc


def lost_between(counters: np.ndarray) -> np.ndarray:
    """Frames missing between neighbours, (n,) -> (n - 1,); the counter wraps at 2^32."""
    return np.mod(np.diff(counters.astype(np.int64)) - 1, COUNTER_TURN)


def to_stream(frames: np.ndarray, link: AnyLink, shift_us: int = 0) -> Stream:
    """Frames in SI units and °C over their own time stamps, moved by `shift_us`."""
    triads = [name for name, _ in FRAMES[link.frame].triads]
    columns = {
        column: frames[triad][:, place] * link.counts[column]
        for triad in triads
        for place, column in enumerate(TRIADS[triad])
    }
    columns["temperature"] = frames["temperature"] / 100.0
    return Stream((frames["stamp"].astype(np.int64) + shift_us) / 1e6, columns)


def _sync_places(octets: np.ndarray, frame: Frame) -> np.ndarray:
    low, high = frame.sync & 0xFF, frame.sync >> 8
    last = len(octets) - frame.size + 1
    return np.flatnonzero((octets[:last] == low) & (octets[1 : last + 1] == high))


def _without_overlap(starts: np.ndarray, size: int) -> np.ndarray:
    """Of good frames that overlap, the first: the other is a chance inside it."""
    if np.all(np.diff(starts) >= size):
        return starts
    taken: list[int] = []
    for start in starts:
        if not taken or start >= taken[-1] + size:
            taken.append(int(start))
    return np.array(taken, dtype=starts.dtype)


def _apart(places: np.ndarray, taken: np.ndarray, size: int) -> int:
    """How many of the places are a frame's length or more from every frame taken."""
    apart = np.abs(places[:, None] - taken).min(axis=1, initial=size)
    return int(np.count_nonzero(apart >= size))
