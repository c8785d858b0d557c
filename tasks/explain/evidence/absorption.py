"""Known physics that the standard's parameters absorb whole, and yet leaves its mark on them.

Two positions cannot tell Earth's rotation from g-sensitivity: no residual is left. But physics
whose size is known beforehand predicts the values of the parameters that absorb it. Where they
have those values, and are otherwise nothing, it is the likelier cause: a parameter that is free
over its plausible range would have hit that value by chance. Where not, nothing is claimed.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import chdtrc

from schemas.recording import AXES
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.inputs.blocks import Blocks
from tasks.explain.search.candidates import Candidate, columns_of
from tasks.explain.search.stepwise import Selected
from tasks.explain.whitening import Noise, weighted, whitened_gram
from tasks.model.regression import inverse
from tasks.model.terms.standard import GYRO_G_SENSITIVITY, regressors

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
        claim = absorbed(known, blocks, fit.selection.noises)
        if claim is not None:
            selected = (*fit.selection.selected, claim)
            fit = fit.reselected(replace(fit.selection, selected=selected))
    return evidence if fit is evidence.fit else Evidence.of(fit)


def absorbed(known: Candidate, blocks: Blocks, noises: Sequence[Noise]) -> Selected | None:
    """The candidate, selected, where the readings ask for it instead of what absorbs it.

    noises: of a coefficient at the blocks' rate.
    """
    (effect,) = columns_of(known.term, blocks.motion)
    gains = [_gains(signal, blocks, c, noises[c]) for c, signal in effect.items()]
    gain, absorbing, occam, count = np.sum(gains, axis=0) if gains else np.zeros(4)
    if count == 0 or gain <= 0:
        return None
    rival = max(0.0, absorbing - occam)
    beyond = max(0.0, absorbing - gain)
    if gain - rival < MIN_LOG_ODDS or chdtrc(count, beyond) < MAX_MISFIT:
        return None
    return Selected(known, float(gain), float(gain - rival), (), absorbed_by=ABSORBING.name)


def _gains(
    effect: np.ndarray, blocks: Blocks, number: int, noise: Noise
) -> tuple[float, float, float, int]:
    """Chi-squared gained over a model without the absorbing parameters, by the known physics and
    by those parameters; the Occam factor of the parameters and their number.
    """
    if not blocks.weight[:, number].any():
        return 0.0, 0.0, 0.0, 0
    base = regressors(blocks.motion, number).T
    signals = weighted([*base, effect, blocks.readings[:, number]], blocks.weight[:, number])
    gram = whitened_gram(signals, blocks, noise)
    count = len(AXES)  # the absorbing parameters of a channel are the last of its base
    first = len(base) - count
    shared = gram[:first, first:]
    left = gram[first:, first:] - shared.T @ inverse(gram[:first, :first]) @ shared
    observable = np.flatnonzero(
        np.diag(left)[:count] > OBSERVABLE * np.diag(gram)[first : first + count]
    )
    score, free = left[observable, -1], left[np.ix_(observable, observable)]
    if not len(observable):
        return 0.0, 0.0, 0.0, 0
    width = 0.5 * ABSORBING.parameters[0].plausible[1] * np.sqrt(np.diag(free))
    return (
        float(2.0 * left[count, -1] - left[count, count]),
        float(score @ inverse(free) @ score),
        float(np.log1p(width**2).sum()),
        len(observable),
    )
