"""The statistics of many runs, stacked in order of time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from schemas.review import LEVELS, Layout, Level, RunStatistics
from tasks.review.hypotheses import (
    Effect,
    TermIdentity,
    effects_of,
    identity,
    members_of,
    starts_of,
)
from tasks.review.run_statistics import STEP


@dataclass(frozen=True)
class ReviewedRun:
    """The carriers of a run, and its time.

    at: `acquired_at`, else the recording's name; runs are ordered by it. carriers: by level, the
    carrier it belongs to; a level that its manifest omits is left out.
    """

    run: str
    at: str
    carriers: dict[Level, str]


@dataclass(frozen=True)
class Group:
    """Runs of one layout. rows: (k,) their numbers in the pool.

    correlation: as in `RunStatistics`, of each run its own, which only what is found needs whole.
    within: (k, …) what a search needs of them, the parameters of each term with each other, term
    after term. score: (k, p) SI. inverse: (k, p) of the scale; zero where the run says nothing.
    """

    layout: Layout
    rows: np.ndarray
    correlation: tuple[np.ndarray, ...]
    within: np.ndarray
    score: np.ndarray
    inverse: np.ndarray

    @cached_property
    def starts(self) -> Mapping[TermIdentity, int]:
        """Where each term's parameters begin."""
        return starts_of(self.layout)

    @cached_property
    def blocks(self) -> Mapping[TermIdentity, slice]:
        """Where each term's parameters stand in `within`."""
        sizes = [len(term.parameters) ** 2 for term in self.layout.terms]
        ends = np.cumsum(sizes).tolist()
        return {
            identity(term): slice(end - size, end)
            for term, size, end in zip(self.layout.terms, sizes, ends, strict=True)
        }

    def information(self, term: TermIdentity) -> np.ndarray:
        """(k, c, c) of the parameters of a term that the layout has, SI."""
        block = self.within[:, self.blocks[term]]
        count = round(block.shape[1] ** 0.5)
        start = self.starts[term]
        inverse = self.inverse[:, start : start + count] / STEP**0.5
        size = (len(block), count, count)
        return block.reshape(size) * inverse[:, :, None] * inverse[:, None, :]

    def evidence(self, effect: Effect) -> tuple[np.ndarray, np.ndarray]:
        """Score (k, m) and information (k, m, m) of an effect that the layout has, SI."""
        term, own = identity(effect.term), np.array(effect.own)
        score = self.score[:, self.starts[term] + own]
        return score, self.information(term)[:, own[:, None], own]


@dataclass(frozen=True)
class Pool:
    """Runs in order of time with their statistics.

    carrier: by level (runs,) the number of each run's carrier among the `names`; −1: unknown.
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
            if members_of(effect, group.starts) is not None:
                score[group.rows], information[group.rows] = group.evidence(effect)
        return score, information

    def shared(self, effect: Effect, other: Effect, rows: np.ndarray) -> np.ndarray:
        """(k, m, n) information that two effects share in some runs (k,), SI; zero where none."""
        found = np.zeros((len(self.runs), len(effect.own), len(other.own)))
        wanted = set(rows.tolist())
        for group in self.groups:
            own, others = (members_of(each, group.starts) for each in (effect, other))
            if own is None or others is None:
                continue
            places = _places(np.array(own), np.array(others), group.score.shape[1])
            for k, row in enumerate(group.rows.tolist()):
                if row in wanted:
                    inverse = group.inverse[k]
                    found[row] = group.correlation[k][places] / STEP
                    found[row] *= inverse[own][:, None] * inverse[others]
        return found[rows]

    def less(self, effect: Effect, values: np.ndarray, rows: np.ndarray) -> "Pool":
        """The same without an effect of values (m,) SI in some of the runs (runs,) bool."""
        groups = []
        for group in self.groups:
            members = members_of(effect, group.starts)
            if members is None or not rows[group.rows].any():
                groups.append(group)
                continue
            own, count = np.array(members), group.score.shape[1]
            at_unit = values * group.inverse[:, own] / STEP
            places, score = _places(np.arange(count), own, count), group.score.copy()
            for k in np.flatnonzero(rows[group.rows]):
                score[k] -= (group.correlation[k][places] @ at_unit[k]) * group.inverse[k]
            groups.append(replace(group, score=score))
        return replace(self, groups=tuple(groups))


def pooled(runs: Sequence[tuple[ReviewedRun, RunStatistics]]) -> Pool:
    """Runs with their statistics, brought into the order of time."""
    ordered = sorted(runs, key=lambda pair: (pair[0].at, pair[0].run))
    by_layout: dict[str, list[int]] = {}
    for row, (_, statistics) in enumerate(ordered):
        by_layout.setdefault(statistics.layout_key, []).append(row)
    groups = tuple(
        _group(np.array(rows), [ordered[r][1] for r in rows]) for rows in by_layout.values()
    )
    who = tuple(run for run, _ in ordered)
    names = {
        level: tuple(sorted({run.carriers[level] for run in who if level in run.carriers}))
        for level in LEVELS
    }
    carrier = {level: _numbers(who, level, names[level]) for level in LEVELS}
    return Pool(who, groups, carrier, names, effects_of(group.layout for group in groups))


def _group(rows: np.ndarray, some: Sequence[RunStatistics]) -> Group:
    layout, places, start = some[0].layout, list[np.ndarray](), 0
    count = len(some[0].right)
    for term in layout.terms:
        own = np.arange(start, start + len(term.parameters))
        places.append(_places(own, own, count).ravel())
        start += len(own)
    picked = np.concatenate([np.zeros(0, int), *places])
    scale = np.stack([each.scale for each in some]).astype(float)
    inverse = np.divide(1.0, scale, out=np.zeros_like(scale), where=scale > 0)
    return Group(
        layout,
        rows,
        tuple(each.correlation for each in some),
        np.stack([each.correlation[picked] for each in some]),
        np.stack([each.right for each in some]) * inverse,
        inverse,
    )


def _numbers(runs: Sequence[ReviewedRun], level: Level, names: Sequence[str]) -> np.ndarray:
    """(runs,) number of each run's carrier at a level; −1 if unknown."""
    place = {name: number for number, name in enumerate(names)}
    return np.array([place.get(run.carriers.get(level, ""), -1) for run in runs])


def _places(some: np.ndarray, others: np.ndarray, count: int) -> np.ndarray:
    """(k, m) places of pairs of parameters in the upper triangle of (count, count)."""
    low, high = np.minimum(some[:, None], others), np.maximum(some[:, None], others)
    return np.asarray(low * count - low * (low + 1) // 2 + high)
