"""Frames as lines of text: found in a byte stream, checked and decoded."""

import re
from binascii import crc_hqx
from functools import lru_cache, reduce
from operator import xor

import numpy as np

from schemas.unit_link import TextFrame
from tasks.station.drivers.samples import FrameSearch, filled, no_samples

# of each number there is one way to read it: a damaged line must not be tried for ever
NUMBER = rb"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?"
MOST_BYTES = 4096  # of a line; what is longer is no line
CHECK_DIGITS = {"xor8": 2, "crc16_xmodem": 4}


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
    body = line[line[:1] in (b"$", b"!") : line.rindex(b"*")]
    return reduce(xor, body, 0) if frame.check == "xor8" else crc_hqx(body, 0)


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
