"""A common value of some runs beside the spread between units and between runs.

The value of run r of unit u is μ (in the runs of a carrier, else nothing) + c + a_u + b_r with
random c, a_u and b_r of variance κ², τ² and σ². Their likelihood has a closed form in the runs'
scores and information (Henderson's mixed-model equations), so that a spread between units, which is
their calibration and no mismatch, is tried against every carrier. c is what this program itself
makes wrong in every run, when it takes the motion from encoders: it does not grow less with more
runs, and must not be taken for physics.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby

import numpy as np
from scipy.special import chdtrc

from tasks.review.hypotheses import Effect, Evidence, at_unit_information, ridged
from tasks.review.pool import Pool
from tasks.review.windows import LevelWindows, Window, WindowSums, inverses, quadratic_forms

BETWEEN_RUNS = (0.0, 0.7, 1.5, 4.0)  # σ that are tried, in units of what one run determines
BETWEEN_UNITS = (0.0, 0.5, 1.0, 2.0, 5.0)  # τ
IN_EVERY_RUN = 0.5  # κ, in units of what one run determines


@dataclass(frozen=True)
class Sums:
    """Score (w, m) of the runs of some windows, and their information (w, m, units, m) by unit."""

    score: np.ndarray
    own: np.ndarray

    @cached_property
    def flat(self) -> np.ndarray:
        """(w · m, units · m) of the information, every window's rows below each other."""
        return self.own.reshape(self.own.shape[0] * self.own.shape[1], -1)

    @cached_property
    def of_each_unit(self) -> np.ndarray:
        """(units, w · m, m) of the information."""
        windows, size, units, _ = self.own.shape
        turned = self.own.transpose(2, 0, 1, 3).reshape(units, windows * size, size)
        return np.ascontiguousarray(turned)

    def between(self, matrices: np.ndarray) -> np.ndarray:
        """(w, m, m) sum over units u of N_u·A_u·N_u, of matrices A (units, m, m)."""
        windows, size, units, _ = self.own.shape
        left = (self.of_each_unit @ matrices).reshape(units, windows, size, size)
        left = left.transpose(1, 2, 0, 3).reshape(windows, size, units * size)
        # Each N_u is symmetric: its rows are its columns.
        return left @ self.own.reshape(windows, size, units * size).transpose(0, 2, 1)


@dataclass(frozen=True)
class Spread:
    """The evidence with random parts of variance σ² between runs and τ² between units.

    score, information: of the runs with σ² taken into account. lessened: (units, m, m) W and
    shrunk: (units, m) W·S of each unit. kept: (units, m, m) 1 − W·N of each. everywhere: (m,) what
    all runs have in common by this program's own doing, and shared: (m, m) its covariance.
    likelihood: of no common value, nats.
    """

    sigma: float
    tau: float
    evidence: Evidence
    score: np.ndarray
    information: np.ndarray
    lessened: np.ndarray
    shrunk: np.ndarray
    kept: np.ndarray
    everywhere: np.ndarray
    shared: np.ndarray
    likelihood: float

    def common(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Right side (m,) and information (m, m) of a value common to some runs (runs,) bool."""
        sums = self._common(self.sums(rows[None]))
        right, information = self._less_everywhere(*sums)
        return right[0], information[0]

    def nested_gains(self, runs: np.ndarray) -> np.ndarray:
        """(n,) nats that a value common to the first, to the first two … of some runs (n,) gains.

        Each run changes the sums of its own unit alone.
        """
        unit, own = self.evidence.unit[runs], self.information[runs]
        after = _cumulative_of_each(own, unit)
        before, lessened = after - own, self.lessened[unit]
        each = own - after @ lessened @ after + before @ lessened @ before
        right = np.cumsum(
            self.score[runs] - np.einsum("rij,rj->ri", own, self.shrunk[unit]), axis=0
        )
        crossed = np.cumsum(own @ self.kept[unit], axis=0)
        return self._gains(right, np.cumsum(each, axis=0), crossed)

    def gains(self, rows: np.ndarray) -> np.ndarray:
        """(w,) nats that a value common to the runs of each window, (w, runs) bool, gains."""
        return self.gains_of(self.sums(rows))

    def gains_of(self, sums: Sums) -> np.ndarray:
        """The same from each window's sums over units."""
        return self._gains(*self._common(sums))

    def sums(self, rows: np.ndarray) -> Sums:
        """Over the runs of each window (w, runs) bool."""
        units, size = self.evidence.units, self.evidence.size
        own = self.evidence.of_units(rows) @ self.information.reshape(-1, size**2)
        own = own.reshape(len(rows), units, size, size).transpose(0, 2, 1, 3)
        return Sums(rows @ self.score, np.ascontiguousarray(own))

    @property
    def over_units(self) -> tuple[np.ndarray, np.ndarray]:
        """Sums over each unit's runs: score (units, m) and information (units, m, m)."""
        size, every = self.evidence.size, self.evidence.of_each_unit
        information = every @ self.information.reshape(-1, size**2)
        return every @ self.score, information.reshape(-1, size, size)

    def _gains(self, right: np.ndarray, information: np.ndarray, crossed: np.ndarray) -> np.ndarray:
        right, information = self._less_everywhere(right, information, crossed)
        return 0.5 * quadratic_forms(ridged(information), right)

    def _common(self, sums: Sums) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        size = sums.score.shape
        right = sums.score - (sums.flat @ self.shrunk.ravel()).reshape(size)
        crossed = sums.flat @ self.kept.reshape(-1, size[1])
        information = sums.own.sum(axis=2) - sums.between(self.lessened)
        return right, information, crossed.reshape(*size, size[1])

    def _less_everywhere(
        self, right: np.ndarray, information: np.ndarray, crossed: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Without what all runs have in common by this program's own doing."""
        taken = crossed @ self.shared @ crossed.transpose(0, 2, 1)
        return right - crossed @ self.everywhere, information - taken


def spreads(evidence: Evidence, sigmas: Sequence[float], taus: Sequence[float]) -> Iterator[Spread]:
    """Every spread between runs and units that is tried, one σ after the other."""
    for sigma in sigmas:
        alone = _between_runs(evidence, sigma)
        whole = alone.over_units
        for tau in taus:
            yield _between_units(alone, tau, *whole)


def gains_of_each(tried: Iterable[Spread], rows: np.ndarray) -> Iterator[tuple[Spread, np.ndarray]]:
    """Every spread with the nats (w,) that a value common to the runs of each window, (w, runs)
    bool, gains beside it; spreads of one σ one after the other share their sums over units.
    """
    for _, some in groupby(tried, key=lambda spread: spread.sigma):
        first, *others = some
        sums = first.sums(rows)
        for spread in (first, *others):
            yield spread, spread.gains_of(sums)


def _between_runs(evidence: Evidence, sigma: float) -> Spread:
    one, units = np.eye(evidence.size), evidence.units
    score, information, gained = evidence.score, evidence.information, 0.0
    if sigma:
        narrow, logarithm = inverses(one + sigma**2 * information)
        score = np.einsum("rij,rj->ri", narrow, score)
        gained = sigma**2 * float((evidence.score * score).sum()) - float(logarithm.sum())
        information = (one - narrow) / sigma**2
    return Spread(
        sigma, 0.0, evidence, score, information,
        np.zeros((units, *one.shape)), np.zeros((units, len(one))), np.tile(one, (units, 1, 1)),
        np.zeros(len(one)), np.zeros_like(one), 0.5 * gained,
    )  # fmt: skip


def _between_units(alone: Spread, tau: float, score: np.ndarray, information: np.ndarray) -> Spread:
    """score, information: sums over each unit's runs."""
    one = np.eye(alone.evidence.size)
    narrow, logarithm = inverses(one + tau**2 * information)
    lessened = tau**2 * narrow
    shrunk = (lessened @ score[:, :, None])[:, :, 0]
    gained = float((score * shrunk).sum() - logarithm.sum())
    kept = one - lessened @ information
    right = score.sum(axis=0) - np.einsum("uij,uj->i", information, shrunk)
    every = (information @ kept).sum(axis=0)
    widest = one + IN_EVERY_RUN**2 * every
    shared = IN_EVERY_RUN**2 * np.linalg.inv(widest)
    gained += float(right @ shared @ right - np.linalg.slogdet(widest)[1])
    return Spread(
        alone.sigma, tau, alone.evidence, alone.score, alone.information, lessened, shrunk, kept,
        shared @ right, shared, alone.likelihood + 0.5 * gained,
    )  # fmt: skip


def _cumulative_of_each(values: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Cumulative sums of values (n, …) within each group; group: (n,) numbers."""
    order = np.argsort(group, kind="stable")
    total = np.cumsum(values[order], axis=0)
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    before = np.concatenate([np.zeros((1, *values.shape[1:])), total])[starts]
    found = np.empty_like(total)
    found[order] = total - np.repeat(before, np.diff(np.append(starts, len(group))), axis=0)
    return found


# Screens every effect in every window of runs without random effects, for a closer look.

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
