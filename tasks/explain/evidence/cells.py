"""A model's equations in separate cells, whose residuals are independent of one another.

Models that lack something leave residuals that hang together over seconds to minutes. Whoever
counts every block as new evidence counts the same error many times; cells are counted instead.

How well a model predicts cells that its fit did not use, every fourth one in turn, they tell too.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.stats import chi2

from tasks.explain.inputs.blocks import Blocks
from tasks.explain.noise import Noise, at_blocks, frequencies, in_band, in_time, weighted
from tasks.model.fit import WhitenedEquations, inverse, of_channel
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


# What the scatter between the cells of a recording means for each finding of a fit.
#
# How much the cells of a recording disagree on some parameters, relative to their noise.
#
# The covariance of a fit in a wrong model is the sandwich: the scatter between independent cells of
# what each cell asks of the parameters. With few cells a plain sandwich is too small by what each
# cell took part in the fit; that is made up for (Bell and McCaffrey 2002, bias-reduced
# linearisation). The other columns are projected out first (Frisch, Waugh, Lovell).

CHANCE = 1e-3  # that cells scatter so far by noise alone: from there on they are believed
WITHIN = 1.3  # of the variance of noise: nearer to it a model of the noise is right
MOST_LEVERAGE = 0.98  # of one cell: what it alone determines cannot be held against others


@dataclass(frozen=True)
class CellInfluence:
    """What each cell asks of k parameters beside all the others of a fit.

    information: (k, k) of all cells and what is known beforehand. by_cell: (cells, k, k) of each.
    scores: (cells, k) by which a cell pulls the parameters off their common values.
    """

    information: np.ndarray
    by_cell: np.ndarray
    scores: np.ndarray

    @cached_property
    def covariance(self) -> np.ndarray:
        """(k, k) as the noise of the model has it."""
        return inverse(self.information)

    @cached_property
    def effective_cells(self) -> np.ndarray:
        """(k,) number of equal cells that would carry as much information on each parameter."""
        shares = np.diagonal(self.by_cell, axis1=1, axis2=2)
        squares = (shares**2).sum(axis=0)
        return np.divide(
            shares.sum(axis=0) ** 2, squares, out=np.zeros(len(squares)), where=squares > 0
        )

    @cached_property
    def _root(self) -> np.ndarray:
        """(k, k) root of the covariance as the noise of the model has it."""
        values, vectors = np.linalg.eigh(self.covariance)
        return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)) @ vectors.T)

    @cached_property
    def scatter(self) -> np.ndarray:
        """(k, k) covariance by the scatter of the cells, in units in which `covariance` is one."""
        root = self._root
        leverage = root @ self.by_cell @ root
        own, turned = np.linalg.eigh(leverage)
        stretched = 1.0 / np.sqrt(1.0 - np.clip(own, 0.0, MOST_LEVERAGE))
        asked = np.einsum("cji,cj->ci", turned, self.scores @ root) * stretched
        pulls = np.einsum("cij,cj->ci", turned, asked)
        return np.asarray(pulls.T @ pulls)

    @cached_property
    def robust_covariance(self) -> np.ndarray:
        """(k, k) by the scatter of the cells."""
        return np.asarray(self._root @ self.scatter @ self._root)

    @property
    def dispersion(self) -> float:
        """φ: the mean of the scatter beside the model's; 1 where chance might have made it."""
        return self._dispersion[0]

    @property
    def degrees(self) -> float:
        """Of freedom with which φ is known; infinite where it is one."""
        return self._dispersion[1]

    @cached_property
    def _dispersion(self) -> tuple[float, float]:
        count = int((np.diag(self.covariance) > 0).sum())
        if not count:
            return 1.0, np.inf
        ratio = float(np.trace(self.scatter)) / count
        degrees = max(float(self.effective_cells.sum()), 1.0)
        believed = ratio > WITHIN and chi2.sf(ratio * degrees, degrees) < CHANCE
        return (ratio, degrees) if believed else (1.0, np.inf)


def cell_influence(
    normal: np.ndarray,
    right: np.ndarray,
    own: Sequence[int] | np.ndarray,
    prior: np.ndarray,
    values: np.ndarray,
) -> tuple[CellInfluence, np.ndarray]:
    """What each cell asks of some parameters, and their change (k,) to the common optimum.

    normal, right: (cells, q, q) and (cells, q) of a model linearised at `values` (q,); prior: (q,)
    precision beforehand, of values about zero.
    """
    whole = normal.sum(axis=0) + np.diag(prior)
    mine = np.asarray(own, int)
    others = np.setdiff1d(np.arange(len(prior)), mine)
    change = inverse(whole) @ (right.sum(axis=0) - prior * values)
    left = right - normal @ change
    project = np.zeros((len(mine), len(prior)))
    project[np.arange(len(mine)), mine] = 1.0
    if len(others):
        rest = inverse(whole[np.ix_(others, others)])
        project[:, others] = -whole[np.ix_(mine, others)] @ rest
    influence = CellInfluence(
        information=project @ whole @ project.T,
        by_cell=project @ normal @ project.T,
        scores=left @ project.T,
    )
    return influence, change[mine]
