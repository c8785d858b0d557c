"""Reads a segment's channels from memory once: extremes, block means, once-per-turn part.

A segment of two million rows is larger than a processor's cache; each further question would
read it again.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

ROWS = 1 << 14  # of a piece: those of six channels stay in a processor's cache
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
    turning = 0 if angle is None else 2  # columns beside the channels: cosine and sine
    sums = np.zeros((channels + turning, blocks))
    products = np.zeros((channels + turning, 2))  # with cosine and sine
    for rows, within in _whole_blocks(count, blocks):
        parts = [channel[rows] for channel in values]
        low = np.minimum(low, [part.min() for part in parts])
        high = np.maximum(high, [part.max() for part in parts])
        if angle is not None:
            shapes = cosine_and_sine(angle(rows))
            parts += list(shapes)
            products += [shapes @ part for part in parts]
        whole = min(rows.stop, blocks * size) - rows.start
        sums[:, within] += _sums([part[:whole] for part in parts], within)
    total = sums.sum(axis=1) + [part[whole:].sum() for part in parts]
    periodic = np.zeros((channels, 1))
    if angle is not None:
        products -= np.outer(total, total[channels:]) / count  # without the constant
        turns = np.linalg.solve(products[channels:], products[:channels].T).T
        periodic = turns @ sums[channels:] / size
    return Pass(low, high, total[:channels] / count, sums[:channels] / size, periodic)


def _whole_blocks(rows: int, blocks: int) -> Iterator[tuple[slice, slice]]:
    """Pieces of so many rows that stay in the cache, and which blocks each lies in.

    A piece is some whole blocks or, where these are long, a part of one; to the last belong the
    few rows after the last block, which are in none.
    """
    size = rows // blocks
    at_once = max(1, ROWS // size)
    for first in range(0, blocks, at_once):
        within = slice(first, min(first + at_once, blocks))
        start = first * size
        for piece in pieces((within.stop - first) * size):
            stop = start + piece.stop
            yield slice(start + piece.start, stop if stop < blocks * size else rows), within


def _sums(parts: Iterable[np.ndarray], within: slice) -> np.ndarray:
    """(c, blocks) sums of c channels (n,) over the blocks that they are, or a part of one."""
    blocks = within.stop - within.start
    return np.array([part.reshape(blocks, -1).sum(axis=1) for part in parts])


def cosine_and_sine(angle: np.ndarray) -> np.ndarray:
    """Both (2, …) of an angle (…), rad.

    By the tangent of half the angle, which numpy has nine times as fast as cosine and sine.
    """
    half, both = np.tan(0.5 * angle), np.empty((2, *angle.shape))
    np.multiply(half, half, out=both[0])
    both[0] += 1.0
    np.divide(2.0, both[0], out=both[0])  # 1 + cosine
    np.multiply(half, both[0], out=both[1])
    both[0] -= 1.0
    return both


# Processes long columns piece by piece, so that each piece is read from memory once.
#
# A column of a hundred million rows is otherwise read again for every question, and its differences
# are as long as itself.


def pieces(count: int) -> Iterator[slice]:
    """The pieces of `count` rows, one after the other."""
    return (slice(start, min(start + ROWS, count)) for start in range(0, count, ROWS))


def extreme_steps(t: np.ndarray) -> tuple[float, float]:
    """Smallest and largest difference of neighbours among (n,) values; both NaN if one is, or if
    there are none.
    """
    extremes = []
    for piece in pieces(len(t) - 1):
        steps = t[piece.start + 1 : piece.stop + 1] - t[piece]
        extremes.append((steps.min(), steps.max()))
    low, high = np.array(extremes or [(np.nan, np.nan)]).T
    return float(low.min()), float(high.max())
