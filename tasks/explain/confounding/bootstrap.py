"""How much better another form fits than the true one, for the errors of the reference.

Delays and filters of equal group delay differ by less than a coarse encoder errs. Which of them
fits better then depends on what smoothing the encoder took from the motion, and it need not be the
true one: chi-squared differences count only beyond what they are expected to be if the dearer form
is the truth (Cox, Tests of separate families of hypotheses, 1961; by parametric bootstrap).
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tasks.explain.confounding.combinations import Combination, chi2_of
from tasks.explain.inputs.blocks import Blocks
from tasks.explain.inputs.prepared import Prepared
from tasks.explain.inputs.simulated_reading import simulated_reading
from tasks.explain.search.refit import fitted
from tasks.explain.whitening import equations_of
from tasks.model.regression import inverse
from tasks.motion.whole import Motion

DRAWS = 3  # of the errors of the reference
SEED = 21
AGAIN = 6.0  # times what a second smoothing makes: a smoothed corner loses two fifths as much again
FAR = 0.2  # of the difference: no other draw makes it from less
Rivals = Callable[[Combination, Sequence[Combination], Collection[str]], tuple[str, ...]]


@dataclass(frozen=True)
class ReferenceBootstrap:
    """Readings of a recording as compared forms would make them, fitted by its reference."""

    prepared: Prepared

    def rivals(
        self, best: Combination, tried: Sequence[Combination], known: Collection[str]
    ) -> tuple[str, ...]:
        """Names of single effects that may be the truth in the place of the best's members,
        although they fit worse by no more parameters. known: others that are not asked about.
        """
        asked = {one.name for each in tried for one in each.members}
        asked -= {*known, *(one.name for one in best.members)}
        rivals: list[str] = []
        simple = [one for one in tried if one.fitted_count <= best.fitted_count]
        for one in sorted(simple, key=lambda each: each.chi2):
            names = {member.name for member in one.members}
            if len(names) == 1 and names <= asked and self._may_be(one, best):
                rivals += names
                asked -= names
        return tuple(rivals)

    def _may_be(self, true: Combination, other: Combination) -> bool:
        """Whether, for the errors of the reference alone, the true form may fit worse than another
        by as much as it does: whether one of a few draws of them makes it so.
        """
        difference = true.chi2 - other.chi2
        for blocks in self._read_again(true):
            excess = AGAIN * (_least_chi2(true, blocks) - _least_chi2(other, blocks))
            if excess > difference:
                return True
            if excess < FAR * difference:
                return False
        return False

    def _read_again(self, true: Combination) -> Iterator[Blocks]:
        """Blocks, as those of the fit, of readings that a form makes of the motion that was found,
        beside that motion as the reference reads it in each draw.
        """
        full = self.prepared.full
        readings = true.fit.model.prediction(full.motion)
        for read in self._draws:
            made = replace(full, readings=readings, motion=read)
            yield self.prepared.blocks_of_other(made, true.fit.blocks.rate)

    @cached_property
    def _draws(self) -> list[Motion]:
        rng = np.random.default_rng(SEED)
        draws = [
            simulated_reading(self.prepared.recording, self.prepared.full, rng, shifted=False)
            for _ in range(DRAWS)
        ]
        return [draw[1] for draw in draws if draw is not None]


def _least_chi2(form: Combination, blocks: Blocks) -> float:
    """Chi-squared that a form leaves of other readings, fitted to them.

    They differ from those that it was fitted to by errors of the reference, to which a model is
    linear; only what would become negative where no unit has it so is fitted in steps.
    """
    model, noises = form.fit.model, form.fit.noises
    design = model.design(blocks.motion)
    misfit = blocks.readings - design.prediction
    normal, right, chi2 = equations_of(design.columns, misfit, blocks, noises).normal()
    prior, pull = np.zeros(len(right)), right.copy()
    count = int(model.free.sum())
    prior[:count] = model.prior[model.free]
    pull[:count] -= prior[:count] * model.values[model.free]
    covariance = inverse(normal + np.diag(prior))
    change = covariance @ pull
    if model.stepped(change, covariance).negative.any():
        model = fitted(model, blocks, noises)
        return chi2_of(model, replace(form.fit, blocks=blocks))
    return float(chi2 - 2.0 * change @ right + change @ normal @ change)
