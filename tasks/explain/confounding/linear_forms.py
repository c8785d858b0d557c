"""Gain and cost of the effects of a family in linear form, by the equations of the search."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tasks.explain.confounding.combinations import Combination, dispersion_of, price_of
from tasks.explain.confounding.delays import Form
from tasks.explain.noise import weighted, whitened
from tasks.explain.search.candidates import Candidate, columns_of
from tasks.explain.search.empirical import Tip
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import joint_gain
from tasks.model.fit import WhitenedEquations, inverse, of_channel

# Chi-squared that tells two apart: where ramps are sharp, smoothing the reference makes twenty.
DISTINGUISHABLE = 30.0
FORM = 0.02  # of an effect: what its published equation and a real filter or clock differ by


@dataclass(frozen=True)
class LinearForms:
    """The forms of a family's effects beside everything else that a fit has."""

    names: tuple[str, ...]
    forms: tuple[Form, ...]
    fit: FittedSelection

    def gain(self, members: Form) -> float:
        """Chi-squared that the members take away together."""
        selection = self.fit.selection
        others = [one for one in selection.candidates if one.name not in self.names]
        return joint_gain(selection.equations, members, others)

    @cached_property
    def distinguishable(self) -> float:
        """Chi-squared that separates exact forms: more than the errors of their linear
        equations.
        """
        return max(DISTINGUISHABLE, FORM**2 * self.largest_gain / self.dispersion)

    @cached_property
    def largest_gain(self) -> float:
        """Chi-squared that a form alone takes away."""
        return max(map(self.gain, self.forms))

    @cached_property
    def dispersion(self) -> float:
        """As `dispersion_of` has it, of the fit."""
        return dispersion_of(self.fit)

    @cached_property
    def price(self) -> float:
        """As `price_of` has it, of the fit."""
        return price_of(self.fit)

    @cached_property
    def triads_differ(self) -> bool:
        """Whether gyros and accelerometers have different delays, as linear forms show.

        For filters alone: a long delay and a filter differ in their linear forms already.
        """
        both = next((form for form in self.forms if is_by_triad(form)), None)
        whole = next((form for form in self.forms
                      if form[0].name == "bandwidth" and form is not both), None)  # fmt: skip
        if both is None or whole is None:
            return both is not None
        return self.gain(both) - self.gain(whole) > DISTINGUISHABLE * self.dispersion


def marked(
    chosen: Combination, group: tuple[str, ...], rivals: tuple[str, ...] = ()
) -> FittedSelection:
    """The chosen combination's selection, its members with the names of a group and of rivals."""
    own, selection = keys_of(chosen.members), chosen.fit.selection
    selected = tuple(
        replace(one, group=group, rivals=tuple(dict.fromkeys((*one.rivals, *rivals))))
        if one.candidate.key in own
        else one
        for one in selection.selected
    )
    return replace(chosen.fit, selection=replace(selection, selected=selected))


def group_names(best: Form, names: Iterable[tuple[str, ...]]) -> tuple[str, ...]:
    """All the names, those of the best first; empty where there are no others.

    What is as good with the best and something more says nothing of what is more.
    """
    own = names_of(best)
    others = [some for some in names if not set(own) <= set(some)]
    return (
        tuple(dict.fromkeys([*own, *(name for some in others for name in some)])) if others else ()
    )


def is_by_triad(form: Form) -> bool:
    """Whether it is a low-pass of each triad's own."""
    return form[0].name == "bandwidth" and len(form[0].term.parameters) > 1


def names_of(members: Form) -> tuple[str, ...]:
    """The effects' names, each once."""
    return tuple(dict.fromkeys(one.name for one in members))


def keys_of(members: Form) -> set[object]:
    """The candidates' keys."""
    return {one.key for one in members}


# Tells a unit that has play in its fixture, and tips from side to side, from one that bends.

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
