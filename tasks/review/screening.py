"""Screens every effect in every window of runs without random effects, for a closer look."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import chdtrc

from tasks.review.evidence import Evidence, at_unit_information
from tasks.review.hypotheses import Effect
from tasks.review.pool import Pool
from tasks.review.random_effects import BETWEEN_RUNS, BETWEEN_UNITS, Spread, spreads
from tasks.review.window_sums import WindowSums
from tasks.review.windows import LevelWindows, Window

CARRIERS = 2  # of each level that are looked at closely
WORTH = 0.01  # p value, corrected for all that is tried, above which none is
CLOSELY = 16  # effects that are looked at closely


@dataclass(frozen=True)
class Screened:
    """An effect with the windows in which it gains most; p_value: of the best, corrected."""

    effect: Effect
    windows: tuple[Window, ...]
    gain: float
    p_value: float


@dataclass(frozen=True)
class Worth:
    """What is worth a closer look, with its evidence."""

    effect: Effect
    windows: tuple[Window, ...]
    evidence: Evidence

    @cached_property
    def spreads(self) -> tuple[Spread, ...]:
        """Every spread between runs and units that is tried."""
        return tuple(spreads(self.evidence, BETWEEN_RUNS, BETWEEN_UNITS))


def screened(
    pool: Pool, levels: Sequence[LevelWindows], sums: WindowSums, tried: int
) -> list[Screened]:
    """The effects that gain more than chance would, the most first; tried: how many in all."""
    found = []
    for effect, size, gains in sums.gains(pool):
        best = list(_best(gains, levels))
        gain = max(gain for gain, _ in best)
        p_value = min(1.0, float(chdtrc(size, gain)) * tried)
        found.append(Screened(effect, tuple(window for _, window in best), gain, p_value))
    # By the gain as well: of strong effects every p value is zero.
    return sorted(found, key=lambda one: (one.p_value, -one.gain))


def promising(pool: Pool, looked: Sequence[Screened]) -> list[Worth]:
    """The best of them, with the evidence of every run."""
    some = [one for one in looked if one.p_value < WORTH][:CLOSELY]
    return [
        Worth(one.effect, one.windows, at_unit_information(*pool.evidence(one.effect), pool.unit))
        for one in some
    ]


def _best(gains: np.ndarray, levels: Sequence[LevelWindows]) -> Iterator[tuple[float, Window]]:
    """The best window of each of the best carriers of each level, and these carriers as a whole."""
    start = 0
    for level in levels:
        own = gains[start : start + len(level.windows)].copy()
        start += len(level.windows)
        for _ in range(min(CARRIERS, len(level.whole))):
            best = int(own.argmax())
            window = level.windows[best]
            yield float(own[best]), window
            if not window.whole:
                whole = level.whole[window.carrier]
                yield float(own[whole]), level.windows[whole]
            own[level.carrier == window.carrier] = -1.0
