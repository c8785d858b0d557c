"""White noise of a signal that moves, read off its high differences."""

from math import comb

import numpy as np

NORMAL_QUANTILES = {0.5: 0.6745, 0.9: 1.645}  # of the absolute value of a standard normal variable
SAMPLE = 20_000  # differences that a quantile is taken of


def noise_by_differences(values: np.ndarray, order: int, share: float) -> float:
    """Standard deviation of the white noise of values (n,) or (n, k), where anything moves at all.

    A motion leaves next to nothing in differences of a high order but what oscillates faster than
    a quarter of the sampling rate. share: the quantile of their size that is compared with that of
    normal noise; what disturbs fewer of them does not count.
    """
    rough = np.abs(np.diff(values, order, axis=0)).ravel()
    rough = rough[rough > 0.0]
    rough = rough[:: 1 + len(rough) // SAMPLE]
    if not len(rough):
        return 0.0
    size = float(np.quantile(rough, share)) / NORMAL_QUANTILES[share]
    return size / float(np.sqrt(comb(2 * order, order)))
