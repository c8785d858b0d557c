"""How a model predicts segments that its fit did not use: every fourth one, in turn."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from tasks.explain.inputs.blocks import Blocks
from tasks.explain.regression.spectrum import Noise
from tasks.model.cross_validation import CrossValidation
from tasks.model.regression import WhitenedEquations
from tasks.model.term import Column

FOLDS = 4
CELL_LENGTH = 30.0  # s of what has no segments


def cross_validation(
    columns: Sequence[Column], misfit: np.ndarray, observed: Blocks, noises: Sequence[Noise]
) -> CrossValidation:
    """Every fourth segment, with the move before it, is a fold.

    Drift joins neighbours that stand in different folds; so here it is an offset of each segment,
    as large as flicker makes it between the length of a segment and that of the run.
    """
    cells = fold_cells(observed)
    grams = [_grams_of_cells(columns, misfit, observed, c, n, cells) for c, n in enumerate(noises)]
    folds = tuple(
        WhitenedEquations(
            tuple(part[np.arange(len(part)) % FOLDS == k].sum(axis=0) for part, _ in grams),
            tuple(which for _, which in grams),
            len(columns),
        )
        for k in range(FOLDS)
    )
    whole = WhitenedEquations(
        tuple(part.sum(axis=0) for part, _ in grams), folds[0].which, len(columns)
    )
    return CrossValidation(whole, folds)


def _grams_of_cells(
    columns: Sequence[Column],
    misfit: np.ndarray,
    observed: Blocks,
    channel: int,
    noise: Noise,
    cells: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Gram matrices (cells, k + 1, k + 1) of a channel's columns and misfit, and which columns."""
    weight = observed.weight[:, channel]
    own = [q for q, column in enumerate(columns) if channel in column]
    stack = np.column_stack([*(columns[q][channel] for q in own), misfit[:, channel]])
    stack = np.nan_to_num(stack) * weight[:, None] / np.sqrt(noise.white)
    level = weight / np.sqrt(noise.white)
    edges = np.searchsorted(cells, np.arange(cells[-1] + 2))
    span = len(weight) / observed.rate
    grams = np.zeros((len(edges) - 1, len(own) + 1, len(own) + 1))
    for n, (start, stop) in enumerate(pairwise(edges)):
        part, one = stack[start:stop], level[start:stop]
        lasts = max(stop - start, 1) / observed.rate
        offset = 2.0 * noise.flicker / observed.rate * np.log(1.0 + span / lasts)
        shared = one @ part
        share = offset / (1.0 + offset * float(one @ one))
        grams[n] = part.T @ part - share * np.outer(shared, shared)
    return grams, np.array(own, int)


def fold_cells(observed: Blocks) -> np.ndarray:
    """(n,) number of the segment of each row; a move belongs to the segment after it."""
    number = observed.segment
    if (number < 0).all():
        return np.asarray((observed.t / CELL_LENGTH).astype(int))
    rows = np.flatnonzero(number >= 0)
    following = rows[np.minimum(np.searchsorted(rows, np.arange(len(number))), len(rows) - 1)]
    changes = np.diff(number[following], prepend=number[following[0]]) != 0
    return np.asarray(np.cumsum(changes))
