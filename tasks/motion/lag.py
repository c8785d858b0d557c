"""A first-order lag of a signal."""

import numpy as np
from scipy.signal import lfilter


def first_order_lag(
    signal: np.ndarray, step: float, seconds: float, start: float = 0.0
) -> np.ndarray:
    """A signal (n,) of rows `step` s apart through a lag of first order.

    seconds: its time constant. start: the value it was in balance with before the first row.
    """
    stays = np.exp(-step / seconds)
    return np.asarray(lfilter([1.0 - stays], [1.0, -stays], signal, zi=[stays * start])[0])
