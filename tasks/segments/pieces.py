"""Processes long columns piece by piece, so that each piece is read from memory once.

A column of a hundred million rows is otherwise read again for every question, and its differences
are as long as itself.
"""

from collections.abc import Iterator

import numpy as np

ROWS = 1 << 15  # of a piece: a quarter of a megabyte, which stays in a processor's cache


def pieces(count: int) -> Iterator[slice]:
    """The pieces of `count` rows, one after the other."""
    return (slice(start, min(start + ROWS, count)) for start in range(0, count, ROWS))


def extreme_steps(t: np.ndarray) -> tuple[float, float]:
    """Smallest and largest difference of neighbours among (n ≥ 2,) values; both NaN if one is."""
    steps = (np.diff(t[piece.start : piece.stop + 1]) for piece in pieces(len(t) - 1))
    extremes = np.array([(step.min(), step.max()) for step in steps])
    return float(extremes[:, 0].min()), float(extremes[:, 1].max())
