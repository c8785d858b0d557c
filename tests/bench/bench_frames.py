"""Frames among bad inputs, a million of each kind: every good one is taken, and no other."""

import struct
import time
from binascii import crc_hqx
from typing import Any

import numpy as np

from schemas.unit_link import UnitLink
from tasks.station.drivers.unit import StampSequence, find_frames
from tests.tasks.station.sample_stations import rates_link, sample

INPUTS = 1_000_000
AT_ONCE = 500  # bad inputs given in one piece, each behind a good frame
MARK = 12345  # counts of the good frames' first channel


def main(inputs: int = INPUTS) -> None:
    """Print for each kind how many bad inputs there were, and what was taken beside the good."""
    text = UnitLink.model_validate(sample("text_table")["unit_link"])
    checked = text.model_dump(mode="json")
    checked["frame"]["check"] = "crc16_xmodem"
    _measure("binary, CRC-16", rates_link(), _binary, _bad_binary, inputs)
    _measure("text, CRC-16", UnitLink.model_validate(checked), _text_crc, _bad_text, inputs)
    _measure("text, XOR", text, _text_xor, _bad_text, inputs)


def _measure(kind: str, link: UnitLink, good: Any, bad: Any, inputs: int) -> None:
    rng, began_s = np.random.default_rng(20261122), time.perf_counter()
    sequence, rest, taken, wrong, mark = StampSequence(link), b"", 0, 0, None
    for start in range(0, inputs, AT_ONCE):
        numbers = range(start, min(start + AT_ONCE, inputs))
        data = b"".join(good(number) + bad(rng, good(number)) for number in numbers)
        found = find_frames(rest + data, link.frame)
        rest = found.rest
        samples = sequence.take(found.samples, time.perf_counter())
        mark = samples["values"][0, 0] if mark is None else mark
        is_good = samples["values"][:, 0] == mark
        taken, wrong = taken + int(is_good.sum()), wrong + int((~is_good).sum())
    seconds = time.perf_counter() - began_s
    print(f"frames   {kind}: {inputs} bad inputs, {wrong} taken for frames; {taken} of {inputs} "
          f"good ones taken, {sequence.rejected} rejected dropped, {seconds:.0f} s")  # fmt: skip


def _binary(number: int) -> bytes:
    body = struct.pack("<HIQ3i3ih", 0x55AA, number, number * 10_000, MARK, 2, 3, 4, 5, 6, 2512)
    return body + struct.pack("<H", crc_hqx(body, 0))


def _bad_binary(rng: np.random.Generator, good: bytes) -> bytes:
    """What begins like a frame and has its length."""
    return good[:2] + rng.bytes(len(good) - 2)


def _body(number: int) -> bytes:
    return f"VNIMU,+1.0,-0.2,{number},{MARK},2,-9.8,+0.1,+0.2,+0.3,+21.5,+101.2".encode()


def _text_crc(number: int) -> bytes:
    return b"$%s*%04X\r\n" % (_body(number), crc_hqx(_body(number), 0))


def _text_xor(number: int) -> bytes:
    check = int(np.bitwise_xor.reduce(np.frombuffer(_body(number), np.uint8)))
    return b"$%s*%02X\r\n" % (_body(number), check)


def _bad_text(rng: np.random.Generator, good: bytes) -> bytes:
    """A line in which one to four octets, the mark's first among them, are others."""
    broken = bytearray(good)
    mark = good.index(str(MARK).encode())
    for place in {mark, *rng.integers(0, len(good) - 2, rng.integers(0, 4)).tolist()}:
        broken[place] = (broken[place] + int(rng.integers(1, 256))) % 256
    return bytes(broken)


if __name__ == "__main__":
    main()
