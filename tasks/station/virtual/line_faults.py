"""What a faulty line does to the unit's frames."""

from collections.abc import Callable

import numpy as np

Wire = Callable[[np.ndarray, list[bytes]], list[bytes]]  # (numbers (n,), frames) -> frames

GARBAGE_EVERY = 20
DROPPED_FROM, DROPPED_EVERY = 190, 200  # the last ten of each two hundred


def silence(numbers: np.ndarray, sent: list[bytes]) -> list[bytes]:
    return []


def drop(numbers: np.ndarray, sent: list[bytes]) -> list[bytes]:
    keep = numbers % DROPPED_EVERY < DROPPED_FROM
    return [frame for frame, kept in zip(sent, keep, strict=True) if kept]


def _each(every: int, change: Callable[[bytes, int], bytes]) -> Wire:
    """A change of the frames whose number is a multiple of `every`."""

    def transmit(numbers: np.ndarray, sent: list[bytes]) -> list[bytes]:
        return [
            change(frame, number) if number % every == 0 else frame
            for number, frame in zip(numbers.tolist(), sent, strict=True)
        ]

    return transmit


def _random_bytes(frame: bytes, number: int) -> bytes:
    return np.random.default_rng(number).bytes(len(frame))


def _flip(frame: bytes, number: int) -> bytes:
    place, bit = number % len(frame), number // 100 % 8
    return frame[:place] + bytes([frame[place] ^ 1 << bit]) + frame[place + 1 :]


garble = _each(
    GARBAGE_EVERY,
    lambda frame, _: frame[:20] + bytes([frame[20] ^ 0x5A]) + frame[21:] + b"\xaa\x55\x00",
)
repeat = _each(50, lambda frame, _: frame + frame)
merge = _each(40, lambda frame, _: frame[:-3])
cut = _each(60, lambda frame, _: frame[: len(frame) // 2])
flip = _each(100, _flip)
noise = _each(1, _random_bytes)


def swap(numbers: np.ndarray, sent: list[bytes]) -> list[bytes]:
    swapped = list(sent)
    for place in np.flatnonzero(numbers[:-1] % 80 == 0).tolist():
        swapped[place], swapped[place + 1] = swapped[place + 1], swapped[place]
    return swapped
