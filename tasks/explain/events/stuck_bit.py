"""A stuck bit of the code: every other block of 2ᵇ codes never occurs.

The readings reach up to both ends of the stretches that are read, and none lies beyond: noise that
is wider than a code would have carried some there.
"""

from collections.abc import Mapping

import numpy as np

from tasks.model.fit import plain_prediction
from tasks.motion.whole import Motion

BITS = tuple(range(2, 15))
OFF_CODE = 0.05  # of a step: how far a reading may lie off its code, for the rounding of a file
MIN_PERIODS = 3  # of 2ᵇ⁺¹ codes, with readings
MIN_AT_END = 25  # readings within half of the noise of either end
ROUNDS = 8  # of expectation and maximisation


def stuck_bit(codes: np.ndarray) -> int | None:
    """What a stuck bit adds to a code, by codes (n,): ±2ᵇ; None where none is stuck.

    Codes count from the unit's own zero: bits of a number that was shifted are not known.
    """
    known = codes[np.isfinite(codes)]
    number = np.rint(known).astype(int)
    if len(number) < 2 or np.abs(known - number).max() > OFF_CODE:
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
        if min(ends) >= MIN_AT_END:
            return int(1 << bit if level[0] else -(1 << bit))
    return None


def put_back(readings: np.ndarray, motion: Motion, weights: Mapping[int, float]) -> np.ndarray:
    """(n, 6) what stuck bits added to readings (n, 6): nothing or the bit's weight, by channel.

    Where noise is as wide as the bit, the expectation of the two, given the standard's model.
    """
    off = np.zeros_like(readings)
    for _ in range(ROUNDS if weights else 0):
        predicted = plain_prediction(readings - off, motion)
        for c, weight in weights.items():
            residual = readings[:, c] - predicted[:, c]
            variance = max(float(np.nanmedian((residual - off[:, c]) ** 2)) / 0.455, 1e-30)
            odds = (residual**2 - (residual - weight) ** 2) / (2.0 * variance)
            added = weight / (1.0 + np.exp(-np.clip(odds, -50.0, 50.0)))
            off[:, c] = np.nan_to_num(added)
    return off
