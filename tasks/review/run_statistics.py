"""The sufficient statistics of one run for the catalogue's terms, which add up over runs.

Score and information of the whitened linear model, with that run's own standard parameters
projected out (Frisch, Waugh, Lovell). Sums over runs are those of one long recording in which
every run has a standard model of its own.
"""

from collections.abc import Sequence

import numpy as np

from schemas.recording import Recording
from schemas.review import Layout, PooledParameter, PooledTerm, RunStatistics
from tasks.explain.channels import EVERY
from tasks.explain.inputs.prepared import Prepared, prepare
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
from tasks.explain.whitening import Noise
from tasks.model.catalogue import catalogue
from tasks.model.regression import inverse
from tasks.model.term import Column, Term
from tasks.motion.whole import Motion
from tasks.review.earth_rotation import ground_rotation

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
