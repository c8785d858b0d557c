"""Units' frames, made byte by byte, and what a stream of them with damaged ones between gives."""

import random
import struct
from binascii import crc_hqx
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from schemas.unit_link import AnyFrame, BinaryFrame, TextFrame
from tasks.station.drivers.samples import no_samples
from tasks.station.drivers.unit import find_frames
from tests.proof.fuzz.damage import OTHER, SHOWN, Damage

Reading = tuple[float, ...]  # counter, stamp in µs, three rates, three accelerations
BLOCK = 200  # damaged frames in a stream
CHANNELS = tuple(f"{triad}_{axis}" for triad in ("gyro", "accel") for axis in "xyz")


@dataclass(frozen=True)
class Kind:
    """A kind of frame: its description, how one is made of a reading of counts."""

    name: str
    frame: AnyFrame
    made: Callable[[tuple[int, ...]], bytes]


@dataclass
class Tally:
    """What came of damaged frames: wrong readings, and whole frames that were not found.

    wrong_though_shown: of damage that the check sum shows without fail.
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
    rng, tally = random.Random(seed), Tally()
    for start in range(0, count, BLOCK):
        pool = SHOWN if start % (2 * BLOCK) else OTHER
        wrong, lost = _feed_block(kind, min(BLOCK, count - start), pool, rng)
        tally.fed += min(BLOCK, count - start)
        tally.wrong_though_shown += wrong if pool is SHOWN else 0
        tally.wrong_by_chance += wrong if pool is OTHER else 0
        tally.lost += lost
    return tally


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
