"""The unit's clock against the table's: offset and skew, each with its uncertainty."""

from dataclasses import dataclass

import numpy as np

BLOCKS = 12  # spans of time of which the least delay counts
FEWEST = 4


@dataclass(frozen=True)
class ClockComparison:
    """Table time minus unit time = offset_s + skew · (unit time − at_s).

    `u_offset_s`, `u_skew`: standard uncertainties by the scatter of the least delays. The offset
    holds the least delay of the line, which no comparison on one side of a line can tell.
    """

    at_s: float
    offset_s: float
    u_offset_s: float
    skew: float
    u_skew: float


def compared(unit_s: np.ndarray, arrived_s: np.ndarray) -> ClockComparison | None:
    """Compare stamps of a unit with the table's time when they arrived, both (n,) in s.

    A line only ever delays, so the least difference of each of BLOCKS spans is taken, and a
    straight line through these by least squares. None for fewer than FEWEST spans.
    """
    blocks = np.array_split(np.arange(len(unit_s)), BLOCKS)
    difference = arrived_s - unit_s
    if sum(len(block) > 0 for block in blocks) < FEWEST:
        return None
    level = difference - np.polyval(np.polyfit(unit_s, difference, 1), unit_s)
    least = np.array([b[np.argmin(level[b])] for b in blocks if len(b)], dtype=int)
    at_s = float(unit_s[least].mean())
    regressors = np.column_stack([np.ones(len(least)), unit_s[least] - at_s])
    inverse = np.linalg.pinv(regressors.T @ regressors)
    offset, skew = inverse @ regressors.T @ difference[least]
    residual = difference[least] - regressors @ [offset, skew]
    u_offset, u_skew = np.sqrt(np.diag(inverse) * (residual @ residual) / (len(least) - 2))
    return ClockComparison(at_s, float(offset), float(u_offset), float(skew), float(u_skew))
