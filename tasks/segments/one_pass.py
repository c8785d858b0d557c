"""Reads a segment's channels from memory once: extremes, block means, once-per-turn part.

A segment of two million rows is larger than a processor's cache; each further question would
read it again.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

ROWS = 1 << 15  # of a piece: a quarter of a megabyte, which stays in a processor's cache
BLOCKS = 32  # finest blocks of the Allan variances


@dataclass(frozen=True)
class Pass:
    """What one reading of c channels (n,) gives.

    low, high: (c,) extremes, NaN for a channel with NaN. mean: (c,). blocks: (c, blocks) means
    over BLOCKS blocks, fewer where there are fewer rows. periodic: (c, blocks) the part of them
    that comes back once a turn; zeros (c, 1) where no turn was asked for.
    """

    low: np.ndarray
    high: np.ndarray
    mean: np.ndarray
    blocks: np.ndarray
    periodic: np.ndarray


def one_pass(
    values: Sequence[np.ndarray], angle: Callable[[slice], np.ndarray] | None = None
) -> Pass:
    """Extremes and means of c channels (n ≥ 1,).

    angle: rad at some rows of a turn whose periodic part is wanted, by least squares of a
    constant, a cosine and a sine; the constant is left in.
    """
    count, channels = len(values[0]), len(values)
    blocks = min(BLOCKS, 1 << (count.bit_length() - 1))
    size = count // blocks
    low, high = np.full(channels, np.inf), np.full(channels, -np.inf)
    sums, after = np.zeros((channels, blocks)), np.zeros(channels)
    turns, squares, along = np.zeros((2, blocks)), np.zeros((3, 3)), np.zeros((channels, 3))
    for rows, within in _whole_blocks(count, blocks):
        parts = [channel[rows] for channel in values]
        low = np.minimum(low, [part.min() for part in parts])
        high = np.maximum(high, [part.max() for part in parts])
        if within is None:
            after += [part.sum() for part in parts]
        else:
            sums[:, within] += _sums(parts, within)
        if angle is not None:
            shapes = _constant_cosine_sine(angle(rows))
            squares += [shapes @ shape for shape in shapes]
            along += [shapes @ part for part in parts]
            if within is not None:
                turns[:, within] += _sums(shapes[1:], within)
    periodic = np.zeros((channels, 1))
    if angle is not None:
        periodic = np.linalg.solve(squares, along.T)[1:].T @ turns / size
    return Pass(low, high, (sums.sum(axis=1) + after) / count, sums / size, periodic)


def _whole_blocks(rows: int, blocks: int) -> Iterator[tuple[slice, slice | None]]:
    """Pieces of so many rows that stay in the cache, and which blocks each lies in.

    A piece is some whole blocks or, where these are long, a part of one; the last are rows after
    the last block, in none.
    """
    size = rows // blocks
    at_once = max(1, ROWS // size)
    for first in range(0, blocks, at_once):
        within = slice(first, min(first + at_once, blocks))
        start = first * size
        for piece in pieces((within.stop - first) * size):
            yield slice(start + piece.start, start + piece.stop), within
    for piece in pieces(rows - blocks * size):
        yield slice(blocks * size + piece.start, blocks * size + piece.stop), None


def _sums(parts: Iterable[np.ndarray], within: slice) -> np.ndarray:
    """(c, blocks) sums of c channels (n,) over the blocks that they are, or a part of one."""
    blocks = within.stop - within.start
    return np.array([part.reshape(blocks, -1).sum(axis=1) for part in parts])


def _constant_cosine_sine(angle: np.ndarray) -> np.ndarray:
    """(3, n) of (n,) rad.

    By the tangent of half the angle, which numpy has nine times as fast as cosine and sine.
    """
    half = np.tan(0.5 * angle)
    square = half**2
    return np.array([1.0 + square, 1.0 - square, 2.0 * half]) / (1.0 + square)


# Processes long columns piece by piece, so that each piece is read from memory once.
#
# A column of a hundred million rows is otherwise read again for every question, and its differences
# are as long as itself.


def pieces(count: int) -> Iterator[slice]:
    """The pieces of `count` rows, one after the other."""
    return (slice(start, min(start + ROWS, count)) for start in range(0, count, ROWS))


def extreme_steps(t: np.ndarray) -> tuple[float, float]:
    """Smallest and largest difference of neighbours among (n ≥ 2,) values; both NaN if one is."""
    steps = (np.diff(t[piece.start : piece.stop + 1]) for piece in pieces(len(t) - 1))
    extremes = np.array([(step.min(), step.max()) for step in steps])
    return float(extremes[:, 0].min()), float(extremes[:, 1].max())
