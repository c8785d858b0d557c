"""The statistics of many runs, stacked in order of time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from schemas.discrepancy import LEVELS, Layout, Level, PooledParameter, PooledTerm, RunStatistics
from schemas.recording import Recording
from tasks.explain.explanation import EVERY
from tasks.explain.inputs.prepared import Prepared, prepare
from tasks.explain.noise import Noise
from tasks.explain.search.candidates import columns_of
from tasks.explain.search.design import (
    BandedDesign,
    ChannelDesign,
    NormalEquations,
    banded_design,
    normal_equations,
)
from tasks.explain.search.fitted import SEARCH_RATE
from tasks.explain.search.stepwise import initial_noises
from tasks.model.catalogue import catalogue
from tasks.model.fit import inverse
from tasks.model.term import Column, Term
from tasks.motion.whole import Motion
from tasks.review.hypotheses import (
    Effect,
    TermIdentity,
    effects_of,
    ground_rotation,
    identity,
    members_of,
    starts_of,
)

# The sufficient statistics of one run for the catalogue's terms, which add up over runs.
#
# Score and information of the whitened linear model, with that run's own standard parameters
# projected out (Frisch, Waugh, Lovell). Sums over runs are those of one long recording in which
# every run has a standard model of its own.

VERSION = 2  # of these statistics: another one is made again
STEP = 32767  # of a correlation of one
SLOW = 1.0  # Hz: where physics that is left would be, and most noise is not
BELIEVED = 1.3  # chi-squared per degree of freedom from which on it is not chance


def statistics_of(recording: Recording) -> RunStatistics:
    """The statistics of a run. Raises Unusable where `explain` would.

    Events and faults of the logger are removed first, as by `explain`; a delay of the stamps stays
    in the readings, since it may be common to many runs.
    """
    return statistics_from(prepare(recording, delay_sought=False))


def statistics_from(prepared: Prepared) -> RunStatistics:
    """The same of a prepared run, which was neither set against a reference nor shifted in time."""
    blocks = prepared.blocks(SEARCH_RATE)
    terms, columns = _terms_and_columns(prepared.recording, blocks.motion)
    every = [column for some in columns for column in some]
    design = banded_design(blocks, blocks.readings, every, np.full(len(every), np.inf))
    noises = initial_noises(design)
    left_over = np.array(
        [_left_over(design, c, n) for c, n in zip(design.channels, noises, strict=True)]
    )
    against = [n.at_rate(max(1.0, phi)) for n, phi in zip(noises, left_over, strict=True)]
    return _packed(layout_of(terms, columns), normal_equations(design, against), left_over)


def _terms_and_columns(
    recording: Recording, motion: Motion
) -> tuple[list[Term], list[tuple[Column, ...]]]:
    """The catalogue's terms but those that act at a time of their own in each run."""
    listed = [term for term in catalogue(recording, motion) if not _own_time(term)]
    terms = [*listed, *ground_rotation(recording)]
    return terms, [columns_of(term, motion) for term in terms]


def _own_time(term: Term) -> bool:
    """A step at some instant, or a random walk: nothing of it is the same in the next run."""
    random = term.time_course in ("jump", "random walk")
    return random or "time" in [shape.name for shape in term.shapes]


def layout_of(terms: Sequence[Term], columns: Sequence[tuple[Column, ...]]) -> Layout:
    """What the parameters of some terms are; columns: of each."""
    return Layout(terms=tuple(_pooled(t, c) for t, c in zip(terms, columns, strict=True)))


def _pooled(term: Term, columns: Sequence[Column]) -> PooledTerm:
    listed = [(p.name, p.unit, p.factor, *p.plausible) for p in term.parameters]
    parameters = [
        PooledParameter(
            name=name,
            unit=unit,
            factor=factor,
            low=low,
            high=high,
            channels=_channels(term, column),
        )
        for (name, unit, factor, low, high), column in zip(
            listed or [("factor", "1", 1.0, 0.0, 2.0)], columns, strict=True
        )
    ]
    return PooledTerm(
        name=term.name, family=term.family, at=term.at, rarity=term.rarity,
        known=not term.parameters, parameters=tuple(parameters),
    )  # fmt: skip


def _channels(term: Term, column: Column) -> tuple[int, ...]:
    """Which channels read a parameter: of a motion all, however little some of them follow it."""
    if term.stage == "sensor" or not column:
        return tuple(sorted(column))
    return EVERY


def _packed(layout: Layout, equations: NormalEquations, left_over: np.ndarray) -> RunStatistics:
    triangle = equations.normal[np.triu_indices(len(equations.scale))]
    return RunStatistics(
        layout,
        layout.key,
        np.round(np.clip(triangle, -1.0, 1.0) * STEP).astype(np.int16),
        equations.right.astype(np.float32),
        equations.scale.astype(np.float32),
        left_over.astype(np.float32),
    )


def _left_over(design: BandedDesign, channel: ChannelDesign | None, noise: Noise) -> float:
    """Chi-squared per degree of freedom below 1 Hz; one where chance might have made it."""
    if channel is None:
        return 1.0
    slow = design.bands.frequency < SLOW
    variance = noise.variance(design.bands.frequency[slow])
    gram = np.tensordot(1.0 / variance, channel.grams[slow], axes=1).astype(float)
    solved = inverse(gram[:-1, :-1])
    left = gram[-1, -1] - gram[-1, :-1] @ solved @ gram[:-1, -1]
    taken = float(np.trace(solved @ gram[:-1, :-1]))
    ratio = float(left) / max(design.bands.sizes[slow].sum() - taken, 1.0)
    return ratio if ratio > BELIEVED else 1.0


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
