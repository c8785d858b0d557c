"""Tests compensating effects together, and reports them as a group where data cannot decide.

Each combination costs what it leaves of chi-squared, counted against what the best leaves, and
ln(stretches) for each parameter and each shape that is fitted: so that a pair that one effect
explains is that effect. Compared are linear forms, by the search's normal equations. Delays and
filters that come near are fitted in their real form, and so is what is put in another's place.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tasks.explain.confounding.bootstrap import Rivals
from tasks.explain.confounding.combinations import Combination, chi2_of
from tasks.explain.confounding.families import FAMILIES, Form, forms_of, group_delays
from tasks.explain.confounding.linear_forms import (
    DISTINGUISHABLE,
    FORM,
    LinearForms,
    drifts,
    group_names,
    is_by_triad,
    keys_of,
    marked,
    names_of,
    shapes_signals,
)
from tasks.explain.confounding.special_case import HOLDS, with_general
from tasks.explain.odds import CERTAIN
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.refit import fitted

SHARE = 0.1  # of an effect: what another could have made of it belongs to the finding
NEAR = 0.9  # of the largest linear gain: what gains less does not come near in its real form
FILTER = 3e-3  # s, a time constant that filters have: 53 Hz
Prune = Callable[[FittedSelection, Collection[str]], FittedSelection]


def compared(
    fit: FittedSelection, candidates: Sequence[Candidate], prune: Prune, by_reference: Rivals
) -> FittedSelection:
    """The selection with the best combination of each family in place of its members, marked with
    the names that the data cannot distinguish from it.

    prune: a selection without what is unnecessary in it, but with effects of these names.
    by_reference: single effects that may be the truth although they fit worse.

    A nuisance of every model is kept, and what compensates for it is left out: tracking smooths
    positions and attitudes differently, so that it is not certainly the unit's. It is marked with
    whatever fits no worse in its place.
    """
    for family in FAMILIES:
        own = [one for one in fit.selection.selected if one.candidate.is_form_of(family)]
        selected = [one for one in own if not one.candidate.nuisance]
        nuisances = [one for one in own if one.candidate.nuisance]
        if not own or any(one.absorbed_by for one in selected):
            continue
        if nuisances and selected:
            fit = fit.without(selected)
        present = tuple(one.candidate for one in nuisances or selected)
        forms = tuple(forms_of(family, candidates, present))
        of_family = _Family(family, forms, present, fit, prune, by_reference)
        fit = of_family.with_rivals() if nuisances else of_family.compared()
    return fit


@dataclass(frozen=True)
class _Family:
    """A family of which something was selected. forms: of its effects; present: the selected."""

    names: tuple[str, ...]
    forms: tuple[Form, ...]
    present: Form
    fit: FittedSelection
    prune: Prune
    rivals_by_reference: Rivals

    def compared(self) -> FittedSelection:
        if shapes_signals(self.present):
            return self._by_real_fits()
        found = self._fitted(self.present)
        if not found.plausible and (fitting := self._plausible_alone(found)):
            one = min(fitting, key=lambda o: (len(o.members[0].term.shapes), self._cost(o)))
            return marked(one, group_names(one.members, [names_of(o.members) for o in fitting]))
        alike = [self.present, *self._linear.combined(names_of(self.present))]
        costs = [self._linear.cost(one) for one in alike]
        near = [one for one, cost in zip(alike, costs, strict=True)
                if cost - min(costs) < self._linear.indistinguishable(one)]  # fmt: skip
        best = self.present if near[0] is self.present else alike[int(np.argmin(costs))]
        if shapes_signals(best):
            return self._by_real_fits()
        chosen = self._fitted(best)
        if best is not self.present and not self._holds(chosen, found):
            return self._marked(self._special_case(found), ())
        special = self._special_case(chosen)
        if special is not chosen:
            return self._marked(special, ())
        return self._marked(chosen, map(names_of, near))

    def _marked(self, chosen: Combination, near: Iterable[tuple[str, ...]]) -> FittedSelection:
        others = [one for one in self.fit.selection.candidates if one.name not in self.names]
        names = with_general(
            chosen, near, self.forms, self.fit.selection.equations, others, self._linear.dispersion
        )
        group = group_names(chosen.members, names)
        known = {*names_of(chosen.members), *group}
        forms = [form for form in self.forms if form[0].name not in known and not drifts(form)]
        tried = self._plausible(filter(self._comes_near, forms))
        return marked(chosen, group, self.rivals_by_reference(chosen, tried, group))

    def _plausible(self, forms: Iterable[Form]) -> list[Combination]:
        return [one for one in map(self._fitted, forms) if one.plausible]

    def _comes_near(self, form: Form) -> bool:
        return self._linear.gain(form) > NEAR * self._linear.largest_gain

    def with_rivals(self) -> FittedSelection:
        """The given effects, marked with the names that fit no worse in their place.

        Whatever makes the unit early is not a filter.
        """
        if min(group_delays(self.fit.model, self.names)) <= 0.0:
            return self.fit
        found = self._fitted(self.present)
        plausible = self._plausible(self._in_place_of(self.present))
        near = self._near(plausible, found)
        group = group_names(self.present, [names_of(one.members) for one in near])
        return marked(found, group, self.rivals_by_reference(found, plausible, group))

    def _in_place_of(self, present: Form) -> Iterator[Form]:
        """Delays and filters other than these that come near by their linear forms."""
        for form in self.forms:
            if form[0].term.stage != "signal" or keys_of(form) == keys_of(present):
                continue
            if self._delay_was_taken_back or self._comes_near(form):
                yield form

    def _plausible_alone(self, found: Combination) -> list[Combination]:
        """Plausible effects that fit no worse in their real forms than what is not plausible."""
        tried = self._plausible(self.forms)
        least = min(map(self._cost, (found, *tried)))
        return [one for one in tried if self._cost(one) - least < CERTAIN]

    def _special_case(self, found: Combination) -> Combination:
        """The selection, or the special case of it that fits no worse in its exact form: linear
        forms ignore what else was refined and that the standard's own terms compensate for it.
        """
        for form in self.forms:
            general = HOLDS.get(form[0].name)
            if general not in names_of(found.members):
                continue
            others = tuple(one for one in found.members if one.name not in (general, form[0].name))
            special = self._fitted((*form, *others))
            if special.plausible and self._cost(special) < self._cost(found):
                return special
        return found

    def _holds(self, chosen: Combination, found: Combination) -> bool:
        """Whether what linear forms prefer is plausible in its real form, and fits better there."""
        return chosen.plausible and self._cost(found) - self._cost(chosen) > CERTAIN

    def _by_real_fits(self) -> FittedSelection:
        """Of one effect each that comes near, then of those that fit best with each other."""
        tried = [self._fitted(self.present)]
        tried += [
            self._fitted(form)
            for form in self._in_place_of(self.present)
            if self._linear.triads_differ or not is_by_triad(form)
        ]
        singles = [one for one in tried if len(names_of(one.members)) == 1] or tried
        alone = min(singles, key=self._cost)
        if self._linear.triads_differ or self._smooths(alone):
            tried += self._delay_with_filter()
        near = sorted(self._near(singles, alone), key=self._cost, reverse=True)
        cheapest = {names_of(one.members): one for one in near}
        tried += [self._fitted(pair) for one in cheapest.values() for pair in self._promising(one)]
        plausible = self._pruned([one for one in tried if one.plausible] or tried)
        best = self._fewest_effects(plausible)
        if len(names_of(best.members)) > 1:  # no likelier than a filter that a lead cancels
            plausible += [one for one in tried if one.is_cancelled]
        names = [names_of(one.members) for one in self._near(plausible, best)]
        if set(names_of(best.members)) == {"time_offset", "bandwidth"}:
            limit = best.chi2 + DISTINGUISHABLE * self._linear.dispersion
            if best.with_filter(FILTER).chi2 < limit:
                names += [("bandwidth",), ("time_offset",)]
        elif len(names_of(best.members)) == 1:
            first = {form[0].name: form for form in reversed(self.forms)}
            names += [(name,) for name, form in first.items() if self._hidden_in(form, best)]
        group = group_names(best.members, names)
        return marked(best, group, self.rivals_by_reference(best, plausible, group))

    def _near(self, tried: Iterable[Combination], best: Combination) -> list[Combination]:
        """What fits as well as the best."""
        limit = self._cost(best) + DISTINGUISHABLE
        return [one for one in tried if self._cost(one) < limit]

    def _pruned(self, tried: Sequence[Combination]) -> list[Combination]:
        """Those that come near, without other effects that had only made up for what they are."""
        if not any(one.candidate.name not in self.names for one in self.fit.selection.selected):
            return list(tried)
        least = min(map(self._cost, tried))
        return [
            replace(one, fit=self.prune(one.fit, self.names))
            if self._cost(one) - least < self._distinguishable
            else one
            for one in tried
        ]

    def _fewest_effects(self, tried: Sequence[Combination]) -> Combination:
        """Of what fits as far as equations can be relied on, the fewest effects; of these the
        fewest parameters that fit as well as the best of them.
        """
        least = min(map(self._cost, tried))
        near = [one for one in tried if self._cost(one) - least < self._distinguishable]
        fewest = min(one.effect_count for one in near)
        near = [one for one in near if one.effect_count == fewest]
        least = min(map(self._cost, near))
        return min(
            (one for one in near if self._cost(one) - least < DISTINGUISHABLE),
            key=lambda one: (one.count, one.members is not self.present, self._cost(one)),
        )

    def _delay_with_filter(self) -> list[Combination]:
        """A delay with a filter of the later triad; of both triads, if one more filter fits better.

        Starting from zero, the first step cannot tell a filter from a delay: so it starts at a
        usual size.
        """
        delay = next((form for form in self.forms if form[0].name == "time_offset"), None)
        if delay is None:
            return []
        gyro, accel = group_delays(self.fit.model, self.names)
        later, pairs = 0 if gyro > accel else 1, []
        for both in (form[0] for form in self.forms if is_by_triad(form)):
            place = both.own.index(later) if later in both.own else 0  # one triad may show none
            one = replace(both, own=(both.own[place],), members=(both.members[place],))
            pair = self._fitted((*delay, one))
            more = pair.with_filter(FILTER)
            pairs.append(pair)
            if more.chi2 < pair.chi2:
                pairs.append(Combination.of((*delay, both), self.names, more.fit))
        return pairs

    def _promising(self, alone: Combination) -> Iterator[Form]:
        """The best of one effect with each other that promises more than its price."""
        others = [
            form for form in self.forms
            if {form[0].name, *names_of(alone.members)} not in (
                set(names_of(alone.members)), {"time_offset", "bandwidth"})
        ]  # fmt: skip
        for form, gain in zip(others, alone.promises(others), strict=True):
            if gain / self._linear.dispersion > self._linear.price * sum(
                len(one.own) for one in form
            ):
                yield (*alone.members, *form)

    def _smooths(self, alone: Combination) -> bool:
        """Whether a filter beside a delay promises to fit better than the one of them that fits
        best: in the delay's place one of a usual size, which is a column like any other.
        """
        both = next((form[0] for form in self.forms if is_by_triad(form)), None)
        delay = next((form for form in self.forms if form[0].name == "time_offset"), None)
        if delay is None or both is None:
            return False
        gain = 0.0
        if names_of(alone.members) == ("time_offset",):
            gain = alone.promise_of_filter(both.term, FILTER)
        elif names_of(alone.members) == ("bandwidth",):
            gain = alone.promises([delay])[0]
        return gain > DISTINGUISHABLE * self._linear.dispersion

    def _hidden_in(self, form: Form, best: Combination) -> bool:
        """Whether, as far as the data show, another effect may account for a share of the best."""
        if form[0].name in names_of(best.members) or form[0].name == HOLDS.get(
            best.members[0].name
        ):
            return False
        missed = self._linear.gain(best.members) - self._linear.gain(form)
        limit = DISTINGUISHABLE * self._linear.dispersion
        if not self._delay_was_taken_back and SHARE**2 * missed > 2.0 * limit:
            return False
        return best.chi2_with_share_of(form, SHARE) - best.chi2 < limit

    def _fitted(self, members: Form) -> Combination:
        if members is self.present and not self._delay_was_taken_back:
            return Combination(members, self.fit)
        return Combination.of(members, self.names, self.fit)

    def _cost(self, one: Combination) -> float:
        return one.chi2 / self._linear.dispersion + self._linear.price * one.fitted_count

    @cached_property
    def _linear(self) -> LinearForms:
        return LinearForms(self.names, self.forms, self.fit)

    @cached_property
    def _distinguishable(self) -> float:
        """Chi-squared that separates exact forms, beyond what the form of the whole may leave: of a
        delay that was taken back the linear forms know the little that was left of it.
        """
        if not self._delay_was_taken_back:
            return self._linear.distinguishable
        keys = {one.term.key for one in self.present}
        without = fitted(self.fit.model.without(keys), self.fit.blocks, self.fit.noises)
        gain = chi2_of(without, self.fit) - chi2_of(self.fit.model, self.fit)
        return max(self._linear.distinguishable, FORM**2 * gain / self._linear.dispersion)

    @cached_property
    def _delay_was_taken_back(self) -> bool:
        """Whether the search was of readings without a delay that the model has."""
        return any(np.isinf(one.gain) for one in self.fit.selection.selected)
