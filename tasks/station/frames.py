"""The unit's frames: found in a stream of bytes, checked, and turned into SI."""

from binascii import crc_hqx
from dataclasses import dataclass

import numpy as np

from schemas.recording import ACCEL, GYRO, Stream
from schemas.station import FRAME_BYTES, FRAME_SYNC, UnitLink

FRAME = np.dtype(
    [
        ("sync", "<u2"),
        ("counter", "<u4"),
        ("stamp", "<u8"),
        ("gyro", "<i4", 3),
        ("accel", "<i4", 3),
        ("temperature", "<i2"),
        ("crc", "<u2"),
    ]
)
COUNTER_TURN = 2**32
_CRC_OF_BYTE = np.array([crc_hqx(bytes([byte]), 0) for byte in range(256)], dtype=np.uint16)


@dataclass(frozen=True)
class Found:
    """Frames found in some bytes: FRAME records (n,), how many were bad, and bytes left over."""

    frames: np.ndarray
    bad: int
    rest: bytes


def find_frames(data: bytes) -> Found:
    """Every frame with a right check sum, wherever it starts; `rest` goes before the next bytes.

    A stretch of a frame's length that begins with the sync word, has a wrong check sum and
    touches no good frame counts as a bad one. The search goes on at the next byte, so that
    garbage costs no frame whose own bytes are intact.
    """
    if len(data) < FRAME_BYTES:
        return Found(np.empty(0, FRAME), 0, data)
    octets = np.frombuffer(data, np.uint8)
    starts = _sync_places(octets)
    rows = np.lib.stride_tricks.sliding_window_view(octets, FRAME_BYTES)[starts]
    good = crc16(rows[:, :-2]) == rows[:, -2:].copy().view("<u2")[:, 0]
    taken = _without_overlap(starts[good])
    frames = octets[taken[:, None] + np.arange(FRAME_BYTES)].view(FRAME)[:, 0]
    end = int(taken[-1]) + FRAME_BYTES if len(taken) else 0
    # two frames long, so that what a bad one touches is known when it is counted
    rest_from = max(end, len(data) - 2 * FRAME_BYTES + 1, 0)
    bad = _apart(starts[~good & (starts < rest_from)], taken)
    return Found(frames, bad, data[rest_from:])


def crc16(rows: np.ndarray) -> np.ndarray:
    """CRC-16/XMODEM of each row of octets, (n, k) -> (n,) uint16; binascii.crc_hqx, start 0."""
    crc = np.zeros(len(rows), np.uint16)
    for column in rows.T:
        crc = (crc << np.uint16(8)) ^ _CRC_OF_BYTE[(crc >> np.uint16(8)) ^ column]
    return crc


def lost_between(counters: np.ndarray) -> np.ndarray:
    """Frames missing between neighbours, (n,) -> (n - 1,); the counter wraps at 2^32."""
    return np.mod(np.diff(counters.astype(np.int64)) - 1, COUNTER_TURN)


def to_stream(frames: np.ndarray, link: UnitLink, shift_us: int = 0) -> Stream:
    """Frames as rad/s, m/s² and °C over their own time stamps, moved by `shift_us`."""
    gyro = frames["gyro"] * link.gyro_lsb_rad_s
    accel = frames["accel"] * link.accel_lsb_m_s2
    columns = dict(zip(GYRO + ACCEL, np.column_stack([gyro, accel]).T, strict=True))
    columns["temperature"] = frames["temperature"] / 100.0
    return Stream((frames["stamp"].astype(np.int64) + shift_us) / 1e6, columns)


def _sync_places(octets: np.ndarray) -> np.ndarray:
    low, high = FRAME_SYNC & 0xFF, FRAME_SYNC >> 8
    last = len(octets) - FRAME_BYTES + 1
    return np.flatnonzero((octets[:last] == low) & (octets[1 : last + 1] == high))


def _without_overlap(starts: np.ndarray) -> np.ndarray:
    """Of good frames that overlap, the first: the other is a chance inside it."""
    if np.all(np.diff(starts) >= FRAME_BYTES):
        return starts
    taken: list[int] = []
    for start in starts:
        if not taken or start >= taken[-1] + FRAME_BYTES:
            taken.append(int(start))
    return np.array(taken, dtype=starts.dtype)


def _apart(places: np.ndarray, taken: np.ndarray) -> int:
    """How many of the places are a frame's length or more from every frame taken."""
    if not len(taken):
        return len(places)
    after = np.searchsorted(taken, places)
    nearest = np.minimum(
        np.abs(places - taken[np.maximum(after - 1, 0)]),
        np.abs(places - taken[np.minimum(after, len(taken) - 1)]),
    )
    return int(np.count_nonzero(nearest >= FRAME_BYTES))
