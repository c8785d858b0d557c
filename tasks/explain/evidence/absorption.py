"""Known physics that the standard's parameters absorb whole, and yet leaves its mark on them.

Two positions cannot tell Earth's rotation from g-sensitivity: no residual is left. But physics
whose size is known beforehand predicts the values of the parameters that absorb it. Where they
have those values, and are otherwise nothing, it is the likelier cause: a parameter that is free
over its plausible range would have hit that value by chance. Where not, nothing is claimed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc

from tasks.explain.evidence.evidence import Evidence
from tasks.explain.inputs.blocks import Blocks
from tasks.explain.regression.equations import equations_of
from tasks.explain.regression.spectrum import Noise
from tasks.explain.search.candidates import Candidate, columns_of
from tasks.explain.search.stepwise import Selected
from tasks.model.regression import inverse
from tasks.model.term import Column
from tasks.model.terms.standard import GYRO_G_SENSITIVITY, GYRO_TERMS, regressors

ABSORBING = GYRO_G_SENSITIVITY  # absorbs a rate that turns with the vertical
MIN_LOG_ODDS = 12.0  # twice the log of the odds that a claim asks for
MAX_MISFIT = 1e-3  # p value of what the parameters are beyond the known physics
OBSERVABLE = 1e-9  # of a column's power: less is left of it beside the standard's other columns


def with_absorbed(evidence: Evidence, candidates: Sequence[Candidate], blocks: Blocks) -> Evidence:
    """The evidence with the known physics that the readings ask for though it is absorbed.

    blocks: those of the search.
    """
    fit, names = evidence.fit, {one.name for one in evidence.fit.selection.candidates}
    for known in (one for one in candidates if one.known and one.name not in names):
        (effect,) = columns_of(known.term, blocks.motion)
        claim = absorbed(known, effect, blocks, fit.selection.noises)
        if claim is not None:
            selected = (*fit.selection.selected, claim)
            fit = fit.reselected(replace(fit.selection, selected=selected))
    return evidence if fit is evidence.fit else Evidence.of(fit)


@dataclass(frozen=True)
class _Gains:
    """Chi-squared gained over a model without the absorbing parameters, by the known physics and
    by those parameters; the Occam factor of the parameters and their number.
    """

    known: float = 0.0
    absorbing: float = 0.0
    occam: float = 0.0
    count: int = 0

    def __add__(self, other: "_Gains") -> "_Gains":
        return _Gains(
            self.known + other.known,
            self.absorbing + other.absorbing,
            self.occam + other.occam,
            self.count + other.count,
        )


def absorbed(
    known: Candidate, effect: Column, blocks: Blocks, noises: Sequence[Noise]
) -> Selected | None:
    """The candidate, selected, where the readings ask for it instead of what absorbs it.

    effect: all that it adds to the readings. noises: of a coefficient at the blocks' rate.
    """
    gains = sum((_gains(effect, c, blocks, noises) for c in effect), start=_Gains())
    if gains.count == 0 or gains.known <= 0:
        return None
    rival = max(0.0, gains.absorbing - gains.occam)
    beyond = max(0.0, gains.absorbing - gains.known)
    if gains.known - rival < MIN_LOG_ODDS or chdtrc(gains.count, beyond) < MAX_MISFIT:
        return None
    return Selected(known, gains.known, gains.known - rival, (), absorbed_by=ABSORBING.name)


def _gains(effect: Column, channel: int, blocks: Blocks, noises: Sequence[Noise]) -> _Gains:
    others = tuple(term for term in GYRO_TERMS if term.key != ABSORBING.key)
    base, own = (list(regressors(blocks.motion, channel, t).T) for t in (others, (ABSORBING,)))
    columns: list[Column] = [{channel: signal} for signal in (*base, *own, effect[channel])]
    gram = equations_of(columns, blocks.readings, blocks, noises).grams[channel]
    first, count = len(base), len(own)
    shared = gram[:first, first:]
    left = gram[first:, first:] - shared.T @ inverse(gram[:first, :first]) @ shared
    observable = np.flatnonzero(
        np.diag(left)[:count] > OBSERVABLE * np.diag(gram)[first : first + count]
    )
    if not len(observable):
        return _Gains()
    score, free = left[observable, -1], left[np.ix_(observable, observable)]
    width = 0.5 * ABSORBING.parameters[0].plausible[1] * np.sqrt(np.diag(free))
    return _Gains(
        known=float(2.0 * left[count, -1] - left[count, count]),
        absorbing=float(score @ inverse(free) @ score),
        occam=float(np.log1p(width**2).sum()),
        count=len(observable),
    )
