"""Known physics that the standard's parameters soak up whole, and yet leave its mark on them.

Two positions cannot tell Earth's rotation from g-sensitivity: no residual is left. But physics
whose size is known beforehand predicts what the soaked-up parameters must come out at. Where they
do, and are otherwise nothing, it is the likelier cause: a parameter that is free over its
plausible range would have hit that value by chance. Where they do not, nothing is said.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from tasks.explain.inputs.observed import Observed
from tasks.explain.regression.equations import equations_of
from tasks.explain.regression.spectrum import Noise
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.stepwise import Chosen
from tasks.model.regression import inverse
from tasks.model.term import Column
from tasks.model.terms.standard import GYRO_G_SENSITIVITY, GYRO_TERMS, regressors

SOAKS = GYRO_G_SENSITIVITY  # what soaks up a rate that turns with the vertical
LIKELIER = 12.0  # twice the log of the odds that a claim asks for
MISFIT = 1e-3  # p value of what the parameters are beyond the known physics


@dataclass(frozen=True)
class _Fits:
    """Chi-squared gained over a model without the parameters that soak up, and their number."""

    known: float
    soaking: float
    occam: float
    count: int


def soaked_up(
    known: Candidate, column: Column, observed: Observed, noises: Sequence[Noise]
) -> Chosen | None:
    """The candidate, chosen, where the readings ask for it instead of what soaks it up.

    column: its whole effect. noises: of a coefficient at the observed rate.
    """
    fits = _fits(column, observed, noises)
    if fits.count == 0 or fits.known <= 0:
        return None
    rival = max(0.0, fits.soaking - fits.occam)
    beyond = max(0.0, fits.soaking - fits.known)
    if fits.known - rival < LIKELIER or chdtrc(fits.count, beyond) < MISFIT:
        return None
    return Chosen(known, fits.known, fits.known - rival, (), instead_of=SOAKS.name)


def _fits(column: Column, observed: Observed, noises: Sequence[Noise]) -> _Fits:
    motion = observed.motion
    others = tuple(term for term in GYRO_TERMS if term is not SOAKS)
    total = np.zeros(3)
    count = 0
    for channel in column:
        base, soaking = (list(regressors(motion, channel, t).T) for t in (others, (SOAKS,)))
        columns: list[Column] = [{channel: course} for course in (*base, *soaking)]
        columns.append({channel: column[channel]})
        gram = equations_of(columns, observed.readings, observed, noises).grams[channel]
        first, last = len(base), len(base) + len(soaking)
        shared = gram[:first, first:]
        left = gram[first:, first:] - shared.T @ inverse(gram[:first, :first]) @ shared
        free, effect = left[: last - first, : last - first], last - first
        seen = np.diag(free) > 1e-9 * np.diag(gram)[first:last]
        if not seen.any():
            continue
        own = np.flatnonzero(seen)
        solved = inverse(free[np.ix_(own, own)])
        heard = left[own, -1]
        half = SOAKS.parameters[0].plausible[1]
        spread = 0.5 * half * np.sqrt(np.diag(free)[own])
        total += (
            2.0 * left[effect, -1] - left[effect, effect],
            float(heard @ solved @ heard),
            float(np.log1p(spread**2).sum()),
        )
        count += len(own)
    return _Fits(float(total[0]), float(total[1]), float(total[2]), count)
