"""When a bias stepped, and how well the readings about the step say so."""

import numpy as np

from tasks.explain.odds import COVERAGE
from tasks.explain.search.fitted import FittedSelection
from tasks.model.term import Term


def step_time(fit: FittedSelection, step: Term, dispersion: float) -> tuple[float, float]:
    """The middle of the times at which a step fits nearly as well, and its standard uncertainty, s.

    step: a term of the fitted model whose only shape is a time. dispersion: chi-squared per degree
    of freedom of the residual, which the chi-squared that a displacement costs may exceed fourfold.
    Times are on the clock of the blocks. Only white noise is counted: a drift hardly moves between
    neighbouring blocks. Where no reading is compared a step may lie anywhere, and what is compared
    only up to a frequency f shows no time more closely than 1/(2f).
    """
    model, blocks = fit.model, fit.blocks
    prediction = model.prediction(blocks.motion)
    first = int(np.searchsorted(blocks.t, step.at[0]))
    added = np.nan_to_num(model.effect_of({step.key}, blocks.motion, prediction)[first:])
    size = added[np.abs(added).argmax(axis=0), np.arange(added.shape[1])]  # the same in each row
    # What is left of a block after the step, and of one before it; unknown motion has no weight.
    after = np.nan_to_num(blocks.readings - prediction)
    after[:first] -= size
    before = after + size
    variance = np.array([noise.white for noise in fit.noises])
    counted = np.divide(blocks.weight**2, variance, out=np.zeros_like(after), where=variance > 0)
    # Chi-squared if the step comes before block j: what is before it, and after it.
    passed = ((before**2 - after**2) * counted).sum(axis=1)
    cost = np.concatenate([[0.0], passed.cumsum()])
    possible = np.flatnonzero(cost <= cost[first] + COVERAGE**2 * dispersion)
    lowest = blocks.t[max(possible[0] - 1, 0)]
    highest = blocks.t[min(possible[-1], len(blocks.t) - 1)]
    half = float(highest - lowest) / 2.0 + 0.5 / blocks.band
    return float(lowest + highest) / 2.0, half / COVERAGE
