"""The time constant with which something fades after each move."""

import numpy as np

from tasks.explain.locate.motions import since_move
from tasks.motion.whole import Motion

LONGEST = 60  # s after a move that are looked at
FEWEST_ROWS, FEWEST_SECONDS = 10, 6
STRAIGHT = 0.95  # of the logarithm's variance that a line explains: less is no exponential
LEAST = 1e-4  # of the largest power: less is not followed


def fading(motion: Motion, course: np.ndarray) -> float | None:
    """Time constant (s) of a course (n,), None where it does not fade exponentially.

    Moves may start it with any size and sign: of A·exp(−s/τ) the mean square over all moves
    falls as exp(−2·s/τ), s the time since the move.
    """
    since = since_move(motion)
    known = (since > 0) & (since < LONGEST)
    second = since[known].astype(int)
    rows = np.bincount(second, minlength=LONGEST)
    power = np.bincount(second, course[known] ** 2, LONGEST) / np.maximum(rows, 1)
    used = (rows >= FEWEST_ROWS) & (power > LEAST * power.max())
    if used.sum() < FEWEST_SECONDS:
        return None
    seconds, logarithm = np.flatnonzero(used) + 0.5, np.log(power[used])
    slope, start = np.polyfit(seconds, logarithm, 1)
    left = logarithm - slope * seconds - start
    if slope >= 0 or left.var() > (1 - STRAIGHT) * logarithm.var():
        return None
    return float(-2.0 / slope)
