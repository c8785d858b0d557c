"""Which block of time each row of the unit's stream falls into: the one place that says so.

Predictions are kept and compared as means over these blocks, those that
`tasks.explain.inputs.blocks` makes at the same rate.
"""

import numpy as np

BLOCK_RATE = 25.0  # Hz


def block_numbers(t: np.ndarray) -> np.ndarray:
    """(n,) the block of each row, from its time t (n,) s."""
    since = t - t[0]
    own = 1.0 / max(float(np.median(np.diff(t))), 1e-9)
    step = max(1, round(own / BLOCK_RATE))
    return np.asarray(((since + 0.5 / own) * own / step).astype(int))


def block_means(courses: np.ndarray, numbers: np.ndarray, count: int) -> np.ndarray:
    """(count, k) means of courses (n, k); NaN where a row of a block is, or where there is none."""
    rows = np.bincount(numbers, minlength=count)[:count]
    sums = np.column_stack([np.bincount(numbers, c, count)[:count] for c in courses.T])
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(sums / rows[:, None])
