"""Bits that stick: every other block of 2ᵇ numbers never occurs.

The readings reach up to both ends of the stretches that are read, and none lies beyond: noise that
is wider than a code would have carried some there.
"""

import numpy as np

from tasks.readings.line import Line

BITS = tuple(range(2, 15))
MIN_PERIODS = 3  # of 2ᵇ⁺¹ codes, with readings
CLEAR = 7.0  # log odds: of one in a thousand
ROUNDS = 8  # of expectation and maximisation
MEDIAN_CHI2 = 0.4549  # of one degree of freedom


def stuck_bit(numbers: np.ndarray) -> tuple[int, float] | None:
    """What a stuck bit adds to a number, by whole numbers (n,): ±2ᵇ, and its log odds against
    chance; None where none may be stuck.
    """
    number = numbers[np.isfinite(numbers)].astype(np.int64)
    if len(number) < 2:
        return None
    change = np.abs(np.diff(number))
    near = max(1, round(0.5 * float(np.median(change)) / 0.954))  # 0.6745·√2 of the noise
    for bit in BITS:
        level = number >> bit & 1
        if level.min() != level.max() or len(np.unique(number >> bit + 1)) < MIN_PERIODS:
            continue
        place = number & (1 << bit) - 1
        width = min(near, 1 << bit - 2)
        ends = (place < width).sum(), (place >= (1 << bit) - width).sum()
        if min(ends):  # of those at an end, chance puts half of them beyond
            odds = 2.0 * float(np.log(2.0)) * min(ends)
            return (1 << bit if level[0] else -(1 << bit)), odds
    return None


def put_back(numbers: np.ndarray, weight: float, line: Line) -> tuple[np.ndarray, np.ndarray]:
    """The right numbers (n,), and which of them are not decided.

    weight: that the bit adds to some of them. line: that the right numbers follow. Where noise is
    as wide as the bit, the expectation of the two. Where the rows beside speak against the line,
    nothing is decided.
    """
    felt = line.known & np.isfinite(numbers)
    added, odds = np.zeros(len(numbers)), np.zeros(len(numbers))
    for _ in range(ROUNDS if felt.any() else 0):
        predicted, _ = line.through(numbers - added, felt, abs(weight))
        off = numbers - predicted
        variance = max(float(np.median((off - added)[felt] ** 2)) / MEDIAN_CHI2, 1e-12)
        odds = (off**2 - (off - weight) ** 2) / (2.0 * variance)
        added = np.where(felt, weight / (1.0 + np.exp(-np.clip(odds, -50.0, 50.0))), 0.0)
    clear = felt & (np.abs(odds) > CLEAR)
    right = numbers - np.where(clear, weight * (odds > 0.0), added)
    beside = right.copy()
    beside[1:-1] -= 0.5 * (right[:-2] + right[2:])
    denied = clear & (np.abs(beside) > 0.5 * abs(weight))
    return right, np.isfinite(numbers) & (~felt | denied)
