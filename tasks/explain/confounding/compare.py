"""Compares delays and filters, and reports those as a group between which data cannot decide.

Near nothing all of them are one derivative of the motion; so the search, which knows their linear
forms, cannot tell them apart. Those whose linear form comes near are fitted in their real form.
Each combination costs what it leaves of chi-squared, counted against what the best leaves, and
ln(stretches) for each parameter and each shape that is fitted: so that a pair that one effect
explains is that effect.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tasks.explain.confounding.combinations import Combination, chi2_of, dispersion_of, price_of
from tasks.explain.confounding.delays import DELAYING, Form, forms_of, group_delays
from tasks.explain.confounding.linear_forms import (
    DISTINGUISHABLE,
    FORM,
    LinearForms,
    group_names,
    is_by_triad,
    keys_of,
    marked,
    names_of,
)
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.explanation import as_likely_within
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.fitted import FittedSelection, fitted
from tasks.explain.search.stepwise import Selected, special_cases

NEAR = 0.9  # of the largest linear gain: what gains less does not come near in its real form
FILTER = 3e-3  # s, a time constant that filters have: 53 Hz
Prune = Callable[[FittedSelection, Collection[str]], FittedSelection]


def compared(
    fit: FittedSelection, candidates: Sequence[Candidate], prune: Prune
) -> FittedSelection:
    """The selection with the best combination of delays and filters in place of those it has,
    marked with the names that the data cannot distinguish from it.

    prune: a selection without what is unnecessary in it, but with effects of these names.

    A nuisance of every model is kept, and what compensates for it is left out: tracking smooths
    positions and attitudes differently, so that it is not certainly the unit's. It is marked with
    whatever fits no worse in its place.
    """
    own = [one for one in fit.selection.selected if one.candidate.is_form_of(DELAYING)]
    selected = [one for one in own if not one.candidate.nuisance]
    nuisances = [one for one in own if one.candidate.nuisance]
    if not own:
        return fit
    if nuisances and selected:
        fit = fit.without(selected)
    present = tuple(one.candidate for one in nuisances or selected)
    forms = tuple(forms_of(candidates, present))
    delays = _Delays(forms, present, fit, prune)
    return delays.with_rivals() if nuisances else delays.compared()


@dataclass(frozen=True)
class _Delays:
    """Delays and filters of which something was selected. forms: of all; present: the selected."""

    forms: tuple[Form, ...]
    present: Form
    fit: FittedSelection
    prune: Prune

    def _plausible(self, forms: Iterable[Form]) -> list[Combination]:
        return [one for one in map(self._fitted, forms) if one.plausible]

    def _comes_near(self, form: Form) -> bool:
        return self._linear.gain(form) > NEAR * self._linear.largest_gain

    def with_rivals(self) -> FittedSelection:
        """The given effects, marked with the names that fit no worse in their place.

        Whatever makes the unit early is not a filter.
        """
        if min(group_delays(self.fit.model, DELAYING)) <= 0.0:
            return self.fit
        found = self._fitted(self.present)
        near = self._near(self._plausible(self._in_place_of(self.present)), found)
        group = group_names(self.present, [names_of(one.members) for one in near])
        return marked(found, group)

    def _in_place_of(self, present: Form) -> Iterator[Form]:
        """Delays and filters other than these that come near by their linear forms."""
        for form in self.forms:
            if form[0].term.stage != "signal" or keys_of(form) == keys_of(present):
                continue
            if self._delay_was_taken_back or self._comes_near(form):
                yield form

    def compared(self) -> FittedSelection:
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
        group = group_names(best.members, names)
        return marked(best, group)

    def _near(self, tried: Iterable[Combination], best: Combination) -> list[Combination]:
        """What fits as well as the best."""
        limit = self._cost(best) + DISTINGUISHABLE
        return [one for one in tried if self._cost(one) < limit]

    def _pruned(self, tried: Sequence[Combination]) -> list[Combination]:
        """Those that come near, without other effects that had only made up for what they are."""
        if not any(one.candidate.name not in DELAYING for one in self.fit.selection.selected):
            return list(tried)
        least = min(map(self._cost, tried))
        return [
            replace(one, fit=self.prune(one.fit, DELAYING))
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
        gyro, accel = group_delays(self.fit.model, DELAYING)
        later, pairs = 0 if gyro > accel else 1, []
        for both in (form[0] for form in self.forms if is_by_triad(form)):
            place = both.own.index(later) if later in both.own else 0  # one triad may show none
            one = replace(both, own=(both.own[place],), members=(both.members[place],))
            pair = self._fitted((*delay, one))
            more = pair.with_filter(FILTER)
            pairs.append(pair)
            if more.chi2 < pair.chi2:
                pairs.append(Combination.of((*delay, both), DELAYING, more.fit))
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

    def _fitted(self, members: Form) -> Combination:
        if members is self.present and not self._delay_was_taken_back:
            return Combination(members, self.fit)
        return Combination.of(members, DELAYING, self.fit)

    def _cost(self, one: Combination) -> float:
        return one.chi2 / self._linear.dispersion + self._linear.price * one.fitted_count

    @cached_property
    def _linear(self) -> LinearForms:
        return LinearForms(DELAYING, self.forms, self.fit)

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


# Of names that fit as well as one another, the one that asks for less.
#
# The special case stands before the effect that holds it, and what a working unit may have before
# what is beyond that. What the other earns beyond it must exceed the error of its own form.


def with_preferred(fit: FittedSelection, candidates: Sequence[Candidate]) -> FittedSelection:
    """The selection with a rival in the place of what asks for more, where that fits no worse.

    candidates: all that were tried. The rivals of what is replaced are those of its replacement.
    """
    for one in fit.selection.selected:
        parts = [each for each in fit.selection.selected
                 if each.candidate.term.key == one.candidate.term.key]  # fmt: skip
        if not parts:
            continue  # replaced with another part
        found = Combination(tuple(part.candidate for part in parts), fit)
        left = None
        for rival in _asking_for_less(one, found, candidates):
            left = left or _dispersion(one, fit)
            beside = [each for each in fit.selection.selected if each.candidate.name == rival.name]
            without = fit.without([*parts, *beside])
            instead = Combination.of((rival,), (rival.name,), without)
            dearer = price_of(fit) * (instead.fitted_count - found.fitted_count)
            worse = (instead.chi2 - found.chi2) / left
            gain = (chi2_of(without.model, without) - instead.chi2) / left
            if instead.plausible and worse + dearer < as_likely_within(gain):
                tried = one.candidate.name, *one.rivals
                others = tuple(name for name in tried if name != rival.name)
                fit = marked(instead, (), others)
                break
    return fit


def _dispersion(one: Selected, fit: FittedSelection) -> float:
    """Of what is left, in all readings or between the parts of the recording that tell of it."""
    evidence, key = Evidence.of(fit), one.candidate.term.key
    number = next(
        n for n, group in enumerate(evidence.groups) if key in {term.key for term in group.terms}
    )
    return max(dispersion_of(fit), evidence.scatter.dispersion(number))


def _asking_for_less(
    one: Selected, found: Combination, candidates: Sequence[Candidate]
) -> Iterator[Candidate]:
    """In whole forms: its special cases, and its rivals where it is not plausible."""
    candidate = one.candidate
    if candidate.nuisance or candidate.known or candidate.prior is not None or one.absorbed_by:
        return
    names = dict.fromkeys(special_cases(candidate.term))
    if not found.plausible:
        names |= dict.fromkeys(one.rivals)
    for name in names:
        yield from [each for each in candidates if each.is_form_of((name,))][:1]
