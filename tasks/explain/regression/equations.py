"""A linearised model in the transformed domain: whitened Gram matrices of columns and misfit."""

from collections.abc import Sequence

import numpy as np

from tasks.explain.inputs.blocks import Blocks
from tasks.explain.regression.spectrum import Noise, transformed, weighted
from tasks.model.regression import Whiten, WhitenedEquations
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
        own = [q for q, column in enumerate(columns) if channel in column]
        signals = [*(columns[q][channel] for q in own), misfit[:, channel]]
        stack = transformed(weighted(signals, observed.weight[:, channel]))
        count = stack.shape[1]
        frequency = np.maximum(np.arange(count), 0.5) * observed.rate / (2 * count)
        stack /= np.sqrt(noise.variance(frequency))
        grams.append(stack @ stack.T)
        which.append(np.array(own, int))
    return WhitenedEquations(tuple(grams), tuple(which), len(columns))


def whitening(observed: Blocks, noises: Sequence[Noise]) -> Whiten:
    """Whitens columns and misfit by the noises of a coefficient at the observed rate."""
    return lambda columns, misfit: equations_of(columns, misfit, observed, noises)
