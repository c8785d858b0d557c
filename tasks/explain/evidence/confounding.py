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

from schemas.discrepancy import FoundParameter
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.explanation import as_likely_within
from tasks.explain.noise import equations_of, weighted, whitened
from tasks.explain.search.candidates import Candidate, columns_of
from tasks.explain.search.empirical import Tip
from tasks.explain.search.fitted import FittedSelection, fitted
from tasks.explain.search.stepwise import Selected, Selection, joint_gain, special_cases
from tasks.model.fit import WhitenedEquations, inverse, of_channel
from tasks.model.model import Model
from tasks.model.term import Term, TermKey

# Effects that make a unit late, and so make up for one another: by how much each does.

Form = tuple[Candidate, ...]

GYROS_ALONE = "gyro_angular_acceleration"
DELAYING = ("time_offset", "bandwidth", GYROS_ALONE, "accel_axis_skew")
ROOT2, THIRD = float(np.sqrt(2.0)), 1.0 / 3.0


@dataclass(frozen=True)
class GroupDelay:
    """By how much a triad is late at low frequency, per unit of a parameter; s."""

    gyro: float
    accel: float


# Of a low-pass of second order √2/(2πf) = √2·T, of one of first order T; of ω′ = ω + A·ω̇ it is
# −A; the accelerometers' axes are read none, one and two steps ahead.
GROUP_DELAYS = {
    ("time_offset", "seconds"): GroupDelay(1.0, 1.0),
    ("bandwidth", "time_constant"): GroupDelay(ROOT2, ROOT2),
    ("bandwidth", "gyro_time_constant"): GroupDelay(ROOT2, 0.0),
    ("bandwidth", "accel_time_constant"): GroupDelay(0.0, ROOT2),
    ("bandwidth", "lag"): GroupDelay(1.0, 1.0),
    ("bandwidth", "gyro_lag"): GroupDelay(1.0, 0.0),
    ("bandwidth", "accel_lag"): GroupDelay(0.0, 1.0),
    (GYROS_ALONE, "A_xx"): GroupDelay(-THIRD, 0.0),
    (GYROS_ALONE, "A_yy"): GroupDelay(-THIRD, 0.0),
    (GYROS_ALONE, "A_zz"): GroupDelay(-THIRD, 0.0),
    ("accel_axis_skew", "step"): GroupDelay(0.0, -1.0),
}


def delay_of_low_pass(low_pass: Term) -> float:
    """By how much it is late at low frequency, per unit of its time constants."""
    delay = GROUP_DELAYS[low_pass.name, low_pass.parameters[0].name]
    return max(delay.gyro, delay.accel)


def forms_of(candidates: Sequence[Candidate], selected: Sequence[Candidate]) -> list[Form]:
    """The forms of delays and filters, each as candidates to represent it: those selected, else
    those with the same parameters as selected ones of another effect, else all.
    """
    found: list[Form] = []
    for name in DELAYING:
        own = tuple(one for one in selected if one.name == name)
        found += [own] if own else []
        forms: dict[TermKey, list[Candidate]] = {}
        for one in candidates:
            if one.is_form_of((name,)) and one.term.key not in [other.term.key for other in own]:
                forms.setdefault(one.term.key, []).append(one)
        found += [_alike(some, selected) for some in forms.values()]
    return found


def _alike(form: Sequence[Candidate], selected: Sequence[Candidate]) -> Form:
    names = [p.name for p in form[0].term.parameters]
    parts = [one.own for one in selected if [p.name for p in one.term.parameters] == names]
    return tuple(one for one in form if one.own in parts) or (form[0],)


def shape_count(members: Form) -> int:
    """Number of time constants and the like that are fitted, each as free as a parameter."""
    return sum(len(term.shapes) for term in {one.term.key: one.term for one in members}.values())


def starting_values(model: Model, members: Form, delays: tuple[float, float]) -> Model:
    """The model with delays and filters of such sizes that gyros and accelerometers are late by
    so much (s), as a fit may start from. Beside a delay a filter is what the later triad has.
    """
    values, names = model.values.copy(), {one.name for one in members}
    both = {"time_offset", "bandwidth"} <= names
    late = min(delays) if both else float(np.mean(delays))
    left = [delay - late if both else delay for delay in delays]
    whole, gyro, accel = (max(each, 0.0) for each in (float(np.mean(left)), *left))
    sizes = {
        "seconds": late,
        "time_constant": whole / ROOT2,
        "gyro_time_constant": gyro / ROOT2,
        "accel_time_constant": accel / ROOT2,
        "lag": whole,
        "gyro_lag": gyro,
        "accel_lag": accel,
    }
    for one in members:
        for p, parameter in enumerate(one.term.parameters, model.places[one.term.key].start):
            if (one.name, parameter.name) in GROUP_DELAYS and parameter.name in sizes:
                values[p] = sizes[parameter.name]
    return replace(model, values=values)


def common_part(
    model: Model, terms: Sequence[Term], names: Sequence[str], widening: np.ndarray
) -> tuple[FoundParameter, ...]:
    """Group delay of gyros and of accelerometers by all the terms together, with its uncertainty;
    empty for effects that are not delays. names: of the group; if one of them is not among the
    terms and delays gyros only, the delay of the accelerometers is not known.

    widening: (p,) factors by which the residual, and the differences between the recording's parts,
    widen the uncertainty of each of the model's parameters.
    """
    weights = _delay_weights(model, terms)
    widened = weights * widening
    u = np.sqrt(np.einsum("kp,pq,kq->k", widened, model.covariance, widened))
    values = weights @ model.values
    of_gyros = GYROS_ALONE in names and GYROS_ALONE not in [term.name for term in terms]
    pairs = zip(("gyro_group_delay", "accel_group_delay"), values.tolist(), u.tolist(), strict=True)
    return tuple(
        FoundParameter(name=name, value=value, unit="s", u=spread)
        for name, value, spread in pairs
        if spread > 0.0 and not (name == "accel_group_delay" and of_gyros)
    )


def group_delays(model: Model, names: Sequence[str]) -> tuple[float, float]:
    """Of gyros and of accelerometers by all the terms of some names together, s."""
    terms = [term for term in model.terms if term.name in names]
    gyro, accel = (_delay_weights(model, terms) @ model.values).tolist()
    return gyro, accel


def _delay_weights(model: Model, terms: Sequence[Term]) -> np.ndarray:
    """(2, p) group delay of gyros and accelerometers per unit of each of the model's parameters."""
    weights = np.zeros((2, len(model.values)))
    for term in terms:
        for p, parameter in enumerate(term.parameters, model.places[term.key].start):
            delay = GROUP_DELAYS.get((term.name, parameter.name), GroupDelay(0.0, 0.0))
            weights[:, p] = delay.gyro, delay.accel
    return weights


# Fits a combination of mutually compensating effects together with everything else.

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

    def chi2_with_share_of(self, other: Form, share: float) -> float:
        """Chi-squared where the members make so much less, or more, as another effect makes up
        for it; infinite where it does not.
        """
        longer = self._with(other)
        places = [longer.places[one.term.key] for one in self.members]
        own = longer.places[other[0].term.key]
        for sign in (1.0, -1.0):  # another may only ever add to a delay
            values, free = longer.values.copy(), longer.free.copy()
            for place in places:
                values[place] *= 1.0 - sign * share
                free[place] = False
            moved = replace(longer, values=values, free=free)
            moved = fitted(moved, self.fit.blocks, self.fit.noises)
            if moved.values[own].any():
                return chi2_of(moved, self.fit)
        return np.inf

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


# Gain and cost of the effects of a family in linear form, by the equations of the search.

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


# Compares delays and filters in their real form.

SHARE = 0.1  # of an effect: what another could have made of it belongs to the finding
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
        if self._linear.triads_differ:
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

    def _hidden_in(self, form: Form, best: Combination) -> bool:
        """Whether, as far as the data show, another effect may account for a share of the best."""
        if form[0].name in names_of(best.members):
            return False
        missed = self._linear.gain(best.members) - self._linear.gain(form)
        limit = DISTINGUISHABLE * self._linear.dispersion
        if not self._delay_was_taken_back and SHARE**2 * missed > 2.0 * limit:
            return False
        return best.chi2_with_share_of(form, SHARE) - best.chi2 < limit

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
    return max(dispersion_of(fit), evidence.dispersion(number))


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
