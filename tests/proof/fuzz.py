"""Damaged inputs for the parsers of what units and tables send."""

import random
import re
import struct
import time
from binascii import crc_hqx
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from pymodbus.exceptions import ModbusException
from pymodbus.framer import FramerRTU
from pymodbus.pdu import DecodePDU

from schemas.base import Unusable
from schemas.described import RegisterType
from schemas.unit_link import AnyFrame, BinaryFrame, TextFrame
from tasks.station.drivers.modbus import Order, decode, encode
from tasks.station.drivers.text_device import Answer
from tasks.station.drivers.unit import find_frames, no_samples
from tests.proof.study import Count, Out, Seed, Write, hold, line

Damage = Callable[[bytes, random.Random], bytes]
BURST_BITS = 8


def bit(frame: bytes, rng: random.Random) -> bytes:
    """One bit is wrong."""
    place = rng.randrange(8 * len(frame))
    return _flipped(frame, place, 1)


def burst(frame: bytes, rng: random.Random) -> bytes:
    """Some of BURST_BITS neighbouring bits are wrong, the first of them surely."""
    place = rng.randrange(8 * len(frame) - BURST_BITS)
    return _flipped(frame, place, rng.randrange(2 ** (BURST_BITS - 1)) * 2 + 1)


def lost_beginning(frame: bytes, rng: random.Random) -> bytes:
    """Its first bytes are lost."""
    return frame[rng.randrange(1, len(frame)) :]


def lost_end(frame: bytes, rng: random.Random) -> bytes:
    """Its last bytes are lost: it runs into the next."""
    return frame[: rng.randrange(1, len(frame))]


def lost_inside(frame: bytes, rng: random.Random) -> bytes:
    """One to four bytes inside are lost."""
    place, count = rng.randrange(1, len(frame) - 1), rng.randrange(1, 5)
    return frame[:place] + frame[place + count :]


def more_inside(frame: bytes, rng: random.Random) -> bytes:
    """One to four bytes too many."""
    place = rng.randrange(1, len(frame) - 1)
    return frame[:place] + rng.randbytes(rng.randrange(1, 5)) + frame[place:]


def noise_inside(frame: bytes, rng: random.Random) -> bytes:
    """Random bytes in the place of some."""
    start = rng.randrange(len(frame) - 1)
    end = rng.randrange(start + 1, len(frame))
    return frame[:start] + rng.randbytes(end - start) + frame[end:]


def noise(frame: bytes, rng: random.Random) -> bytes:
    """Random bytes that begin as a frame does."""
    return frame[:2] + rng.randbytes(rng.randrange(1, 2 * len(frame)))


def _flipped(frame: bytes, place: int, pattern: int) -> bytes:
    whole = int.from_bytes(frame, "little") ^ (pattern << place)
    return whole.to_bytes(len(frame), "little")


# one run of wrong bits, no longer than it, which every check sum of so many bits shows
SHOWN: tuple[Damage, ...] = (bit, burst)
OTHER: tuple[Damage, ...] = (
    lost_beginning, lost_end, lost_inside, more_inside, noise_inside, noise
)  # fmt: skip


# Units' frames, made byte by byte, and what a stream of them with damaged ones between gives.

Reading = tuple[float, ...]  # counter, stamp in µs, three rates, three accelerations
BLOCK = 200  # damaged frames in a stream
CHANNELS = tuple(f"{triad}_{axis}" for triad in ("gyro", "accel") for axis in "xyz")


@dataclass(frozen=True)
class Kind:
    """A kind of frame: its description, how one is made of a reading of counts."""

    name: str
    frame: AnyFrame
    made: Callable[[tuple[int, ...]], bytes]


@dataclass(frozen=True)
class Tally:
    """What came of so many inputs that were fed: wrong readings, and whole frames not found.

    wrong_though_shown: of damage that shows without fail; by_chance: of other damage to a frame.
    """

    fed: int = 0
    wrong_though_shown: int = 0
    wrong_by_chance: int = 0
    lost: int = 0


def _binary(order: str) -> Kind:
    sign, sync = ("<", b"\xaa\x55") if order == "little" else (">", b"\xfa\xce")
    fields = [("counter", "uint32"), ("time", "uint32"), *((name, "int32") for name in CHANNELS)]
    described = BinaryFrame.model_validate({
        "kind": "binary", "sync": sync.hex(), "byte_order": order, "check": "crc16_xmodem",
        "fields": [
            {"name": name, "type": kind, "unit": "us" if name == "time" else "1"}
            for name, kind in fields
        ],
    })  # fmt: skip

    def made(reading: tuple[int, ...]) -> bytes:
        body = sync + struct.pack(f"{sign}2I6i", *reading)
        return body + struct.pack(f"{sign}H", crc_hqx(body, 0))

    return Kind(f"binary, {order}-endian, CRC-16", described, made)


def _text(check: str) -> Kind:
    described = TextFrame.model_validate({
        "kind": "text", "start": "$IMU,", "terminator": "\r\n", "check": check,
        "fields": [
            {"name": "counter"}, {"name": "time", "unit": "us"},
            *({"name": name} for name in CHANNELS),
        ],
    })  # fmt: skip

    def made(reading: tuple[int, ...]) -> bytes:
        body = b"IMU," + b",".join(b"%d" % each for each in reading)
        if check == "crc16_xmodem":
            return b"$%b*%04X\r\n" % (body, crc_hqx(body, 0))
        total = 0
        for octet in body:
            total ^= octet
        return b"$%b*%02X\r\n" % (body, total)

    return Kind(f"text, {check}", described, made)


KINDS = (_binary("little"), _binary("big"), _text("crc16_xmodem"), _text("xor8"))


def feed(kind: Kind, count: int, seed: int) -> Tally:
    """Streams in which a whole frame stands before and behind each of `count` damaged ones."""
    rng, wrong, lost = random.Random(seed), {SHOWN: 0, OTHER: 0}, 0
    for start in range(0, count, BLOCK):
        pool = SHOWN if start % (2 * BLOCK) else OTHER
        taken, gone = _feed_block(kind, min(BLOCK, count - start), pool, rng)
        wrong[pool], lost = wrong[pool] + taken, lost + gone
    return Tally(count, wrong[SHOWN], wrong[OTHER], lost)


def _feed_block(
    kind: Kind, count: int, pool: tuple[Damage, ...], rng: random.Random
) -> tuple[int, int]:
    """How many readings were wrong, and how many whole frames were lost."""
    stream, whole, may_be = [], set(), set()
    for number in range(count):
        good, other = _reading(rng, 2 * number), _reading(rng, 2 * number + 1)
        may_be.add(other)  # where the damage is in what tells nothing, as the case of a digit
        stream += [kind.made(good), rng.choice(pool)(kind.made(other), rng)]
        whole.add(good)
    stream.append(kind.made(end := _reading(rng, 2 * count)))
    whole.add(end)
    found = set(_found(kind, b"".join(stream) + bytes(4096), rng))
    return len(found - whole - may_be), len(whole - found)


def _reading(rng: random.Random, number: int) -> tuple[int, ...]:
    return (number, 10_000 * number, *(rng.randrange(-(2**31), 2**31) for _ in CHANNELS))


def _found(kind: Kind, data: bytes, rng: random.Random) -> Iterator[Reading]:
    """The readings in a stream that comes in three pieces."""
    cuts = sorted(rng.randrange(len(data)) for _ in range(2))
    rest, samples = b"", [no_samples(kind.frame)]
    for begin, end in zip((0, *cuts), (*cuts, len(data)), strict=True):
        search = find_frames(rest + data[begin:end], kind.frame)
        rest = search.rest
        samples.append(search.samples)
    for sample in np.concatenate(samples):
        yield (int(sample["counter"]), int(sample["stamp"]), *sample["values"].tolist())


# What devices answer: registers, lines of text and Modbus/RTU frames, random and damaged.

ORDERS: tuple[Order, ...] = ("big", "little")
WORDS: dict[RegisterType, int] = {"uint16": 1, "int16": 1, "uint32": 2, "int32": 2, "uint64": 4,
         "int64": 4, "float32": 2, "float64": 4}  # fmt: skip
TEMPLATES = ("{angle[0]},{angle[1]},{angle[2]}", "VEL {rate}", "#{status:x}",
             "{maker:w},{model:w},{revision}")  # fmt: skip
SIGNS = "0123456789+-.eExX#,; \tVELOKinfaN"


def registers(count: int, seed: int) -> Tally:
    """Random words of each type give a value that gives these words again."""
    rng, wrong = random.Random(seed), 0
    for _ in range(count):
        kind = rng.choice(tuple(WORDS))
        order = rng.choice(ORDERS)
        words = [rng.randrange(2**16) for _ in range(WORDS[kind])]
        value = decode(words, kind, order)
        is_nan = value != value
        wrong += not is_nan and encode(value, kind, order) != words
    return Tally(count, wrong)


def values(count: int, seed: int) -> Tally:
    """Random values are encoded so that they come back, or refused as too large."""
    rng, wrong = random.Random(seed), 0
    for _ in range(count):
        kind = rng.choice(tuple(WORDS))
        value = rng.choice((-1, 1)) * 2.0 ** rng.uniform(-10, 70)
        try:
            back = decode(encode(value, kind, "little"), kind, "little")
        except Unusable:
            wrong += abs(value) < 2**15 and not kind.startswith("u")
            continue
        wrong += abs(back - value) > max(0.5, abs(value) * 2.0**-23)
    return Tally(count, wrong)


def lines(count: int, seed: int) -> Tally:
    """Lines that look like an answer, or hardly: numbers, or that it is none."""
    rng, wrong = random.Random(seed), 0
    answers = [Answer(template) for template in TEMPLATES]
    for _ in range(count):
        answer = rng.choice(answers)
        numbers = [rng.uniform(-400.0, 400.0) for _ in range(3)]
        line = ",".join(f"{each:.4f}" for each in numbers)
        if is_damaged := rng.random() < 0.9:
            for _ in range(rng.randrange(1, 6)):
                place = rng.randrange(len(line) + 1)
                line = line[:place] + rng.choice(SIGNS) + line[place + rng.randrange(2) :]
        found = answer.values(line)
        if not is_damaged and answer is answers[0]:
            right = {("angle", axis): float(f"{each:.4f}") for axis, each in enumerate(numbers)}
            wrong += found != right
    return Tally(count, wrong)


def modbus_rtu(count: int, seed: int) -> Tally:
    """Damaged answers over a serial line are refused; damage that a CRC shows is never taken."""
    rng, wrong = random.Random(seed), 0
    shown = {damage.__name__ for damage in SHOWN}
    for _ in range(count):
        words = [rng.randrange(2**16) for _ in range(6)]
        body = struct.pack(">3B6H", 7, 3, 12, *words)
        whole = body + struct.pack("<H", _modbus_crc(body))
        damage = rng.choice(SHOWN + OTHER)
        try:
            _, answer = FramerRTU(DecodePDU(False)).handleFrame(damage(whole, rng), 7, 0)
        except ModbusException:
            continue
        if answer is not None and damage.__name__ in shown:
            wrong += getattr(answer, "registers", words) != words
    return Tally(count, wrong)


def _modbus_crc(data: bytes) -> int:
    crc = 0xFFFF
    for octet in data:
        crc ^= octet
        for _ in range(8):
            crc = (crc >> 1) ^ (0xA001 if crc & 1 else 0)
    return crc


ANSWERS = {
    "Modbus registers, random words": registers,
    "Modbus registers, random values": values,
    "Modbus/RTU answers": modbus_rtu,
    "lines of a text device": lines,
}


# Every parser with so many inputs, and the page of it.

TEXT = """# Fuzzed parsers

`make prove ARGS="fuzz {count} --seed {seed}"`: {count:,} inputs for each parser, no crash.

Frames of a unit are damaged between whole ones: a bit, a burst of wrong bits, bytes that are lost,
too many or random, ends that run into the next frame, noise that begins as a frame does. Where the
damage is one run of wrong bits the check sum shows it, and no such frame may be taken. Of other
damage a check sum of n bits takes one in 2ⁿ, and no parser can know: these are counted. An `xor8`
of text lets more through: two equal characters that are lost leave it as it was. A unit that can
send a CRC should; a reading that is far off is found by the checks of its segment.

| parser | inputs | s (CPU) | wrong though shown | wrong of other damage | whole frames lost |
|---|---:|---:|---:|---:|---:|
{rows}
"""


PARSERS: dict[str, Callable[[int, int], Tally]] = {
    **{kind.name: partial(feed, kind) for kind in KINDS}, **ANSWERS,
}  # fmt: skip


def fuzz(count: Count = 1_000_000, seed: Seed = 1, out: Out = None, write: Write = False) -> None:
    """Damaged inputs for every parser."""
    work = {f"{seed}-{count}-{re.sub(r'[^a-z0-9]+', '-', one)}": one for one in PARSERS}
    hold("fuzz", work, partial(_fed, count=count, seed=seed), partial(_page, count, seed), out,
         write=write, faults=lambda one: [one[0]] if one[1].wrong_though_shown else [])  # fmt: skip


def _fed(parser: str, count: int, seed: int) -> tuple[str, Tally, float]:
    """What came of one parser, and its processor time (s). Whatever it raises ends it."""
    began = time.process_time()
    return parser, PARSERS[parser](count, seed), time.process_time() - began


def _page(count: int, seed: int, found: Sequence[tuple[str, Tally, float]]) -> str:
    rows = (
        line((parser, f"{each.fed:,}", f"{seconds:.0f}", each.wrong_though_shown,
              each.wrong_by_chance, each.lost))
        for parser, each, seconds in found
    )  # fmt: skip
    return TEXT.format(count=count, seed=seed, rows="\n".join(rows))
