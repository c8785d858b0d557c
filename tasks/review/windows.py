"""Sets of runs that may have something in common: a carrier's runs, all, or since or until one."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from schemas.review import LEVELS, Level
from tasks.review.pool import Pool

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
