"""The time constant with which something settles after each move."""

import numpy as np
from scipy.stats import linregress

from tasks.explain.locate.motion_partitions import time_since_move
from tasks.motion.whole import Motion

LONGEST = 60  # s after a move that are looked at
MIN_ROWS, MIN_SECONDS = 10, 6
MIN_R_SQUARED = 0.95  # of a line through the logarithm: less is no exponential
MIN_POWER = 1e-4  # of the largest


def settling_time(motion: Motion, signal: np.ndarray) -> float | None:
    """Time constant (s) of a signal (n,), None where it does not settle exponentially.

    Moves may start it with any size and sign: of A·exp(−s/τ) the mean square over all moves
    falls as exp(−2·s/τ), s the time since the move.
    """
    since = time_since_move(motion)
    known = (since > 0) & (since < LONGEST)
    second = since[known].astype(int)
    rows = np.bincount(second, minlength=LONGEST)
    power = np.bincount(second, signal[known] ** 2, LONGEST) / np.maximum(rows, 1)
    used = (rows >= MIN_ROWS) & (power > MIN_POWER * power.max())
    if used.sum() < MIN_SECONDS:
        return None
    line = linregress(np.flatnonzero(used) + 0.5, np.log(power[used]))
    if line.slope >= 0 or line.rvalue**2 < MIN_R_SQUARED:
        return None
    return float(-2.0 / line.slope)
