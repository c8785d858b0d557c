"""Long columns piece by piece: each piece is read from memory once, however much is asked of it.

A column of a hundred million rows is otherwise read again for every question, and its differences
are as long as itself.
"""

from collections.abc import Callable, Iterator

import numpy as np

ROWS = 1 << 15  # of a piece: a quarter of a megabyte, which stays in a processor's cache


def pieces(count: int) -> Iterator[slice]:
    """The pieces of `count` rows, one after the other."""
    return (slice(start, min(start + ROWS, count)) for start in range(0, count, ROWS))


def extent(values: np.ndarray) -> tuple[float, float]:
    """Smallest and largest of (n ≥ 1,) values; NaN both where one is."""
    return _extremes(values, 0, lambda piece: piece)


def extreme_steps(t: np.ndarray) -> tuple[float, float]:
    """Smallest and largest difference between neighbours of (n ≥ 2,) values."""
    return _extremes(t, 1, np.diff)


def _extremes(
    values: np.ndarray, shared: int, of: Callable[[np.ndarray], np.ndarray]
) -> tuple[float, float]:
    """shared: values that a piece has in common with the next."""
    each = (of(values[p.start : p.stop + shared]) for p in pieces(len(values) - shared))
    lows, highs = zip(*((float(piece.min()), float(piece.max())) for piece in each), strict=True)
    if any(map(np.isnan, lows)):
        return np.nan, np.nan
    return min(lows), max(highs)
