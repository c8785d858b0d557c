"""When a unit was moved, and signals that lag behind the motion."""

import numpy as np

from tasks.motion.lag import first_order_lag
from tasks.motion.whole import Motion

TURNING_UP = 0.02  # of a unit vector in a second: gravity's direction changes
AT_REST = 1e-3  # rad/s: slower is not a motion
MAX_MOVE = 20.0  # s; what turns longer is a run


def time_since(motion: Motion, events: np.ndarray) -> np.ndarray:
    """(n,) s since the last event (n,) bool was over; infinite before the first."""
    rows = np.flatnonzero(np.diff(events.astype(int)) == -1) + 1
    if not len(rows):
        return np.full(len(motion.t), np.inf)
    last = np.searchsorted(rows, np.arange(len(motion.t)), "right") - 1
    elapsed = motion.t - motion.t[rows[np.maximum(last, 0)]]
    return np.where(last >= 0, elapsed, np.inf)


def gravity_turns(motion: Motion) -> np.ndarray:
    """(n,) bool: gravity's direction in the unit changes. A turn about a level axis is one move."""
    up = np.nan_to_num(motion.up)
    speed = np.linalg.norm(np.gradient(up, motion.interval, axis=0), axis=1)
    return np.asarray(speed > TURNING_UP)


def turning(motion: Motion) -> np.ndarray:
    """(n,) bool: the unit turns, in whatever way."""
    return np.asarray(np.linalg.norm(np.nan_to_num(motion.rate), axis=1) > AT_REST)


def repositioning(motion: Motion) -> np.ndarray:
    """(n,) bool: the unit turns from one rest to another, without a steady turn between."""
    moving = turning(motion)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], moving.astype(int), [0]])))
    steady = motion.recorded.get("steady_turn", np.zeros(len(moving)))
    found = moving.copy()
    for start, stop in edges.reshape(-1, 2):
        if steady[start:stop].any() or motion.t[stop - 1] - motion.t[start] > MAX_MOVE:
            found[start:stop] = False
    return found


def lagged(signal: np.ndarray, t: np.ndarray, tau: float) -> np.ndarray:
    """First-order lag of a signal (n,), from rest."""
    return first_order_lag(np.nan_to_num(signal), float(np.median(np.diff(t))), tau)
