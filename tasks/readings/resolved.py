"""Numbers that are known but for whole multiples of a size: which multiple, by rows beside them and
by what the unit felt.
"""

import numpy as np

ROUNDS = 4
NEAR = 0.25  # of the size: numbers that a fit goes by, and by which they may be off it
MEMORY = 0.5  # of the change from row to row


def resolved(
    numbers: np.ndarray, free: np.ndarray, size: float, columns: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The numbers (n,), and which of them are not decided.

    free: (n,) bool, numbers that whole multiples of the size are missing from. columns: (n, k) a
    straight line in which gives the numbers, NaN where it is not known. By the line where it is
    known; elsewhere as the rows before and after go on, where both say the same.
    """
    known = np.isfinite(numbers)
    free = free & known
    if free[known].all():
        onwards = backwards = _unwrapped(numbers, size)
    else:
        onwards = _followed(numbers, free, size)
        backwards = _followed(numbers[::-1], free[::-1], size)[::-1]
    agreed = ~free | (onwards == backwards)
    felt = np.isfinite(columns).all(axis=1) & known
    values, used, off = onwards, felt & agreed, np.full(len(numbers), np.inf)
    if not free[known].all() and np.linalg.matrix_rank(columns[felt & ~free]) == \
            np.linalg.matrix_rank(columns[felt]):  # fmt: skip
        used = felt & ~free
    for _ in range(ROUNDS if used.any() else 0):
        fitted = np.linalg.lstsq(columns[used], values[used], rcond=None)[0]
        predicted = columns @ fitted
        nearest = numbers + size * np.round((predicted - numbers) / size)
        values = np.where(free & felt, nearest, values)
        off = np.abs(values - predicted)
        used = felt & (off < NEAR * size)
    decided = np.where(felt, off < NEAR * size, agreed) | ~free
    return values, known & ~decided


def _unwrapped(numbers: np.ndarray, size: float) -> np.ndarray:
    """All numbers as each is nearest to the one before, the usual one as near zero as can be."""
    known = np.isfinite(numbers)
    values = np.full(len(numbers), np.nan)
    followed = np.unwrap(numbers[known], period=size)
    values[known] = followed - size * np.round(np.median(followed) / size)
    return values


def _followed(numbers: np.ndarray, free: np.ndarray, size: float) -> np.ndarray:
    """Each free number (n,) as near as can be to where those before it go; NaN before the first."""
    values = np.where(free, np.nan, numbers)
    last, slope = np.nan, 0.0
    for row, (number, open_) in enumerate(zip(numbers.tolist(), free.tolist(), strict=True)):
        if number != number:
            continue
        if open_:
            if last != last:
                continue
            number += size * round((last + slope - number) / size)
            values[row] = number
        if last == last:
            slope += MEMORY * (number - last - slope)
        last = number
    return values
