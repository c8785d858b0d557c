"""The statistics of many runs side by side, in the order of time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from schemas.review import LEVELS, Layout, Level, RunStatistics
from tasks.review.hypotheses import Effect, TermIdentity, effects_of, members_of, starts_of
from tasks.review.statistics import STEP


@dataclass(frozen=True)
class ReviewedRun:
    """Whose run it is, and when.

    at: `acquired_at`, else the recording's name; runs are ordered by it. carriers: by level, what
    of each level it belongs to; a level that its manifest does not tell is left out.
    """

    run: str
    at: str
    carriers: dict[Level, str]


@dataclass(frozen=True)
class Group:
    """Runs of one layout. rows: (k,) their numbers in the pool. Arrays as in `RunStatistics`."""

    layout: Layout
    rows: np.ndarray
    correlation: np.ndarray
    right: np.ndarray
    scale: np.ndarray

    @cached_property
    def starts(self) -> Mapping[TermIdentity, int]:
        """Where each term's parameters begin."""
        return starts_of(self.layout)

    @cached_property
    def inverse(self) -> np.ndarray:
        """(k, p) of the scale; zero where the run says nothing."""
        return np.divide(1.0, self.scale, out=np.zeros_like(self.scale), where=self.scale > 0)


@dataclass(frozen=True)
class Pool:
    """Runs in the order of time with their statistics.

    carrier: by level (runs,) the number of each run's carrier among the `names`; −1: not told.
    """

    runs: tuple[ReviewedRun, ...]
    groups: tuple[Group, ...]
    carrier: dict[Level, np.ndarray]
    names: dict[Level, tuple[str, ...]]
    effects: tuple[Effect, ...]

    @property
    def unit(self) -> np.ndarray:
        """(runs,) number of each run's unit."""
        return self.carrier["unit"]

    def evidence(self, effect: Effect) -> tuple[np.ndarray, np.ndarray]:
        """Score (runs, m) and information (runs, m, m) of an effect, SI; zero where none."""
        size = len(effect.own)
        score, information = (
            np.zeros((len(self.runs), size)),
            np.zeros((len(self.runs), size, size)),
        )
        for group in self.groups:
            members = members_of(effect, group.starts)
            if members is None:
                continue
            own = np.array(members)
            inverse = group.inverse[:, own]
            score[group.rows] = group.right[:, own] * inverse
            correlation = group.correlation[:, _places(own, own, group.right.shape[1])] / STEP
            information[group.rows] = correlation * inverse[:, :, None] * inverse[:, None, :]
        return score, information

    def less(self, effect: Effect, values: np.ndarray, rows: np.ndarray) -> "Pool":
        """The same without an effect of values (m,) SI in some of the runs (runs,) bool."""
        groups = []
        for group in self.groups:
            members = members_of(effect, group.starts)
            if members is None or not rows[group.rows].any():
                groups.append(group)
                continue
            own, count = np.array(members), group.right.shape[1]
            at_unit = values * group.inverse[:, own]
            crossed = group.correlation[:, _places(np.arange(count), own, count)] / STEP
            taken = np.einsum("rpm,rm->rp", crossed, at_unit) * rows[group.rows][:, None]
            groups.append(replace(group, right=group.right - taken))
        return replace(self, groups=tuple(groups))


def pooled(runs: Sequence[tuple[ReviewedRun, RunStatistics]]) -> Pool:
    """Runs with their statistics, brought into the order of time."""
    ordered = sorted(runs, key=lambda pair: (pair[0].at, pair[0].run))
    by_layout: dict[str, list[int]] = {}
    for row, (_, statistics) in enumerate(ordered):
        by_layout.setdefault(statistics.layout_key, []).append(row)
    groups = tuple(
        Group(
            ordered[rows[0]][1].layout,
            np.array(rows),
            np.stack([ordered[r][1].correlation for r in rows]),
            np.stack([ordered[r][1].right for r in rows]).astype(float),
            np.stack([ordered[r][1].scale for r in rows]).astype(float),
        )
        for rows in by_layout.values()
    )
    who = tuple(run for run, _ in ordered)
    names = {
        level: tuple(sorted({run.carriers[level] for run in who if level in run.carriers}))
        for level in LEVELS
    }
    carrier = {level: _numbers(who, level, names[level]) for level in LEVELS}
    return Pool(who, groups, carrier, names, effects_of(group.layout for group in groups))


def _numbers(runs: Sequence[ReviewedRun], level: Level, names: Sequence[str]) -> np.ndarray:
    """(runs,) number of each run's carrier of a level; −1 where none is told."""
    place = {name: number for number, name in enumerate(names)}
    return np.array([place.get(run.carriers.get(level, ""), -1) for run in runs])


def _places(some: np.ndarray, others: np.ndarray, count: int) -> np.ndarray:
    """(k, m) places of pairs of parameters in the upper triangle of (count, count)."""
    low, high = np.minimum(some[:, None], others), np.maximum(some[:, None], others)
    return np.asarray(low * count - low * (low + 1) // 2 + high)
