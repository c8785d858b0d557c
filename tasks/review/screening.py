"""Every effect in every window of runs, as if nothing scattered: which are worth a closer look."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from tasks.review.hypotheses import Effect
from tasks.review.mixed import Evidence, at_unit_information, solved
from tasks.review.pool import Pool
from tasks.review.windows import LevelWindows, Window

CARRIERS = 2  # of each level that are looked at closely
WORTH = 0.01  # p value, corrected for all that is tried, above which none is


@dataclass(frozen=True)
class Screened:
    """An effect with the windows in which it gains most; p_value: of the best, corrected."""

    effect: Effect
    evidence: Evidence
    windows: tuple[Window, ...]
    gain: float
    p_value: float


def screened(pool: Pool, windows: Sequence[LevelWindows]) -> list[Screened]:
    """The effects that gain more than chance would, the most first."""
    tried = len(pool.effects) * sum(len(level.windows) for level in windows)
    found = (_of_effect(pool, effect, windows, tried) for effect in pool.effects)
    # By the gain as well: of strong effects every p value is zero.
    return sorted(
        (one for one in found if one is not None), key=lambda one: (one.p_value, -one.gain)
    )


def _of_effect(
    pool: Pool, effect: Effect, windows: Sequence[LevelWindows], tried: int
) -> Screened | None:
    score, information = pool.evidence(effect)
    evidence = at_unit_information(score, information, pool.unit)
    if not evidence.size:
        return None
    best = [pair for level in windows for pair in _best_of_level(evidence, level)]
    gain = max(gain for gain, _ in best)
    p_value = min(1.0, float(chdtrc(evidence.size, gain)) * tried)
    return Screened(effect, evidence, tuple(window for _, window in best), gain, p_value)


def _best_of_level(evidence: Evidence, level: LevelWindows) -> Iterator[tuple[float, Window]]:
    """The best window of each of the best carriers, and these carriers as a whole."""
    if not level.windows:
        return
    gains = window_gains(evidence, level)
    carriers = set[int]()
    for k in np.argsort(-gains).tolist():
        window = level.windows[k]
        if window.carrier in carriers:
            continue
        carriers.add(window.carrier)
        yield float(gains[k]), window
        if not window.whole:
            at = level.whole[window.carrier]
            yield float(gains[at]), level.windows[at]
        if len(carriers) == CARRIERS:
            return


def window_gains(evidence: Evidence, level: LevelWindows) -> np.ndarray:
    """(w,) chi-squared that a common value gains in each window, without any spread."""
    total = _cumulative(level.pieces @ evidence.flat)
    sums, m = total[level.high] - total[level.low], evidence.size
    right, information = sums[:, :m], sums[:, m:].reshape(-1, m, m)
    values = solved(information, right)
    return np.asarray((right * values).sum(axis=1))


def _cumulative(values: np.ndarray) -> np.ndarray:
    return np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
