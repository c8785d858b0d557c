"""A linearised model in the transformed domain: whitened Gram matrices of columns and misfit."""

from collections.abc import Sequence

import numpy as np

from tasks.explain.inputs.observed import Observed
from tasks.explain.regression.spectrum import Noise, padded_length, transformed
from tasks.model.regression import NormalEquations, Whiten
from tasks.model.term import Column


def equations_of(
    columns: Sequence[Column],
    misfit: np.ndarray,
    observed: Observed,
    noises: Sequence[Noise],
) -> NormalEquations:
    """Whitened Gram matrices of columns and misfit (n, 6)."""
    grams, which = [], []
    for channel, noise in enumerate(noises):
        weight = observed.weight[:, channel]
        own = [q for q, column in enumerate(columns) if channel in column]
        stack = np.zeros((len(own) + 1, padded_length(len(weight))))
        for row, q in enumerate(own):
            stack[row, : len(weight)] = columns[q][channel]
        stack[-1, : len(weight)] = misfit[:, channel]
        stack[:, : len(weight)] *= weight
        np.nan_to_num(stack, copy=False)
        stack = transformed(stack)
        count = stack.shape[1]
        frequency = np.maximum(np.arange(count), 0.5) * observed.rate / (2 * count)
        stack /= np.sqrt(noise.variance(frequency))
        grams.append(stack @ stack.T)
        which.append(np.array(own, int))
    return NormalEquations(tuple(grams), tuple(which), len(columns))


def whitening(observed: Observed, noises: Sequence[Noise]) -> Whiten:
    """Whitens columns and misfit by the noises of a coefficient at the observed rate."""
    return lambda columns, misfit: equations_of(columns, misfit, observed, noises)
