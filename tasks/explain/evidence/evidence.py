"""What each finding earns: chi-squared lost without it, and on segments that a fit did not use."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import chi2

from schemas.discrepancy import HeldOut
from tasks.explain.channels import CHANNELS
from tasks.explain.evidence.groups import FindingGroup, finding_groups
from tasks.explain.evidence.held_out import CrossValidation, cross_validation
from tasks.explain.regression.spectrum import equations_of
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import FALSE_ALARMS
from tasks.model.regression import WhitenedEquations, inverse
from tasks.model.term import Column

CLEAR = 1e-6  # p value, corrected: evident even if its form is not quite right


@dataclass(frozen=True)
class Evidence:
    """A fitted selection as findings, and its model's columns, whitened, on all rows and by fold.

    own: for each group the columns that are its own and what they are multiplied by now.
    prior: (q,) precision beforehand. known: columns of physics whose factor is one.
    """

    fit: FittedSelection
    groups: tuple[FindingGroup, ...]
    whole: WhitenedEquations
    folds: CrossValidation
    own: tuple[tuple[list[int], np.ndarray], ...]
    known: tuple[int, ...]
    prior: np.ndarray

    @classmethod
    def of(cls, fit: FittedSelection) -> "Evidence":
        model, blocks = fit.model, fit.blocks
        groups = finding_groups(fit.selection)
        design = model.linearised(blocks.motion, model.free)
        free = np.flatnonzero(model.free).tolist()
        columns: list[Column] = [design.columns[p] for p in free]
        position, own_places = {p: q for q, p in enumerate(free)}, model.places
        own, known = [], []
        for group in groups:
            mine: list[int] = []
            values: list[float] = []
            for term in group.terms:
                place = own_places[term.key]
                if not term.parameters:
                    known.append(len(columns))
                    mine.append(len(columns))
                    values.append(1.0)
                    effect = model.effect_of({term.key}, blocks.motion, design.prediction)
                    columns.append(dict(enumerate(effect.T)))
                fitted = [p for p in range(place.start, place.stop) if p in position]
                mine += [position[p] for p in fitted]
                values += model.values[fitted].tolist()
            own.append((mine, np.array(values)))
        misfit = blocks.readings - design.prediction
        prior = np.concatenate([model.prior[free], np.zeros(len(known))])
        return cls(
            fit,
            groups,
            equations_of(columns, misfit, blocks, fit.noises),
            cross_validation(columns, misfit, blocks, fit.noises),
            tuple(own),
            tuple(known),
            prior,
        )

    @cached_property
    def used(self) -> int:
        """Readings that the fit used."""
        return int((self.fit.blocks.weight > 0).sum())

    def gain(self, number: int) -> float:
        """Chi-squared lost when one finding is left out and all else is fitted again."""
        return self._chi2([number]) - self._chi2([])

    def held_out_gain(self, number: int) -> float:
        """Log-likelihood (nats) that one finding adds on segments that a fit did not use."""
        return 0.5 * float((self._deviance([number]) - self._deviance_after).sum())

    def held_out(self) -> HeldOut:
        """How segments that a fit did not use are predicted, before and after."""
        before, after = self._deviance(range(len(self.groups))), self._deviance_after
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

    def unsupported(self, number: int, trials: int) -> bool:
        """Whether a finding gains no more than chance would, with so many candidates tried, or
        segments that a fit did not use contradict it: at all where it is weak, altogether where it
        is clear.
        """
        held_out_gain = self.held_out_gain(number)
        selected = self.groups[number].selected
        if any(one.candidate.prior is not None or one.absorbed_by for one in selected):
            return held_out_gain <= 0.0 and not self.groups[number].absorbed_by
        count = max(1, len(self.own[number][0]))
        gain = self.gain(number)
        chance = float(chi2.sf(max(gain, 0.0), count)) * trials
        contradicted = held_out_gain <= 0.0 and (chance > CLEAR or held_out_gain < -gain)
        return chance > FALSE_ALARMS or contradicted

    @cached_property
    def _deviance_after(self) -> np.ndarray:
        return self._deviance([])

    def _deviance(self, without: Sequence[int]) -> np.ndarray:
        """(6,) of held-out segments, without some findings."""
        return self.folds.deviance(self._kept(without), self._added(without), self.prior)

    def _chi2(self, without: Sequence[int]) -> float:
        """Of a fit to all rows, without some findings."""
        normal, right, misfit = self.whole.normal()
        rows, added = self._kept(without), self._added(without)
        misfit += float(2.0 * added @ right + added @ normal @ added)
        right = right + normal @ added
        block = normal[np.ix_(rows, rows)] + np.diag(self.prior[rows])
        return float(misfit - right[rows] @ inverse(block) @ right[rows])

    def _kept(self, without: Sequence[int]) -> list[int]:
        """The columns that are fitted when some findings are left out."""
        left_out = {q for number in without for q in self.own[number][0]} | set(self.known)
        return [q for q in range(self.whole.count) if q not in left_out]

    def _added(self, numbers: Sequence[int]) -> np.ndarray:
        """What the columns of some findings are multiplied by now, which their misfit lacks."""
        added = np.zeros(self.whole.count)
        for number in numbers:
            mine, values = self.own[number]
            added[mine] = values
        return added


def pruned(fit: FittedSelection, trials: int) -> Evidence:
    """The fitted selection without the findings that the others have made needless.

    The weakest is taken out and the rest is fitted again, until all earn their place. trials:
    candidates that were tried.
    """
    evidence = Evidence.of(fit)
    while weak := [n for n in range(len(evidence.groups)) if evidence.unsupported(n, trials)]:
        weakest = min(weak, key=evidence.gain)
        evidence = Evidence.of(evidence.fit.without(evidence.groups[weakest].selected))
    return evidence
