"""Allan variances of the block means of a segment."""

from functools import cache

import numpy as np


def allan_variances(means: np.ndarray, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Allan variances of block means (c, blocks) at block lengths seconds/32, /16, /8, /4, /2.

    blocks: a power of two. Returns variances (levels, c) and block lengths (levels,) s.
    """
    apart, first = _neighbours_apart(means.shape[1])
    squares = (apart @ (means - means[:, :1]).T) ** 2
    compared = np.diff(first)
    sums = np.add.reduceat(squares, first[:-1]) if len(compared) else np.zeros((0, len(means)))
    return 0.5 * sums / compared[:, None], seconds / (compared + 1)


@cache
def _neighbours_apart(blocks: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows (…, blocks) that give by what neighbouring blocks, pairs of blocks, … differ, and the
    first row (levels + 1,) of each level and the row after the last.
    """
    rows, first, averages = np.zeros((0, blocks)), [0], np.eye(blocks)
    while len(averages) >= 2:
        rows = np.concatenate([rows, averages[1:] - averages[:-1]])
        first.append(len(rows))
        averages = 0.5 * (averages[::2] + averages[1::2])
    return rows, np.array(first)
