"""Sets of runs that may have something in common: a carrier's runs, all, or since or until one."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby

import numpy as np
from scipy.sparse import csr_array, vstack

from schemas.discrepancy import LEVELS, Level
from tasks.review.hypotheses import (
    Effect,
    TermIdentity,
    back_from_unit_information,
    identity,
    members_of,
    ridged,
)
from tasks.review.pool import Group, Pool

FEWEST = 3  # runs before and after a change
MOST_WINDOWS = 500  # of one level: at more runs not every one is tried for a change


@dataclass(frozen=True)
class Window:
    """The runs of a carrier from its run number `first` on, up to but without `last`."""

    level: Level
    carrier: int
    first: int
    last: int
    count: int  # runs of the carrier

    @property
    def whole(self) -> bool:
        return self.first == 0 and self.last == self.count

    @property
    def changes(self) -> int:
        return int(self.first > 0) + int(self.last < self.count)


@dataclass(frozen=True)
class LevelWindows:
    """All windows of one level.

    pieces: (k, runs) 1 where a run of the pool is in one of the pieces of time of a carrier that
    windows are made of. low, high: (w,) first piece of each window, and the one after its last.
    """

    pieces: csr_array
    low: np.ndarray
    high: np.ndarray
    windows: tuple[Window, ...]

    @cached_property
    def carrier(self) -> np.ndarray:
        """(w,) the carrier of each window."""
        return np.array([window.carrier for window in self.windows], int)

    @cached_property
    def whole(self) -> dict[int, int]:
        """By carrier, which window has all its runs."""
        return {window.carrier: k for k, window in enumerate(self.windows) if window.whole}


def runs_of(pool: Pool, level: Level, carrier: int) -> np.ndarray:
    """(k,) numbers of a carrier's runs in the order of time."""
    return np.flatnonzero(pool.carrier[level] == carrier)


def rows_of(pool: Pool, window: Window) -> np.ndarray:
    """(runs,) bool: the runs of a window."""
    rows = np.zeros(len(pool.runs), bool)
    rows[runs_of(pool, window.level, window.carrier)[window.first : window.last]] = True
    return rows


def all_windows(pool: Pool) -> tuple[LevelWindows, ...]:
    """Every window that is tried, by level."""
    found = []
    for level in LEVELS:
        order, starts, windows = list[int](), list[int](), list[Window]()
        most = max(4, MOST_WINDOWS // max(1, len(pool.names[level])))
        for carrier in range(len(pool.names[level])):
            own = runs_of(pool, level, carrier)
            for first, last in _spans(len(own), most):
                windows.append(Window(level, carrier, first, last, len(own)))
                starts.append(len(order))
            order.extend(own.tolist())
        at = np.array(starts, int)
        low = at + np.array([w.first for w in windows], int)
        high = at + np.array([w.last for w in windows], int)
        found.append(_of_level(np.array(order, int), low, high, tuple(windows), len(pool.runs)))
    return tuple(found)


def _of_level(
    order: np.ndarray, low: np.ndarray, high: np.ndarray, windows: tuple[Window, ...], runs: int
) -> LevelWindows:
    """order: (k,) runs by carrier and time. low, high: (w,) of each window within them."""
    edges = np.unique(np.concatenate([low, high]))
    piece = np.searchsorted(edges, np.arange(len(order)), side="right") - 1
    pieces = csr_array((np.ones(len(order)), (piece, order)), (max(0, len(edges) - 1), runs))
    return LevelWindows(pieces, np.searchsorted(edges, low), np.searchsorted(edges, high), windows)


def _spans(count: int, most: int) -> Iterator[tuple[int, int]]:
    """All runs, those since one and those up to one, at most so many of each."""
    yield 0, count
    step = max(1, count // most)
    for k in range(FEWEST, count - FEWEST + 1, step):
        yield k, count
        yield 0, k


# Sums of score and information over the runs of every window.
#
# Findings are taken off the scores alone: the information, and the coordinates that follow from
# it, are summed once for all of them.

Weighed = tuple[Effect, np.ndarray]  # an effect and its `back`, as in `Evidence`


@dataclass(frozen=True)
class WindowSums:
    """What no finding changes.

    pieces: of each group (k, its runs), those of all levels, one below the other. low, high: (w,)
    first piece of each window, and the one after its last. information: of each term (k + 1, c²),
    cumulative over the pieces.
    """

    pieces: tuple[csr_array, ...]
    low: np.ndarray
    high: np.ndarray
    information: dict[TermIdentity, np.ndarray]
    effects: tuple[Weighed, ...]

    def gains(self, pool: Pool) -> Iterator[tuple[Effect, int, np.ndarray]]:
        """Every effect of which a run says something, how many numbers it has, and the chi-squared
        (w,) that a common value gains in each window, without any spread.
        """
        pairs = list(zip(self.pieces, pool.groups, strict=True))
        scores = [(group, _cumulative(pieces @ group.score)) for pieces, group in pairs]
        for effect, back in self.effects:
            right = self._within(_score(effect, scores)) @ back
            information = ridged(self._information_of(effect, back))
            yield effect, back.shape[1], quadratic_forms(information, right)

    def _information_of(self, effect: Effect, back: np.ndarray) -> np.ndarray:
        count, own = len(effect.term.parameters), np.array(effect.own)
        chosen = (own[:, None] * count + own).ravel()
        sums = self._within(self.information[identity(effect.term)])[:, chosen]
        return (sums @ np.kron(back, back)).reshape(-1, back.shape[1], back.shape[1])

    def _within(self, cumulative: np.ndarray) -> np.ndarray:
        return np.asarray(cumulative[self.high] - cumulative[self.low])


def window_sums(pool: Pool, levels: Sequence[LevelWindows]) -> WindowSums:
    """Of all effects in the windows of all levels."""
    pieces = csr_array(vstack([level.pieces for level in levels]))
    of_groups = tuple(pieces[:, group.rows] for group in pool.groups)
    starts = np.cumsum([0, *(level.pieces.shape[0] for level in levels)])[:-1]
    low, high = (
        np.concatenate(
            [start + getattr(level, end) for start, level in zip(starts, levels, strict=True)]
        )
        for end in ("low", "high")
    )
    information, effects = dict[TermIdentity, np.ndarray](), list[Weighed]()
    for term, some in groupby(pool.effects, key=lambda effect: identity(effect.term)):
        each = [
            (own, group.information(term))
            for own, group in zip(of_groups, pool.groups, strict=True)
            if term in group.starts
        ]
        flat = [(own, values.reshape(len(values), -1)) for own, values in each]
        information[term] = _cumulative(np.sum([own @ values for own, values in flat], axis=0))
        runs = np.concatenate([values for _, values in each])
        effects.extend((effect, _back(effect, runs)) for effect in some)
    determined = tuple((effect, back) for effect, back in effects if back.shape[1])
    return WindowSums(of_groups, low, high, information, determined)


def _back(effect: Effect, information: np.ndarray) -> np.ndarray:
    """`back` of an effect; information: (runs, c, c) of its term."""
    own = np.array(effect.own)
    seen = int(information.diagonal(axis1=1, axis2=2)[:, own].any(axis=1).sum())
    total = information.sum(axis=0)[own[:, None], own]
    return back_from_unit_information(total / max(1, seen))


def _score(effect: Effect, scores: Sequence[tuple[Group, np.ndarray]]) -> np.ndarray:
    """(k + 1, m) of an effect; scores: cumulative, of each group."""
    found = [(members_of(effect, group.starts), total) for group, total in scores]
    return np.asarray(sum(total[:, own] for own, total in found if own is not None))


def _cumulative(values: np.ndarray) -> np.ndarray:
    return np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])


# Operations on thousands of small symmetric positive definite matrices at once.
#
# LAPACK spends more on calling than on computing where a matrix has a few rows; here every step of
# the elimination runs over all matrices. None needs pivots.


def inverses(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Inverses (n, m, m) and logarithms of the determinants (n,) of (n, m, m), by Gauss–Jordan."""
    left = _side_by_side(matrices)
    logarithm = np.zeros(left.shape[-1])
    for k in range(len(left)):
        pivot = left[k, k].copy()
        logarithm += np.log(pivot)
        left[k, k] = 1.0
        left[k] /= pivot
        row, column = left[k].copy(), left[:, k].copy()
        column[k] = 0.0
        left[:, k] = 0.0
        left[k] = row
        left -= column[:, None] * row
    return np.ascontiguousarray(np.moveaxis(left, -1, 0)), logarithm


def quadratic_forms(matrices: np.ndarray, right: np.ndarray) -> np.ndarray:
    """(n,) rᵀ·A⁻¹·r of matrices A (n, m, m) and right sides r (n, m), by elimination."""
    left, rest = _side_by_side(matrices), np.array(right.T)
    total = np.zeros(left.shape[-1])
    for k in range(len(left)):
        total += rest[k] ** 2 / left[k, k]
        column = left[k + 1 :, k] / left[k, k]
        rest[k + 1 :] -= column * rest[k]
        left[k + 1 :, k + 1 :] -= column[:, None] * left[k, k + 1 :]
    return total


def _side_by_side(matrices: np.ndarray) -> np.ndarray:
    """A copy (m, m, n), in which the same element of all matrices is contiguous."""
    return np.array(np.moveaxis(matrices, 0, -1), order="C")
