"""Reduces curves to few points with few digits."""

from collections.abc import Iterable, Sequence

import numpy as np

from schemas.curve import MAX_POINTS

DIGITS = 7  # significant, more than any figure shows


def chosen(count: int) -> list[int]:
    """Which of so many points a curve has: all, or MAX_POINTS evenly from first to last."""
    return np.linspace(0, count - 1, min(count, MAX_POINTS)).round().astype(int).tolist()


def short(numbers: Iterable[float] | np.ndarray) -> tuple[float, ...]:
    """Numbers rounded to DIGITS."""
    return tuple(float(f"{number:.{DIGITS}g}") for number in numbers)


def thinned(*columns: Sequence[float] | np.ndarray) -> tuple[tuple[float, ...], ...]:
    """Columns (n,) of the points that a curve has."""
    kept = chosen(len(columns[0]))
    return tuple(short(column[i] for i in kept) for column in columns)
