"""Whitened normal equations of a linearised model, as every fit of a list of terms solves them.

Whoever knows the noise whitens: by the variance of each row (`tasks.model.fit`), in the transformed
domain (`tasks.explain.whitening`). From there on all fits are the same algebra.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tasks.model.term import Column

RANK = 1e-9  # of the largest eigenvalue of the scaled normal matrix: smaller ones are rounding
RESOLVED = 1e-6  # a parameter is determined where its resolution is one within this


@dataclass(frozen=True)
class WhitenedEquations:
    """A model linearised at its values, whitened.

    grams: for each of six channels the products (k + 1, k + 1) of its whitened columns and, last,
    of its misfit, reading minus prediction. which: (k,) for each channel, which of the `count`
    columns it has.
    """

    grams: tuple[np.ndarray, ...]
    which: tuple[np.ndarray, ...]
    count: int

    def normal(self) -> tuple[np.ndarray, np.ndarray, float]:
        """Normal matrix (q, q), right side (q,) and chi-squared over all channels."""
        normal, right, misfit = np.zeros((self.count, self.count)), np.zeros(self.count), 0.0
        for gram, which in zip(self.grams, self.which, strict=True):
            normal[np.ix_(which, which)] += gram[:-1, :-1]
            right[which] += gram[:-1, -1]
            misfit += float(gram[-1, -1])
        return normal, right, misfit


def of_channel(
    columns: Sequence[Column], misfit: np.ndarray, channel: int
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Which columns (k,) a channel has; these and, last, its misfit of (n, 6), each (n,)."""
    which = [q for q, column in enumerate(columns) if channel in column]
    return np.array(which, int), [*(columns[q][channel] for q in which), misfit[:, channel]]


Whiten = Callable[[Sequence[Column], np.ndarray], WhitenedEquations]
"""Columns and misfit (n, 6) of a model -> its normal equations, by what is known of the noise."""

Scores = Callable[[Sequence[Column], np.ndarray], tuple[np.ndarray, float]]
"""The same -> their right side (q,) and chi-squared alone, without products of columns."""


def inverse(normal: np.ndarray) -> np.ndarray:
    """Generalised inverse of a symmetric matrix (p, p), scaled to a unit diagonal first."""
    scale = np.sqrt(np.maximum(np.diag(normal), 0.0))
    scale = np.divide(1.0, scale, out=np.zeros_like(scale), where=scale > 0)
    values, vectors = np.linalg.eigh(normal * scale[:, None] * scale)
    kept = values > RANK * max(float(values[-1]), 0.0) if len(values) else np.zeros(0, bool)
    turned = vectors[:, kept]
    return np.asarray((turned / values[kept]) @ turned.T * scale[:, None] * scale)


def determined(normal: np.ndarray, solution: np.ndarray) -> np.ndarray:
    """(p,) bool: parameters that the equations determine, by their generalised inverse (p, p)."""
    return np.asarray(np.abs(np.diag(solution @ normal) - 1.0) < RESOLVED)
