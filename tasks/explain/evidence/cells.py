"""A model's equations in separate cells, whose residuals are independent of one another.

Models that lack something leave residuals that hang together over seconds to minutes. Whoever
counts every block as new evidence counts the same error many times; cells are counted instead.

How well a model predicts cells that its fit did not use, every fourth one in turn, they tell too.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tasks.explain.inputs.blocks import Blocks
from tasks.explain.noise import Noise, at_blocks, frequencies, in_band, in_time, weighted
from tasks.model.fit import WhitenedEquations, of_channel
from tasks.model.term import Column

CELL_LENGTH = 30.0  # s of what has no segments, or a body moved by hand
MIN_CELLS, MAX_CELLS = 24, 120  # by which the scatter of residuals is judged
FOLDS = 4
HiddenChannel = tuple[float, np.ndarray, np.ndarray]  # misfit, gradient (q,), normal (q, q)
DIFFUSE = 1e-9  # of a column's power: what no other fold determines is as good as free


@dataclass(frozen=True)
class CellEquations:
    """Whitened products of a linearised model's columns and misfit, by channel and cell.

    grams: for each of six channels (cells, k + 1, k + 1), the misfit last. which: (k,) for each
    channel, which of the `count` columns it has.
    """

    grams: tuple[np.ndarray, ...]
    which: tuple[np.ndarray, ...]
    count: int

    @property
    def cells(self) -> int:
        return len(self.grams[0])

    def normal(self, used: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Normal matrices (cells, q, q) and right sides (cells, q); used: (cells, 6) bool."""
        normal = np.zeros((self.cells, self.count, self.count))
        right = np.zeros((self.cells, self.count))
        every = np.arange(self.cells)
        for channel, (grams, which) in enumerate(zip(self.grams, self.which, strict=True)):
            part = grams if used is None else grams * used[:, channel, None, None]
            normal[np.ix_(every, which, which)] += part[:, :-1, :-1]
            right[np.ix_(every, which)] += part[:, :-1, -1]
        return normal, right


def cell_equations(
    columns: Sequence[Column],
    misfit: np.ndarray,
    observed: Blocks,
    noises: Sequence[Noise],
    cells: np.ndarray,
) -> CellEquations:
    """The equations of columns and misfit (n, 6) by cells, (n,) the number of each row's.

    Drift joins neighbours that stand in different cells; so here it is an offset of each cell, as
    large as flicker makes it between the length of a cell and that of the run.
    """
    edges = np.searchsorted(cells, np.arange(cells[-1] + 2))
    span = len(cells) / observed.rate
    grams, every = [], []
    for channel, noise in enumerate(noises):
        which, signals = of_channel(columns, misfit, channel)
        level = observed.weight[:, channel] / np.sqrt(noise.white)
        stack = _low_passed(signals, level, observed, noise)
        own = np.zeros((len(edges) - 1, len(which) + 1, len(which) + 1))
        for n, (start, stop) in enumerate(pairwise(edges)):
            part, one = stack[start:stop], level[start:stop]
            lasts = max(stop - start, 1) / observed.rate
            offset = 2.0 * noise.flicker / observed.rate * np.log(1.0 + span / lasts)
            shared = one @ part
            share = offset / (1.0 + offset * float(one @ one))
            own[n] = part.T @ part - share * np.outer(shared, shared)
        grams.append(own)
        every.append(which)
    return CellEquations(tuple(grams), tuple(every), len(columns))


def _low_passed(
    signals: Sequence[np.ndarray], level: np.ndarray, observed: Blocks, noise: Noise
) -> np.ndarray:
    """(n, k) signals (n,) times a level (n,), without what lies above the band that is compared,
    and as much less as noise rises within it.
    """
    if observed.share == 1.0:
        return np.nan_to_num(np.column_stack(signals)) * level[:, None]
    stack = weighted(signals, level, observed)
    passed = in_band(stack, observed)
    rise = noise.rise(frequencies(passed.shape[1], stack.shape[1], observed.rate))
    return at_blocks(in_time(passed / np.sqrt(rise), stack.shape[1]), observed).T


def fold_cells(observed: Blocks) -> np.ndarray:
    """(n,) number of the segment of each row; a move belongs to the segment after it."""
    number = observed.segment
    if (number < 0).all() or observed.motion.tracking is not None:  # a hand rests nowhere for long
        return np.asarray((observed.t / CELL_LENGTH).astype(int))
    rows = np.flatnonzero(number >= 0)
    following = rows[np.minimum(np.searchsorted(rows, np.arange(len(number))), len(rows) - 1)]
    changes = np.diff(number[following], prepend=number[following[0]]) != 0
    return np.asarray(np.cumsum(changes))


def scatter_cells(observed: Blocks) -> np.ndarray:
    """(n,) number of each row's cell: those of the folds, the long ones cut in even parts where
    they are too few, neighbours put together where they are too many.
    """
    cells = fold_cells(observed)
    count = int(cells[-1]) + 1
    if count > MAX_CELLS:
        return cells * MAX_CELLS // count
    if count >= MIN_CELLS:
        return cells
    longest = len(cells) / MIN_CELLS
    numbers, first = np.zeros(len(cells), int), 0
    for start, stop in pairwise(np.searchsorted(cells, np.arange(count + 1))):
        parts = max(1, int(np.ceil((stop - start) / longest)))
        numbers[start:stop] = first + np.arange(stop - start) * parts // max(stop - start, 1)
        first += parts
    return numbers


@dataclass(frozen=True)
class CrossValidation:
    """A model's normal equations on all rows, and on each fold of them."""

    whole: WhitenedEquations
    folds: tuple[WhitenedEquations, ...]

    def deviance(self, fitted: Sequence[int], values: np.ndarray, prior: np.ndarray) -> np.ndarray:
        """−2·ln of the likelihood (6,) of each channel of a fold, as a fit to the others has it.

        What the others leave uncertain is uncertain in the prediction: e ~ N(0, 1 + J·C·Jᵀ).
        fitted: the columns that are fitted. values: (q,) of columns that are put back into the
        misfit first. prior: (q,) precision beforehand, of changes about `values`.
        """
        total = np.zeros(len(self.whole.grams))
        for known, channels in self._hidden(fitted, values, prior):
            total += [_deviance(known, *channel) for channel in channels]
        return total

    def joint_deviance(
        self, fitted: Sequence[int], values: np.ndarray, prior: np.ndarray
    ) -> tuple[float, np.ndarray]:
        """The same of all channels of a fold together; and of each channel (6,), where the others
        of the fold are known too. An uncertainty that channels share counts once so, and in
        `deviance` in each of them.
        """
        together, beside = 0.0, np.zeros(len(self.whole.grams))
        for known, channels in self._hidden(fitted, values, prior):
            whole = _deviance(known, *_summed(channels))
            together += whole
            for number in range(len(channels)):
                others = [one for c, one in enumerate(channels) if c != number]
                beside[number] += whole - _deviance(known, *_summed(others))
        return together, beside

    def _hidden(
        self, fitted: Sequence[int], values: np.ndarray, prior: np.ndarray
    ) -> Iterator[tuple[np.ndarray, list[HiddenChannel]]]:
        """Of each fold the information that the others have on the fitted columns, and its own
        equations, channel by channel; columns at unit size.
        """
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
            channels = []
            for gram, which in zip(fold.grams, fold.which, strict=True):
                left = np.append(change[which], 1.0)
                gradient, more = np.zeros(fold.count), np.zeros((fold.count, fold.count))
                gradient[which] = gram[:-1] @ left
                more[np.ix_(which, which)] = gram[:-1, :-1]
                own = more[np.ix_(rows, rows)] * scale[:, None] * scale
                channels.append((float(left @ gram @ left), scale * gradient[rows], own))
            yield known, channels


def _summed(channels: Sequence[HiddenChannel]) -> HiddenChannel:
    misfits, gradients, normals = zip(*channels, strict=True)
    return sum(misfits), np.sum(gradients, axis=0), np.sum(normals, axis=0)


def _deviance(known: np.ndarray, misfit: float, gradient: np.ndarray, normal: np.ndarray) -> float:
    """Of readings with these equations (q,), (q, q), beside what is known (q, q) beforehand."""
    both = known + normal
    volume = np.linalg.slogdet(both)[1] - np.linalg.slogdet(known)[1]
    return float(misfit - gradient @ np.linalg.solve(both, gradient) + volume)


def cross_validation(cells: CellEquations) -> CrossValidation:
    """Every fourth cell is a fold. cells: of `fold_cells`."""
    number = np.arange(cells.cells) % FOLDS
    folds = tuple(
        WhitenedEquations(
            tuple(part[number == k].sum(axis=0) for part in cells.grams), cells.which, cells.count
        )
        for k in range(FOLDS)
    )
    whole = tuple(part.sum(axis=0) for part in cells.grams)
    return CrossValidation(WhitenedEquations(whole, cells.which, cells.count), folds)
