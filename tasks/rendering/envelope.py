"""Reduces a long signal to what a screen can show, keeping every peak."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Envelope:
    """Of each bin the smallest and the largest value.

    t: (m,) s, the time of the first row of the bin; low, high: (m,), NaN where no row of the bin
    has a number. is_reduced: whether a bin may hold more than one row.
    """

    t: np.ndarray
    low: np.ndarray
    high: np.ndarray
    is_reduced: bool


def envelope(t: np.ndarray, values: np.ndarray, bins: int) -> Envelope:
    """The envelope of a signal over equal times.

    t: (n,) s, strictly rising; values: (n,). With no more than two rows per bin every row is kept.
    A bin without rows, in a gap of the recording, is left out.
    """
    if len(t) <= 2 * bins:
        return Envelope(t, values, values, is_reduced=False)
    edges = np.linspace(t[0], t[-1], bins + 1)[:-1]
    starts = np.unique(np.searchsorted(t, edges))
    low = np.fmin.reduceat(values, starts)
    high = np.fmax.reduceat(values, starts)
    return Envelope(t[starts], low, high, is_reduced=True)
