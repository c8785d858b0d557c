"""Fits a combination of mutually compensating effects together with everything else."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tasks.explain.confounding.delays import (
    Form,
    delay_of_low_pass,
    group_delays,
    shape_count,
    starting_values,
)
from tasks.explain.noise import equations_of
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.fitted import FittedSelection, fitted
from tasks.explain.search.stepwise import Selected, Selection
from tasks.model.fit import inverse
from tasks.model.model import Model
from tasks.model.term import Term

STRETCH = 30.0  # s of what has no segments
CANCELLED = 0.5  # of the larger of two delays: less is left where one cancels the other


@dataclass(frozen=True)
class Combination:
    """Members of a family, fitted in their real form with everything else that was selected."""

    members: Form
    fit: FittedSelection

    @classmethod
    def of(cls, members: Form, family: Sequence[str], start: FittedSelection) -> "Combination":
        """The members in the place of whatever `start` has of the family."""
        new = [one.term for one in members if one.term.key not in start.model.places]
        delays = group_delays(start.model, family)
        if any(delays) and new:
            start = replace(start, model=_late(members, family, delays, start))
        return cls(members, start.reselected(_exchanged(members, family, start)))

    @cached_property
    def chi2(self) -> float:
        """Chi-squared of the residual."""
        return chi2_of(self.fit.model, self.fit)

    @property
    def count(self) -> int:
        """Of the members' parameters."""
        return sum(len(one.own) for one in self.members)

    @property
    def parameter_count(self) -> int:
        """Of all that is selected, the members and the rest."""
        return sum(len(one.own) for one in self.fit.selection.candidates)

    @property
    def fitted_count(self) -> int:
        """Of these parameters and the members' shapes, each as free as a parameter."""
        return self.parameter_count + shape_count(self.members)

    @property
    def effect_count(self) -> int:
        """Of all that is selected, the members and the rest."""
        return len({one.name for one in self.fit.selection.candidates})

    @property
    def plausible(self) -> bool:
        """Whether all parameters of the members are within the range of a working unit, and none
        cancels another.
        """
        values, places = self.fit.model.values, self.fit.model.places
        if self.is_cancelled:
            return False
        return all(
            low <= values[places[one.term.key].start + q] <= high
            for one in self.members
            for q in one.own
            for low, high in [one.term.parameters[q].plausible]
        )

    @property
    def is_cancelled(self) -> bool:
        """Whether a lead of the clocks cancels a low-pass.

        Mostly these shape errors of the reference, or resonances, and hardly amount to a delay.
        """
        delays = [
            max(group_delays(self.fit.model, [name]), key=abs)
            for name in ("time_offset", "bandwidth")
            if any(one.name == name for one in self.members)
        ]
        return len(delays) == 2 and abs(sum(delays)) < CANCELLED * max(map(abs, delays))

    def promises(self, others: Sequence[Form]) -> list[float]:
        """Chi-squared that each of some forms more promises to take away, by a linear step from
        where the fit is; none where it leads below zero. All by one linearisation.
        """
        longer = self._with([one for form in others for one in form])
        design = longer.linearised(self.fit.blocks.motion, longer.free)
        free = np.flatnonzero(longer.free)
        misfit = self.fit.blocks.readings - design.prediction
        columns = [design.columns[p] for p in free]
        normal, right, _ = equations_of(columns, misfit, self.fit.blocks, self.fit.noises).normal()
        base = np.isin(free, np.flatnonzero(self.fit.model.free))
        gains = []
        for form in others:
            mine = [longer.places[one.term.key].start + q for one in form for q in one.own]
            rows = np.flatnonzero(base | np.isin(free, mine))
            change = np.zeros(len(longer.values))
            change[free[rows]] = inverse(normal[np.ix_(rows, rows)]) @ right[rows]
            stepped = replace(longer, values=longer.values + change)
            gains.append(0.0 if stepped.negative.any() else float(change[free[rows]] @ right[rows]))
        return gains

    def promise_of_filter(self, low_pass: Term, more: float) -> float:
        """Chi-squared that a filter of the time constants `more` (s) promises to take away in the
        place of as much of the delay, by what the readings become, times a size above nothing.
        """
        model, blocks = self.fit.model, self.fit.blocks
        design = model.linearised(blocks.motion, model.free)
        later = model.with_term(low_pass)
        values = later.values.copy()
        values[later.places[low_pass.key]] = more
        for one in self.members:
            values[later.places[one.term.key]] -= delay_of_low_pass(low_pass) * more
        added = replace(later, values=values).prediction(blocks.motion) - design.prediction
        columns = [design.columns[p] for p in np.flatnonzero(model.free)]
        columns.append(dict(enumerate(added.T)))
        misfit = blocks.readings - design.prediction
        normal, right, _ = equations_of(columns, misfit, blocks, self.fit.noises).normal()
        solution = inverse(normal) @ right
        alone = inverse(normal[:-1, :-1]) @ right[:-1]
        return float(solution @ right - alone @ right[:-1]) if solution[-1] > 0.0 else 0.0

    def with_filter(self, more: float) -> "Combination":
        """A delay and filters whose time constants are greater by so much (s), and held there."""
        model, fit = self.fit.model, self.fit
        values, free = model.values.copy(), model.free.copy()
        low_pass = next(one.term for one in self.members if one.name == "bandwidth")
        for one in self.members:
            for p, parameter in enumerate(one.term.parameters, model.places[one.term.key].start):
                if one.name == "bandwidth":
                    values[p], free[p] = values[p] + more, False
                elif parameter.name == "seconds":
                    values[p] -= delay_of_low_pass(low_pass) * more
        held = fitted(replace(model, values=values, free=free), fit.blocks, fit.noises)
        return replace(self, fit=replace(fit, model=held))

    def _with(self, more: Sequence[Candidate]) -> Model:
        longer = self.fit.model
        for one in more:
            if one.term.key not in longer.places:
                longer = longer.with_term(one.term)
                longer.free[longer.places[one.term.key]] = False
            longer.free[longer.places[one.term.key].start + np.array(one.own)] = True
        return longer


def dispersion_of(fit: FittedSelection) -> float:
    """Chi-squared per reading of the residual, at least one."""
    return max(1.0, chi2_of(fit.model, fit) / fit.blocks.used)


def price_of(fit: FittedSelection) -> float:
    """Of a parameter: ln of the number of stretches that are independent of each other."""
    blocks = fit.blocks
    span = float(blocks.t[-1] - blocks.t[0])
    return float(np.log(max(len(np.unique(blocks.segment)), span / STRETCH, 3.0)))


def chi2_of(model: Model, fit: FittedSelection) -> float:
    """Chi-squared of what a model leaves of the readings that a selection is fitted to."""
    misfit = fit.blocks.readings - model.prediction(fit.blocks.motion)
    return equations_of([], misfit, fit.blocks, fit.noises).normal()[2]


def _late(
    members: Form, family: Sequence[str], delays: tuple[float, float], start: FittedSelection
) -> Model:
    """The model from which a fit of delays and filters starts: as late as those it replaces."""
    kept = {one.term.key for one in members}
    model = start.model.without(
        {key for key in start.model.places if key not in kept and key[0] in family}
    )
    for one in members:
        if one.term.key not in model.places:
            model = model.with_term(one.term)
    return starting_values(model, members, delays)


def _exchanged(members: Form, family: Sequence[str], start: FittedSelection) -> Selection:
    """The selection with the members in the place of all it has of the family."""
    old = [one for one in start.selection.selected if one.candidate.name in family]
    rest = [one for one in start.selection.selected if one.candidate.name not in family]
    by_key = {one.candidate.key: one for one in old}
    gain = sum(one.gain for one in old)
    new = [by_key.get(one.key) or Selected(one, gain, gain, ()) for one in members]
    return replace(start.selection, selected=(*new, *rest))
