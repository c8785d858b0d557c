"""Codes whose high byte is that of the row before.

Where a high byte is late, readings are off by 256 codes when it changes.
Where noise is not far below a byte no single reading tells it. But the low byte is right, and with
what is expected it tells the high one; readings that are off by it then have the high byte of the
row before far more often than of the row after. Noise knows no direction of time, and neither do
spikes, held rows or a bias that jumps.
"""

import numpy as np
from scipy.ndimage import median_filter

from tasks.readings.judge import CERTAIN, in_course

BYTE = 256.0  # codes
ABOUT = 25  # rows about one, most of which are right
FIT_ROUNDS = 3
SLOW = 64.0  # codes from row to row: faster, a delay has the high byte of the row before, too
MIN_TORN = 15
MIN_RATIO = 3.0  # of rows that have it of the row before to those of the row after
MAX_HELD = 0.2  # of the rows in which a change is expected


def torn_codes(code: np.ndarray, predicted: np.ndarray) -> np.ndarray | None:
    """By how many codes (n,) each reading is off; None where they are not torn.

    code, predicted: (n,) as read, and as expected without the fault.
    """
    known = np.isfinite(code) & np.isfinite(predicted)
    read, expected = np.where(known, code, 0.0), np.where(known, predicted, 0.0)
    low, right, near = np.mod(read, BYTE), read, expected
    slow = np.flatnonzero(known & (np.abs(np.gradient(expected)) < SLOW))
    if len(slow) < ABOUT or _held(read, expected):
        return None
    for _ in range(FIT_ROUNDS):
        # On a ramp most rows may be off, and alike: what is expected there is told by rests beside.
        beyond = median_filter((right - expected)[slow], ABOUT, mode="nearest")
        near = expected + np.interp(np.arange(len(read)), slow, beyond)
        right = low + BYTE * np.round((near - low) / BYTE)
        if np.count_nonzero(read != right) < MIN_TORN:
            return None
    off = np.round((read - right) / BYTE)
    high = np.floor(right / BYTE)
    before, after = np.zeros_like(off), np.zeros_like(off)
    before[1:], after[:-1] = high[:-1] - high[1:], high[1:] - high[:-1]
    from_before, from_after = (off != 0.0) & (off == before), (off != 0.0) & (off == after)
    count = int((from_before & ~from_after)[slow].sum())
    chance = int((from_after & ~from_before)[slow].sum())
    torn = np.where(known & from_before, BYTE * off, 0.0)
    # Noise puts as many readings into the byte of the row after.
    odds = float(np.log(2.0)) * (count - MIN_RATIO * chance)
    return torn if odds > CERTAIN and in_course(code, code - torn) > 0.0 else None


def _held(read: np.ndarray, expected: np.ndarray) -> bool:
    """Whether readings (n,) repeat the row before while something else is expected: both bytes are
    then of an earlier row.
    """
    moves = np.abs(np.diff(expected)) > 1.0
    return bool(np.mean(np.diff(read)[moves] == 0.0) > MAX_HELD) if moves.any() else False
