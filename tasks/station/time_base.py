"""The unit's clock against the table's: offset and skew, each with its uncertainty."""

import numpy as np

from schemas.unit_clock import ClockComparison

BLOCKS = 12  # spans of time of which the least delay counts
FEWEST = 4


def compared(
    unit_s: np.ndarray, latest_s: np.ndarray, doubt_s: np.ndarray
) -> ClockComparison | None:
    """Compare stamps of a unit with the table's time when they arrived.

    unit_s: (n,) s. latest_s: (n,) s, the latest that the table's time can have been. doubt_s:
    (n,) s, by how much earlier it may have been when the unit set its stamp, in a line without
    fluctuation: the table's answer and the least delay of the line.

    A line only ever delays, so the least difference of each of BLOCKS spans is taken, and a
    straight line through these by least squares. The offset lies below it by no more than the
    median doubt of these: a rectangular distribution. None for fewer than FEWEST spans.
    """
    blocks = np.array_split(np.arange(len(unit_s)), BLOCKS)
    difference = latest_s - unit_s
    if sum(len(block) > 0 for block in blocks) < FEWEST:
        return None
    level = difference - np.polyval(np.polyfit(unit_s, difference, 1), unit_s)
    least = np.array([b[np.argmin(level[b])] for b in blocks if len(b)], dtype=int)
    at_s = float(unit_s[least].mean())
    regressors = np.column_stack([np.ones(len(least)), unit_s[least] - at_s])
    inverse = np.linalg.pinv(regressors.T @ regressors)
    most, skew = inverse @ regressors.T @ difference[least]
    residual = difference[least] - regressors @ [most, skew]
    scatter, u_skew = np.sqrt(np.diag(inverse) * (residual @ residual) / (len(least) - 2))
    half_width = float(np.median(doubt_s[least])) / 2.0
    return ClockComparison(
        at_s=at_s,
        offset_s=float(most) - half_width,
        half_width_s=half_width,
        u_offset_s=float(np.hypot(scatter, half_width / np.sqrt(3.0))),
        skew=float(skew),
        u_skew=float(u_skew),
    )
