"""Tells a unit that has play in its fixture, and tips from side to side, from one that bends."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tasks.explain.confounding.combinations import Combination, dispersion_of, price_of
from tasks.explain.confounding.linear_forms import DISTINGUISHABLE
from tasks.explain.search.candidates import Candidate, columns_of
from tasks.explain.search.empirical_terms import Tip
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.whitening import weighted, whitened
from tasks.model.regression import WhitenedEquations, inverse, of_channel

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
    rest = fit.model.without({one.candidate.term.key for one in named})
    members = (_best_tip(replace(fit, model=rest), tips),)
    tipping = Combination.of(members, TILTING, fit)
    bending = Combination(tuple(one.candidate for one in named), fit)
    dearer = price_of(fit) * (tipping.parameter_count + DIRECTION - bending.parameter_count)
    worse = (tipping.chi2 - bending.chi2) / dispersion_of(fit)
    return tipping.fit if worse + dearer < DISTINGUISHABLE else fit


def _best_tip(rest: FittedSelection, tips: Sequence[Candidate]) -> Candidate:
    """The tip that gains most beside the rest, in the best direction."""
    terms = [one.term for one in tips if isinstance(one.term, Tip)]
    beside = _Beside.of(rest)
    gains = [beside.gain(term.direction) for term in terms]
    number = int(np.argmax(gains))
    best, most = terms[number].direction, max(gains)
    for step in STEPS:
        directions = list(_around(best, step))
        gains = [beside.gain(direction) for direction in directions]
        if max(gains) > most:
            best, most = directions[int(np.argmax(gains))], max(gains)
    return replace(tips[number], term=terms[number].towards(best), fitted=True)


def _around(direction: np.ndarray, step: float) -> Iterator[np.ndarray]:
    """Directions on a circle about another."""
    across = np.linalg.svd(direction[None])[2][1:]
    for angle in AROUND:
        side = np.cos(angle) * across[0] + np.sin(angle) * across[1]
        yield np.cos(step) * direction + np.sin(step) * side


@dataclass(frozen=True)
class _Beside:
    """A fit, linearised and whitened once, beside which tips are tried.

    rows: for each of six channels its columns and, last, its misfit (k + 1, m); which: (k,) for
    each channel, which of the `normal` matrix's columns it has. right: (q,).
    """

    fit: FittedSelection
    rows: tuple[np.ndarray, ...]
    which: tuple[np.ndarray, ...]
    normal: np.ndarray
    right: np.ndarray

    @classmethod
    def of(cls, fit: FittedSelection) -> "_Beside":
        model, blocks = fit.model, fit.blocks
        design = model.linearised(blocks.motion, model.free)
        columns = [design.columns[p] for p in np.flatnonzero(model.free)]
        which, rows = [], []
        for channel, noise in enumerate(fit.noises):
            own, signals = of_channel(columns, blocks.readings - design.prediction, channel)
            stack = weighted(signals, blocks.weight[:, channel], blocks)
            which.append(own)
            rows.append(whitened(stack, blocks, noise))
        grams = tuple(each @ each.T for each in rows)
        normal, right, _ = WhitenedEquations(grams, tuple(which), len(columns)).normal()
        return cls(fit, tuple(rows), tuple(which), normal, right)

    def gain(self, direction: np.ndarray) -> float:
        """Chi-squared that a tip along a direction takes away, to first order."""
        blocks, count = self.fit.blocks, len(self.right)
        own = columns_of(Tip.along(direction), blocks.motion)
        normal = np.pad(self.normal, (0, len(own)))
        right = np.pad(self.right, (0, len(own)))
        for channel, noise in enumerate(self.fit.noises):
            mine = [q for q, column in enumerate(own) if channel in column]
            if not mine:
                continue
            signals = [own[q][channel] for q in mine]
            stack = weighted(signals, blocks.weight[:, channel], blocks)
            tip = whitened(stack, blocks, noise)
            rows, which = self.rows[channel], self.which[channel]
            place = count + np.array(mine, int)
            normal[np.ix_(place, place)] += tip @ tip.T
            crossed = tip @ rows.T
            normal[np.ix_(place, which)] += crossed[:, :-1]
            normal[np.ix_(which, place)] += crossed[:, :-1].T
            right[place] += crossed[:, -1]
        return float(right @ inverse(normal) @ right)
