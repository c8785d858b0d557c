"""Frames of the unit, binary or lines of text: found in a byte stream, checked and decoded."""

import re
from binascii import crc32, crc_hqx
from collections.abc import Callable
from functools import lru_cache, reduce
from operator import xor

import numpy as np
from pymodbus.framer import FramerRTU

from schemas.unit_link import CHECK_BYTES, SIZES, BinaryField, BinaryFrame, Check, TextFrame
from tasks.station.drivers.samples import FrameSearch, filled, no_samples

# of each number there is one way to read it: a damaged line must not be tried for ever
NUMBER = rb"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?"
MOST_BYTES = 4096  # of a line; what is longer is no line
CHECK_DIGITS = {"xor8": 2, "crc16_xmodem": 4}


def find_binary(data: bytes, frame: BinaryFrame) -> FrameSearch:
    """Every frame with a correct checksum, wherever it starts.

    `rest` goes before the next bytes. Bytes of a frame's length that begin with the sync bytes,
    have a wrong checksum and overlap no good frame count as a bad frame. The search continues at
    the next byte, so that garbage costs no frame whose own bytes are intact.
    """
    size = frame.size
    if len(data) < size:
        return FrameSearch(no_samples(frame), 0, data)
    octets = np.frombuffer(data, np.uint8)
    starts = _sync_places(octets, frame)
    rows = np.lib.stride_tricks.sliding_window_view(octets, size)[starts]
    good = _is_good(rows, frame)
    taken = _without_overlap(starts[good], size)
    samples = _read(octets[taken[:, None] + np.arange(size)], frame)
    end = int(taken[-1]) + size if len(taken) else 0
    # two frames long, so that what a bad one touches is known when it is counted
    rest_from = max(end, len(data) - 2 * size + 1, 0)
    bad = _apart(starts[~good & (starts < rest_from)], taken, size)
    return FrameSearch(samples, bad, data[rest_from:])


def _is_good(rows: np.ndarray, frame: BinaryFrame) -> np.ndarray:
    width = CHECK_BYTES[frame.check]
    stated = np.zeros(len(rows), np.uint64)
    order = frame.check_byte_order or frame.byte_order
    places = range(width) if order == "big" else reversed(range(width))
    for place in places:
        stated = (stated << np.uint64(8)) | rows[:, rows.shape[1] - width + place]
    return np.asarray(check_sums(frame.check, rows[:, frame.check_from : -width]) == stated)


def _read(rows: np.ndarray, frame: BinaryFrame) -> np.ndarray:
    """Samples (n,) of rows of octets, (n, size)."""
    raw, start = {}, len(frame.sync_bytes)
    for field in frame.fields:
        end = start + SIZES[field.type]
        octets = np.ascontiguousarray(rows[:, start:end])
        raw[field.name] = octets.view(_type(field, frame))[:, 0]
        start = end
    return filled(frame, raw, len(rows))


def _type(field: BinaryField, frame: BinaryFrame) -> np.dtype:
    return np.dtype(field.type).newbyteorder("<" if frame.byte_order == "little" else ">")


def _sync_places(octets: np.ndarray, frame: BinaryFrame) -> np.ndarray:
    last = len(octets) - frame.size + 1
    is_sync = np.ones(last, bool)
    for place, octet in enumerate(frame.sync_bytes):
        is_sync &= octets[place : last + place] == octet
    return np.flatnonzero(is_sync)


def _without_overlap(starts: np.ndarray, size: int) -> np.ndarray:
    """Of good frames that overlap, the last: one whose end was lost may run into it by chance."""
    if np.all(np.diff(starts) >= size):
        return starts
    taken: list[int] = []
    for start in reversed(starts.tolist()):
        if not taken or start + size <= taken[-1]:
            taken.append(start)
    return np.array(taken[::-1], dtype=starts.dtype)


def _apart(places: np.ndarray, taken: np.ndarray, size: int) -> int:
    """How many of the places are a frame's length or more from every frame taken."""
    apart = np.abs(places[:, None] - taken).min(axis=1, initial=size)
    return int(np.count_nonzero(apart >= size))


def check_sums(kind: Check, rows: np.ndarray) -> np.ndarray:
    """The check sum of each row of octets, (n, k) -> (n,) uint64."""
    return np.array([CHECKS[kind](row.tobytes()) for row in rows], np.uint64)


def _crc16_modbus(octets: bytes) -> int:
    low_first = FramerRTU.compute_CRC(octets)
    return low_first >> 8 | (low_first & 0xFF) << 8


CHECKS: dict[str, Callable[[bytes], int]] = {
    "sum8": lambda octets: sum(octets) & 0xFF,
    "xor8": lambda octets: reduce(xor, octets, 0),
    "crc16_xmodem": lambda octets: crc_hqx(octets, 0),
    "crc16_ccitt_false": lambda octets: crc_hqx(octets, 0xFFFF),
    "crc16_modbus": _crc16_modbus,
    "crc32": crc32,
}


def find_text(data: bytes, frame: TextFrame) -> FrameSearch:
    """Every whole line that matches the frame and has a correct checksum.

    `rest` goes before the next bytes. If frames have no checksum, a line counts only after the end
    of another: the beginning of the first one may be missing.
    """
    end = frame.terminator.encode()
    *lines, rest = data.split(end)
    found: list[tuple[float, ...]] = []
    bad = 0
    for place, line in enumerate(lines):
        values = _values(line, frame)
        is_whole = frame.check != "none" or place > 0
        if values is not None and is_whole:
            found.append(values)
        elif (is_whole and frame.start and frame.start.encode() in line) or (
            is_whole and not frame.start and line
        ):
            bad += 1
    if frame.check == "none" and lines:
        rest = end + rest
    return FrameSearch(_samples(found, frame), bad, rest[-MOST_BYTES:])


def _samples(found: list[tuple[float, ...]], frame: TextFrame) -> np.ndarray:
    if not found:
        return no_samples(frame)
    columns = np.array(found).T
    raw = {field.name: column for field, column in zip(frame.fields, columns, strict=True)}
    return filled(frame, raw, len(found))


def _values(line: bytes, frame: TextFrame) -> tuple[float, ...] | None:
    """The numbers of a line, None where it is no good frame; what is before it does not count."""
    if frame.start:
        begin = line.rfind(frame.start.encode())
        if begin < 0:
            return None
        line = line[begin:]
    match = _pattern(frame).fullmatch(line)
    if match is None:
        return None
    *texts, stated = match.groups() if frame.check != "none" else (*match.groups(), b"")
    if frame.check != "none" and int(stated, 16) != _check(line, frame):
        return None
    values = tuple(map(float, texts))
    return values if np.isfinite(values).all() else None


def _check(line: bytes, frame: TextFrame) -> int:
    return CHECKS[frame.check](line[line[:1] in (b"$", b"!") : line.rindex(b"*")])


@lru_cache
def _pattern(frame: TextFrame) -> re.Pattern[bytes]:
    blank = frame.separator == " "
    separator = b" +" if blank else b" *" + re.escape(frame.separator.encode()) + b" *"
    fields = separator.join(
        re.escape(field.prefix.encode()) + rb"(" + NUMBER + rb")" for field in frame.fields
    )
    check = b""
    if frame.check != "none":
        check = rb"\*([0-9a-fA-F]{%d})" % CHECK_DIGITS[frame.check]
    start = re.escape(frame.start.encode())
    return re.compile(start + b" *" + fields + b" *" + check + rb"\r?")
