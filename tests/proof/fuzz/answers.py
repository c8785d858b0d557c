"""What devices answer: registers, lines of text and Modbus/RTU frames, random and damaged."""

import random
import struct
from dataclasses import dataclass

from pymodbus.exceptions import ModbusException
from pymodbus.framer import FramerRTU
from pymodbus.pdu import DecodePDU

from schemas.base import Unusable
from schemas.described import RegisterType
from tasks.station.drivers.modbus import Order, decode, encode
from tasks.station.drivers.text_device import Answer
from tests.proof.fuzz.damage import OTHER, SHOWN

ORDERS: tuple[Order, ...] = ("big", "little")
WORDS: dict[RegisterType, int] = {"uint16": 1, "int16": 1, "uint32": 2, "int32": 2, "uint64": 4,
         "int64": 4, "float32": 2, "float64": 4}  # fmt: skip
TEMPLATES = ("{angle[0]},{angle[1]},{angle[2]}", "VEL {rate}", "#{status:x}",
             "{maker:w},{model:w},{revision}")  # fmt: skip
SIGNS = "0123456789+-.eExX#,; \tVELOKinfaN"


@dataclass(frozen=True)
class Held:
    """How many inputs, and what was wrong of them."""

    inputs: int
    wrong: int


def registers(count: int, seed: int) -> Held:
    """Random words of each type give a value that gives these words again."""
    rng, wrong = random.Random(seed), 0
    for _ in range(count):
        kind = rng.choice(tuple(WORDS))
        order = rng.choice(ORDERS)
        words = [rng.randrange(2**16) for _ in range(WORDS[kind])]
        value = decode(words, kind, order)
        is_nan = value != value
        wrong += not is_nan and encode(value, kind, order) != words
    return Held(count, wrong)


def values(count: int, seed: int) -> Held:
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
    return Held(count, wrong)


def lines(count: int, seed: int) -> Held:
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
    return Held(count, wrong)


def modbus_rtu(count: int, seed: int) -> Held:
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
    return Held(count, wrong)


def _modbus_crc(data: bytes) -> int:
    crc = 0xFFFF
    for octet in data:
        crc ^= octet
        for _ in range(8):
            crc = (crc >> 1) ^ (0xA001 if crc & 1 else 0)
    return crc


KINDS = {
    "Modbus registers, random words": registers,
    "Modbus registers, random values": values,
    "Modbus/RTU answers": modbus_rtu,
    "lines of a text device": lines,
}
