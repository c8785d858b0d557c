"""Small rotations that a term puts between ground and unit, and the level directions it needs."""

from dataclasses import replace

import numpy as np

from tasks.motion.small_rotation import with_small_rotation
from tasks.motion.whole import Motion


def turned_by(
    motion: Motion, turn: np.ndarray, change: np.ndarray | None, outside: np.ndarray | None
) -> Motion:
    """The motion with a small rotation vector more.

    turn: (n, 3) rad in the body, change: (n, 3) rad/s, the rate that it adds, if any; outside:
    (n, 3) rad/s of what turns outside of it, if anything does.
    """
    still = np.zeros(len(motion.t))
    carried = np.zeros_like(turn) if outside is None else outside
    moved = with_small_rotation(motion, turn, still + 1.0, still, carried)
    return moved if change is None else replace(moved, rate=moved.rate + change)


def level_axes(motion: Motion) -> tuple[np.ndarray, np.ndarray] | None:
    """East and North in the body, (n, 3) each; None where no level direction is known.

    Where the heading is not known the table's own y axis stands for North.
    """
    north = motion.north
    if not np.isfinite(north).any():
        if motion.axes is None:
            return None
        north = motion.axes.base
    return np.cross(north, motion.up), north
