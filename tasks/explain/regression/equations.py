"""A linearised model in the transformed domain: whitened Gram matrices of columns and misfit."""

from collections.abc import Sequence

import numpy as np

from tasks.explain.inputs.blocks import Blocks
from tasks.explain.regression.spectrum import Noise, transformed, weighted
from tasks.model.regression import WhitenedEquations, of_channel
from tasks.model.term import Column


def equations_of(
    columns: Sequence[Column],
    misfit: np.ndarray,
    observed: Blocks,
    noises: Sequence[Noise],
) -> WhitenedEquations:
    """Whitened Gram matrices of columns and misfit (n, 6)."""
    grams, which = [], []
    for channel, noise in enumerate(noises):
        own, signals = of_channel(columns, misfit, channel)
        stack = transformed(weighted(signals, observed.weight[:, channel]))
        grams.append(whitened_gram(stack, observed.rate, noise))
        which.append(own)
    return WhitenedEquations(tuple(grams), tuple(which), len(columns))


def whitened_gram(stack: np.ndarray, rate: float, noise: Noise) -> np.ndarray:
    """Products (k, k) of transformed rows (k, n) of signals at a rate, Hz, divided by the noise."""
    count = stack.shape[1]
    frequency = np.maximum(np.arange(count), 0.5) * rate / (2 * count)
    stack = stack / np.sqrt(noise.variance(frequency))
    return np.asarray(stack @ stack.T)
