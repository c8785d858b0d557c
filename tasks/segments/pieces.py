"""Extremes of long columns, piece by piece: each piece is read from memory once.

A column of a hundred million rows is otherwise read again for every question, and its differences
are as long as itself.
"""

from collections.abc import Callable

import numpy as np

ROWS = 1 << 16  # of a piece: half a megabyte, which stays in a processor's cache


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
    starts = range(0, len(values) - shared, ROWS)
    pieces = (of(values[start : start + ROWS + shared]) for start in starts)
    lows, highs = zip(*((float(piece.min()), float(piece.max())) for piece in pieces), strict=True)
    if any(map(np.isnan, lows)):
        return np.nan, np.nan
    return min(lows), max(highs)
