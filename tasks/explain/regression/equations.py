"""A linearised model in the transformed domain: whitened Gram matrices of columns and misfit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tasks.explain.inputs.blocks import Blocks
from tasks.explain.regression.spectrum import Noise, transformed, weighted
from tasks.model.term import Column


@dataclass(frozen=True)
class Equations:
    """A model linearised at its values: gram (6, q + 1, q + 1) of whitened columns and misfit.

    The last row and column are those of the misfit, reading minus prediction. which: for each
    channel which of the q columns it has.
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


def equations_of(
    columns: Sequence[Column],
    misfit: np.ndarray,
    observed: Blocks,
    noises: Sequence[Noise],
) -> Equations:
    """Whitened Gram matrices of columns and misfit (n, 6)."""
    grams, which = [], []
    for channel, noise in enumerate(noises):
        own = [q for q, column in enumerate(columns) if channel in column]
        signals = [*(columns[q][channel] for q in own), misfit[:, channel]]
        stack = transformed(weighted(signals, observed.weight[:, channel]))
        count = stack.shape[1]
        frequency = np.maximum(np.arange(count), 0.5) * observed.rate / (2 * count)
        stack /= np.sqrt(noise.variance(frequency))
        grams.append(stack @ stack.T)
        which.append(np.array(own, int))
    return Equations(tuple(grams), tuple(which), len(columns))
