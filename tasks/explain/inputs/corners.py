"""Where a motion has corners, and by how much a mean over a block of time is then wrong."""

import numpy as np

from tasks.motion.whole import Motion

CORNER = 0.05  # of a fourth difference: error of a block mean at a corner of the motion


def corners(motion: Motion) -> np.ndarray:
    """(n, 6) squared error of a block's rate and force where the motion has a corner.

    Samples do not tell when within their interval a table begins to accelerate; a fourth
    difference is large there and nowhere else.
    """
    rough = np.zeros((len(motion.t), 6))
    for first, signal in ((0, motion.rate), (3, motion.force)):
        fourth = np.abs(np.diff(_bridged(signal), 4, axis=0)).max(axis=1)
        near = np.zeros(len(motion.t))
        for shift in range(5):
            rows = slice(shift, shift + len(fourth))
            near[rows] = np.maximum(near[rows], fourth)
        rough[:, first : first + 3] = ((CORNER * near) ** 2)[:, None]
    return rough


def _bridged(signal: np.ndarray) -> np.ndarray:
    """A signal (n, 3) that goes straight on where it is not known."""
    known = np.isfinite(signal).all(axis=1)
    if known.all() or not known.any():
        return np.nan_to_num(signal)
    rows = np.arange(len(signal))
    return np.column_stack([np.interp(rows, rows[known], axis[known]) for axis in signal.T])
