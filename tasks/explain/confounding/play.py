"""Tells a unit that has play in its fixture, and tips from side to side, from one that bends."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from tasks.explain.confounding.combinations import Combination
from tasks.explain.confounding.linear_forms import DISTINGUISHABLE, LinearForms
from tasks.explain.search.candidates import Candidate, columns_of
from tasks.explain.search.empirical_terms import Tip
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.whitening import equations_of
from tasks.model.regression import inverse
from tasks.model.term import Column

TILTING = ("structural_compliance", "remount_misalignment")
STEPS = (0.6, 0.3, 0.15, 0.08)  # rad by which the direction is improved, one after another
AROUND = np.arange(0.0, 2.0 * np.pi, np.pi / 3.0)
DIRECTION = 2  # parameters that a direction is


def with_play(fit: FittedSelection, candidates: Sequence[Candidate]) -> FittedSelection:
    """The selection, an effect that tilts the unit replaced by play where that fits as well.

    What tips over by one angle as gravity pulls it the other way, is in level positions a bending
    in proportion to the force, and an attitude of each mounting's own; both have more parameters.
    """
    named = [one for one in fit.selection.selected if one.candidate.name in TILTING]
    tips = [one for one in candidates if isinstance(one.term, Tip)]
    if not named or not tips or any(one.absorbed_by for one in named):
        return fit
    members = (_best_tip(fit.without(named), tips),)
    tipping = Combination.of(members, TILTING, fit)
    bending = Combination(tuple(one.candidate for one in named), fit)
    linear = LinearForms(TILTING, (members,), fit)
    dearer = linear.price * (tipping.parameter_count + DIRECTION - bending.parameter_count)
    worse = (tipping.chi2 - bending.chi2) / linear.dispersion
    return tipping.fit if worse + dearer < DISTINGUISHABLE else fit


def _best_tip(rest: FittedSelection, tips: Sequence[Candidate]) -> Candidate:
    """The tip that gains most beside the rest, in the best direction."""
    terms = [one.term for one in tips if isinstance(one.term, Tip)]
    gains = _gains(rest, [term.direction for term in terms])
    number = int(np.argmax(gains))
    best, most = terms[number].direction, max(gains)
    for step in STEPS:
        directions = list(_around(best, step))
        gains = _gains(rest, directions)
        if max(gains) > most:
            best, most = directions[int(np.argmax(gains))], max(gains)
    return replace(tips[number], term=terms[number].towards(best), fitted=True)


def _around(direction: np.ndarray, step: float) -> Iterator[np.ndarray]:
    """Directions on a circle about another."""
    across = np.linalg.svd(direction[None])[2][1:]
    for angle in AROUND:
        side = np.cos(angle) * across[0] + np.sin(angle) * across[1]
        yield np.cos(step) * direction + np.sin(step) * side


def _gains(rest: FittedSelection, directions: Sequence[np.ndarray]) -> list[float]:
    """Chi-squared that a tip along each direction takes away beside the rest, to first order."""
    model, blocks = rest.model, rest.blocks
    design = model.linearised(blocks.motion, model.free)
    base: list[Column] = [design.columns[p] for p in np.flatnonzero(model.free)]
    own = [columns_of(Tip.along(one), blocks.motion) for one in directions]
    misfit = blocks.readings - design.prediction
    every = [*base, *(column for columns in own for column in columns)]
    normal, right, _ = equations_of(every, misfit, blocks, rest.noises).normal()
    shared, first = np.arange(len(base)), len(base)
    gains = []
    for columns in own:
        rows = np.concatenate([shared, np.arange(first, first + len(columns))])
        first += len(columns)
        gains.append(float(right[rows] @ inverse(normal[np.ix_(rows, rows)]) @ right[rows]))
    return gains
