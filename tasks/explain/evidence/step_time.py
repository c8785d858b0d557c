"""When a bias stepped, and how well the readings about the step say so."""

import numpy as np

from tasks.explain.search.fitted import FittedSelection
from tasks.model.term import Term

COVERED = 2.0  # standard deviations by which a step may be moved: k of the stated U


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
    misfit = np.nan_to_num(blocks.readings - prediction)  # of no weight where the motion is unknown
    # The step that a block has, or lacks, when the instant is moved past it.
    moved = misfit + np.where(np.arange(len(misfit)) >= first, 1.0, -1.0)[:, None] * size
    variance = np.array([noise.white for noise in fit.noises])
    counted = np.divide(blocks.weight**2, variance, out=np.zeros_like(misfit), where=variance > 0)
    cost = ((moved**2 - misfit**2) * counted).sum(axis=1)
    limit = COVERED**2 * dispersion
    later = _passed(cost[first:], limit)
    earlier = _passed(cost[:first][::-1], limit)
    lowest = blocks.t[max(first - earlier - 1, 0)]
    highest = blocks.t[min(first + later, len(blocks.t) - 1)]
    half = float(highest - lowest) / 2.0 + 0.5 / blocks.band
    return float(lowest + highest) / 2.0, half / COVERED


def _passed(cost: np.ndarray, limit: float) -> int:
    """How many blocks the instant may pass before all that lie beyond cost too much."""
    possible = np.flatnonzero(np.cumsum(cost) <= limit)
    return int(possible[-1]) + 1 if len(possible) else 0
