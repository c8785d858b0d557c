"""What a line does to a frame."""

import random
from collections.abc import Callable

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
