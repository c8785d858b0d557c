"""ROS 2 messages as bytes: CDR for the few message types that a recording uses.

OMG CDR as ROS 2 puts it on the wire (DDS-XTypes, encoding version 1): four bytes that name the
byte order, then the fields one after the other, each aligned to its size (8 at most) from
there. Many messages of one layout are coded at once, as the rows of a (n, length) array.
"""

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from storage.formats.mcap.definitions import FIELDS, SEQUENCE

ORIGIN = 4  # alignment counts from behind the four bytes that name the byte order
Texts = Mapping[str, tuple[str, ...]]


class MalformedError(ValueError):
    """Bytes that are not a message of the type of their channel."""


@dataclass(frozen=True)
class Layout:
    """Where the fields of a message lie.

    numbers: a structured dtype as long as the message, one (count,) entry for each number field.
    texts: the text fields, which are the same in every message of this layout.
    fixed: the bytes that decide the layout: byte order, lengths and texts.
    """

    numbers: np.dtype
    texts: Texts
    fixed: tuple[slice, ...]


def layout(kind: str, message: bytes) -> Layout:
    """The layout of one message; raises MalformedError when it ends before its last field."""
    try:
        return _walk(kind, message)
    except (struct.error, UnicodeDecodeError) as error:
        raise MalformedError(f"not a {kind} in CDR") from error


def _walk(kind: str, message: bytes) -> Layout:
    orders = {b"\0\0": ">", b"\0\1": "<"}
    if message[:2] not in orders:
        raise MalformedError(
            f"an encapsulation {message[:2].hex() or 'of no bytes'} that is not CDR"
        )
    order = orders[message[:2]]
    at = ORIGIN
    texts: dict[str, tuple[str, ...]] = {}
    numbers: dict[str, tuple[str, tuple[int], int]] = {}
    fixed = [slice(0, ORIGIN)]
    for name, code, count in FIELDS[kind]:
        start = at
        if count == SEQUENCE:
            count, at = _word(order, message, at)
        if code == "text":
            texts[name], at = _texts(order, message, at, count)
            fixed.append(slice(start, at))
            continue
        fixed.append(slice(start, at))
        size = int(code[1])
        if count:
            at = _aligned(at, size)
            numbers[name] = (order + code, (count,), at)
        at += count * size
        if at > len(message):
            raise MalformedError(f"a {kind} that ends before its field {name}")
    dtype = np.dtype(
        {
            "names": list(numbers),
            "formats": [(code, shape) for code, shape, _ in numbers.values()],
            "offsets": [offset for _, _, offset in numbers.values()],
            "itemsize": len(message),
        }
    )
    return Layout(dtype, texts, tuple(part for part in fixed if part.start < part.stop))


def _aligned(at: int, size: int) -> int:
    return at + (ORIGIN - at) % size


def _word(order: str, message: bytes, at: int) -> tuple[int, int]:
    at = _aligned(at, 4)
    return struct.unpack_from(order + "I", message, at)[0], at + 4


def _texts(order: str, message: bytes, at: int, count: int) -> tuple[tuple[str, ...], int]:
    texts = []
    for _ in range(count):
        length, at = _word(order, message, at)
        if at + length > len(message):
            raise MalformedError("a text that is longer than its message")
        texts.append(message[at : at + max(length - 1, 0)].decode())
        at += length
    return tuple(texts), at


def decode(kind: str, block: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, Texts]]:
    """The messages in `block`, (n, length) uint8, by layout.

    Yields (rows, numbers, texts): row numbers (k,), a structured view (k,) whose fields are
    (k, count) arrays, and the texts these messages share. Messages of one sender have one
    layout, so that this nearly always yields once, and copies nothing.
    """
    rest = np.arange(len(block))
    while len(rest):
        form = layout(kind, block[rest[0]].tobytes())
        part = block if len(rest) == len(block) else block[rest]
        alike = np.ones(len(part), dtype=bool)
        for fixed in form.fixed:
            whole = part[:, fixed].view(f"S{fixed.stop - fixed.start}")[:, 0]
            alike &= whole == whole[0]
        if not alike.all():
            part = part[alike]
        yield rest[alike], part.view(form.numbers)[:, 0], form.texts
        rest = rest[~alike]


def encode(kind: str, numbers: Mapping[str, np.ndarray], texts: Texts) -> np.ndarray:
    """Messages as the rows of a (n, length) uint8 array, little-endian.

    numbers: field -> (n, count); a field that is left out is zero, or empty if a sequence.
    """
    rows = len(next(iter(numbers.values())))
    counts = {name: values.shape[1] for name, values in numbers.items()}
    blank = _blank(kind, counts, texts)
    block = np.tile(np.frombuffer(blank, dtype=np.uint8), (rows, 1))
    view = block.view(_walk(kind, blank).numbers)[:, 0]
    for name, values in numbers.items():
        if len(values) != rows:
            raise ValueError(f"{name} has {len(values)} rows, the fields before it {rows}")
        view[name] = values
    return block


def _blank(kind: str, counts: Mapping[str, int], texts: Texts) -> bytes:
    """One message with its lengths and texts in place and every number zero."""
    message = bytearray(b"\0\1\0\0")

    def align(size: int) -> None:
        message.extend(bytes(_aligned(len(message), size) - len(message)))

    for name, code, count in FIELDS[kind]:
        words = [text.encode() + b"\0" for text in texts.get(name, ())]
        if count == SEQUENCE:
            count = len(words) if code == "text" else counts.get(name, 0)
            align(4)
            message += struct.pack("<I", count)
        if code == "text":
            for word in words:
                align(4)
                message += struct.pack("<I", len(word)) + word
        elif count:
            align(int(code[1]))
            message += bytes(count * int(code[1]))
    return bytes(message)
