"""Numbers that are known but for whole multiples of a size: which multiple, by rows beside them and
by what the unit felt.
"""

import numpy as np

from tasks.readings.line import Line
from tasks.readings.robust import deviation

ROUNDS = 4
SCATTER = 0.5  # of the size: of a number about the line, for rows beside it err alike
SURE = 0.125  # of the size: uncertainty of the line, beyond which it decides nothing
NEAR = 0.4  # of the size: by which numbers may be off the line
MOST_NOISE = 0.12  # of the size: standard deviation beyond which no single number is decided
MEMORY = 0.5  # of the change from row to row


def resolved(
    numbers: np.ndarray, free: np.ndarray, size: float, line: Line
) -> tuple[np.ndarray, np.ndarray]:
    """The numbers (n,), and which of them are not decided.

    free: (n,) bool, numbers that whole multiples of the size are missing from. line: that the
    numbers follow. By the line where it is known and sure; elsewhere as the rows before and after
    go on, where both say the same.
    """
    known = np.isfinite(numbers)
    free = free & known
    every = bool(free[known].all())
    if every:
        onwards = _unwrapped(numbers, size)
        if (felt := known & line.known).any():
            off = np.median((line.columns[felt] @ line.ideal) - onwards[felt])
            onwards = onwards + size * np.round(off / size)
        backwards = onwards
    else:
        onwards = _followed(numbers, free, size)
        backwards = _followed(numbers[::-1], free[::-1], size)[::-1]
    agreed = known & (~free | (onwards == backwards))
    felt, by_line = known & line.known, np.zeros(len(numbers), bool)
    values, used = np.where(agreed, onwards, numbers), felt & (agreed if every else ~free)
    for _ in range(ROUNDS if felt.any() else 0):
        predicted, u = line.through(values, used, SCATTER * size)
        nearest = np.where(free, numbers + size * np.round((predicted - numbers) / size), numbers)
        used = felt & (u < SURE * size) & (np.abs(nearest - predicted) < NEAR * size)
        by_line = free & used
        values = np.where(by_line, nearest, np.where(agreed, onwards, numbers))
    undecided = known & free & ~by_line & ~agreed
    noise = deviation(np.diff(values[used])) / np.sqrt(2.0) if used.any() else 0.0
    return values, free if noise > MOST_NOISE * size else undecided


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
