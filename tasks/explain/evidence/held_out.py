"""How a model predicts segments that its fit did not use: every fourth one, in turn."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tasks.explain.inputs.blocks import Blocks
from tasks.explain.regression.spectrum import Noise
from tasks.model.regression import WhitenedEquations, of_channel
from tasks.model.term import Column

FOLDS = 4
CELL_LENGTH = 30.0  # s of what has no segments
DIFFUSE = 1e-9  # of a column's power: what no other fold determines is as good as free


@dataclass(frozen=True)
class CrossValidation:
    """A model's normal equations on all rows, and on each fold of them."""

    whole: WhitenedEquations
    folds: tuple[WhitenedEquations, ...]

    def deviance(self, fitted: Sequence[int], values: np.ndarray, prior: np.ndarray) -> np.ndarray:
        """−2·ln of the likelihood (6,) of each fold as a fit to all the others predicts it.

        What the others leave uncertain is uncertain in the prediction: e ~ N(0, 1 + J·C·Jᵀ).
        fitted: the columns that are fitted. values: (q,) of columns that are put back into the
        misfit first. prior: (q,) precision beforehand, of changes about `values`.
        """
        total = np.zeros(len(self.whole.grams))
        rows = list(fitted)
        whole, whole_right, _ = self.whole.normal()
        power = np.diag(whole)[rows] + prior[rows]
        scale = 1.0 / np.sqrt(np.maximum(power, 1e-300))
        least = np.diag(np.full(len(rows), DIFFUSE))
        for fold in self.folds:
            hidden, hidden_right, _ = fold.normal()
            normal, right = whole - hidden, whole_right - hidden_right
            right = right + normal @ values
            known = normal[np.ix_(rows, rows)] + np.diag(prior[rows])
            known = known * scale[:, None] * scale + least
            change = values.copy()
            change[rows] -= scale * np.linalg.solve(known, scale * right[rows])
            for channel, (gram, which) in enumerate(zip(fold.grams, fold.which, strict=True)):
                left = np.append(change[which], 1.0)
                gradient, more = np.zeros(fold.count), np.zeros((fold.count, fold.count))
                gradient[which] = gram[:-1] @ left
                more[np.ix_(which, which)] = gram[:-1, :-1]
                both = known + more[np.ix_(rows, rows)] * scale[:, None] * scale
                scaled = scale * gradient[rows]
                total[channel] += left @ gram @ left - scaled @ np.linalg.solve(both, scaled)
                total[channel] += np.linalg.slogdet(both)[1] - np.linalg.slogdet(known)[1]
        return total


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
    own, signals = of_channel(columns, misfit, channel)
    stack = np.nan_to_num(np.column_stack(signals)) * weight[:, None] / np.sqrt(noise.white)
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
    return grams, own


def fold_cells(observed: Blocks) -> np.ndarray:
    """(n,) number of the segment of each row; a move belongs to the segment after it."""
    number = observed.segment
    if (number < 0).all():
        return np.asarray((observed.t / CELL_LENGTH).astype(int))
    rows = np.flatnonzero(number >= 0)
    following = rows[np.minimum(np.searchsorted(rows, np.arange(len(number))), len(rows) - 1)]
    changes = np.diff(number[following], prepend=number[following[0]]) != 0
    return np.asarray(np.cumsum(changes))
