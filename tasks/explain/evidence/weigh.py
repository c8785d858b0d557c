"""What each finding earns: chi-squared lost without it, and on segments that a fit did not see."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from schemas.discrepancy import HeldOut
from tasks.explain.evidence.held_out import PartlySeen, partly_seen
from tasks.explain.explanation import CHANNELS
from tasks.explain.inputs.observed import Observed
from tasks.explain.regression.equations import Equations, equations_of
from tasks.explain.regression.spectrum import Noise
from tasks.explain.search.empirical_terms import UNNAMED
from tasks.explain.search.refit import Model, whole_effect
from tasks.explain.search.stepwise import FALSE_ALARMS, Chosen, Found
from tasks.model.regression import inverse
from tasks.model.simulate import linearise
from tasks.model.term import COUNTS, Column, Term, places

CLEAR = 1e-6  # p value, corrected: evident even if its form is not quite right
REMNANT = 0.15  # of the chi-squared that something without a name gains
STEPS_ARE_JUMPS = 2  # as many steps or more are no single step


@dataclass(frozen=True)
class Group:
    """One finding to be: its name, the terms that model it, and who else might."""

    name: str
    terms: tuple[Term, ...]
    chosen: tuple[Chosen, ...]


def groups_of(found: Found) -> list[Group]:
    """Findings of one name are one, those without a name of one term; several steps are jumps.

    What is far weaker than something that has no name is likely to be a remnant of it, and has
    none either; but known physics, which has nothing to fit to a remnant. A wander is so likely
    beside anything stronger without a name, a drift beside a stronger bias that jumps or wanders.
    """
    named: dict[str | tuple[str, int], list[Chosen]] = {}
    for one in found.chosen:
        name = one.candidate.name
        named.setdefault(one.candidate.term.key if name == UNNAMED else name, []).append(one)
    names = [_name_of(some) for some in named.values()]
    gains = [sum(one.gain for one in some) for some in named.values()]
    nameless = [
        (some, gain)
        for some, name, gain in zip(named.values(), names, gains, strict=True)
        if name == UNNAMED
    ]
    return [
        Group(
            UNNAMED if _remnant(some, gain, nameless) else name,
            tuple({one.candidate.term.key: one.candidate.term for one in some}.values()),
            tuple(some),
        )
        for some, name, gain in zip(named.values(), names, gains, strict=True)
    ]


def _remnant(
    some: Sequence[Chosen], gain: float, nameless: Sequence[tuple[list[Chosen], float]]
) -> bool:
    if any(one.candidate.known or one.instead_of is not None for one in some):
        return False
    most = max((other for _, other in nameless), default=0.0)
    jumping = max((other for one, other in nameless if _jumps_or_wanders(one)), default=0.0)
    if some[0].candidate.prior is not None:  # as a remnant of anything slow wanders
        return gain < most
    return gain < max(REMNANT * most, jumping if _is_slow(some[0].candidate.term) else 0.0)


def _jumps_or_wanders(some: Sequence[Chosen]) -> bool:
    """Whether it is a bias that jumps or wanders, which any slow course makes up for in part."""
    first = some[0].candidate
    return first.prior is not None or first.term.time_course == "jump"


def _is_slow(term: Term) -> bool:
    return term.time_course in ("drift", "jump")


def _name_of(some: Sequence[Chosen]) -> str:
    times = {one.candidate.term.at for one in some}
    if some[0].candidate.term.time_course == "jump" and len(times) >= STEPS_ARE_JUMPS:
        return UNNAMED
    if any(_at_bound(one.candidate.term) for one in some):
        return UNNAMED
    return some[0].candidate.name


def _at_bound(term: Term) -> bool:
    """Whether a continuous shape was driven out of what is plausible: another form fits better."""
    for shape, value in zip(term.shapes, term.at, strict=True):
        low, high = shape.plausible
        searched = shape.unit not in (COUNTS, "deg") and shape.name != "time"
        if searched and (value >= 0.99 * high or value <= 1.01 * low):
            return True
    return False


@dataclass(frozen=True)
class Weighed:
    """The model's columns, whitened, on all rows and on each fold.

    groups: for each finding the columns that are its own and what they are multiplied by now.
    prior: (q,) precision beforehand.
    """

    whole: Equations
    parts: PartlySeen
    groups: tuple[tuple[list[int], np.ndarray], ...]
    fixed: tuple[int, ...]
    prior: np.ndarray
    used: int

    @classmethod
    def of(
        cls, model: Model, fine: Observed, noises: Sequence[Noise], groups: Sequence[Group]
    ) -> "Weighed":
        design = linearise(model.terms, fine.motion, model.values)
        free = np.flatnonzero(model.free)
        columns: list[Column] = [design.columns[p] for p in free]
        prior = model.prior[free]
        own, position = places(model.terms), {int(p): q for q, p in enumerate(free)}
        indexed, fixed = [], []
        for group in groups:
            mine, now = [], []
            for k, term in enumerate(model.terms):
                if term.key not in {each.key for each in group.terms}:
                    continue
                if not term.parameters:
                    fixed.append(len(columns))
                    mine.append(len(columns))
                    now.append(1.0)
                    columns.append(whole_effect(model, term, fine.motion, design.prediction))
                for p in range(own[k].start, own[k].stop):
                    if p in position:
                        mine.append(position[p])
                        now.append(float(model.values[p]))
            indexed.append((mine, np.array(now)))
        misfit = fine.readings - design.prediction
        prior = np.concatenate([prior, np.zeros(len(columns) - len(prior))])
        return cls(
            equations_of(columns, misfit, fine, noises),
            partly_seen(columns, misfit, fine, noises),
            tuple(indexed), tuple(fixed), prior, int((fine.weight > 0).sum()),
        )  # fmt: skip

    def _kept(self, without: Sequence[int]) -> list[int]:
        return [q for q in range(self.whole.count) if q not in without and q not in self.fixed]

    def _added(self, numbers: Sequence[int]) -> np.ndarray:
        added = np.zeros(self.whole.count)
        for number in numbers:
            mine, now = self.groups[number]
            added[mine] = now
        return added

    def gain(self, number: int) -> float:
        """Chi-squared lost when one finding is left out and all else is fitted again."""
        return self._chi2(self._kept(self.groups[number][0]), self._added([number])) - self._chi2(
            self._kept(()), np.zeros(self.whole.count)
        )

    def _chi2(self, kept: Sequence[int], added: np.ndarray) -> float:
        normal, right, misfit = self.whole.normal()
        right = right + normal @ added
        chi2 = misfit + 2.0 * added @ self.whole.normal()[1] + added @ normal @ added
        rows = list(kept)
        block = normal[np.ix_(rows, rows)] + np.diag(self.prior[rows])
        return float(chi2 - right[rows] @ inverse(block) @ right[rows])

    def held_out_gain(self, number: int) -> float:
        """Log-likelihood (nats) that one finding adds on segments that a fit did not see."""
        without = self.parts.surprise(
            self._kept(self.groups[number][0]), self._added([number]), self.prior
        )
        return 0.5 * float((without - self._after()).sum())

    def _after(self) -> np.ndarray:
        return self.parts.surprise(self._kept(()), np.zeros(self.whole.count), self.prior)

    def held_out(self) -> HeldOut:
        """How segments that a fit did not see are predicted, before and after."""
        every = range(len(self.groups))
        mine = [q for number in every for q in self.groups[number][0]]
        before = self.parts.surprise(self._kept(mine), self._added(list(every)), self.prior)
        after = self._after()
        ratio = {
            name: float(np.sqrt(after[c] / before[c]))
            for c, name in enumerate(CHANNELS)
            if before[c] > 0 and after[c] > 0
        }
        return HeldOut(
            rms_ratio=ratio,
            chi2_per_dof_before=float(before.sum() / self.used),
            chi2_per_dof_after=float(after.sum() / self.used),
        )

    def needless(self, number: int, group: Group, tried: int) -> bool:
        """Whether a finding gains no more than chance would, with so many tried, or segments that
        a fit did not see contradict it: at all where it is weak, altogether where it is clear.
        """
        if any(one.candidate.prior is not None or one.instead_of for one in group.chosen):
            return self.held_out_gain(number) <= 0.0 and not group.chosen[0].instead_of
        count = max(1, len(self.groups[number][0]))
        gain, unseen = self.gain(number), self.held_out_gain(number)
        chance = float(chi2.sf(max(gain, 0.0), count)) * tried
        contradicted = unseen <= 0.0 and (chance > CLEAR or unseen < -gain)
        return chance > FALSE_ALARMS or contradicted
