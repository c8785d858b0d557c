"""A common value of some runs beside the spread between units and between runs.

The value of run r of unit u is μ (in the runs of a carrier, else nothing) + c + a_u + b_r with
random c, a_u and b_r of variance κ², τ² and σ². Their likelihood has a closed form in the runs'
scores and information (Henderson's mixed-model equations), so that a spread between units, which is
their calibration and no mismatch, is tried against every carrier. c is what this program itself
makes wrong in every run, when it takes the motion from encoders: it does not grow less with more
runs, and must not be taken for physics.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

DETERMINED = 1e-4  # of a parameter's information that is left beside the effect's others
IN_EVERY_RUN = 0.5  # κ, in units of what one run determines


@dataclass(frozen=True)
class Evidence:
    """Score (runs, m) and information (runs, m, m) in coordinates in which the mean information of
    the runs is one. back: (parameters, m) from these coordinates to SI. unit: (runs,) number of the
    unit, from 0.
    """

    score: np.ndarray
    information: np.ndarray
    back: np.ndarray
    unit: np.ndarray

    @property
    def size(self) -> int:
        return int(self.score.shape[1])

    @cached_property
    def flat(self) -> np.ndarray:
        """(runs, m + m²) score and information side by side."""
        return np.concatenate([self.score, self.information.reshape(len(self.score), -1)], axis=1)

    @cached_property
    def by_unit(self) -> np.ndarray:
        """(runs,) the runs in the order of their units."""
        return np.argsort(self.unit, kind="stable")

    @cached_property
    def starts(self) -> np.ndarray:
        """(units,) where each unit's runs begin among them."""
        return np.flatnonzero(np.diff(self.unit[self.by_unit], prepend=-1))


def at_unit_information(score: np.ndarray, information: np.ndarray, unit: np.ndarray) -> Evidence:
    """Evidence without what no run determines."""
    seen = information.any(axis=(1, 2))
    mean = information.sum(axis=0) / max(1, int(seen.sum()))
    size = np.sqrt(np.diag(mean))
    scale = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0)
    values, vectors = np.linalg.eigh(mean * scale[:, None] * scale)
    kept = values > DETERMINED
    back = scale[:, None] * vectors[:, kept] / np.sqrt(values[kept])
    turned = information.reshape(len(score), -1) @ np.kron(back, back)  # of all runs at once
    return Evidence(score @ back, turned.reshape(len(score), *[back.shape[1]] * 2), back, unit)


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
        sums = self._common(*_by_unit(self, rows[None]))
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
        return self.gains_of(*_by_unit(self, rows))

    def gains_of(self, score: np.ndarray, own: np.ndarray) -> np.ndarray:
        """The same from each window's sums over units, (w, units, m) and (w, units, m, m)."""
        return self._gains(*self._common(score, own))

    def _gains(self, right: np.ndarray, information: np.ndarray, crossed: np.ndarray) -> np.ndarray:
        right, information = self._less_everywhere(right, information, crossed)
        return np.asarray(0.5 * (right * solved(information, right)).sum(axis=1))

    def _common(
        self, score: np.ndarray, own: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        right = score.sum(axis=1) - np.einsum("wuij,uj->wi", own, self.shrunk)
        information = own.sum(axis=1) - (own @ self.lessened @ own).sum(axis=1)
        return right, information, (own @ self.kept).sum(axis=1)

    def _less_everywhere(
        self, right: np.ndarray, information: np.ndarray, crossed: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Without what all runs have in common by this program's own doing."""
        taken = crossed @ self.shared @ crossed.transpose(0, 2, 1)
        return right - crossed @ self.everywhere, information - taken


Sums = tuple[np.ndarray, np.ndarray]


def spreads(
    evidence: Evidence, sigmas: tuple[float, ...], taus: tuple[float, ...], rows: np.ndarray
) -> Iterator[tuple[Spread, Sums]]:
    """Every spread between runs and units that is tried, and the sums over units of the runs of
    each window, (w, runs) bool.
    """
    every = np.ones((1, len(evidence.unit)), bool)
    for sigma in sigmas:
        alone = _between_runs(evidence, sigma)
        score, information = (total[0] for total in _by_unit(alone, every))
        sums = _by_unit(alone, rows)
        for tau in taus:
            yield _between_units(alone, tau, score, information), sums


def _between_runs(evidence: Evidence, sigma: float) -> Spread:
    one, units = np.eye(evidence.size), len(evidence.starts)
    wider = one + sigma**2 * evidence.information
    narrow = np.linalg.inv(wider)
    score = np.einsum("rij,rj->ri", narrow, evidence.score)
    gained = sigma**2 * float((evidence.score * score).sum()) - np.linalg.slogdet(wider)[1].sum()
    return Spread(
        sigma, 0.0, evidence, score, narrow @ evidence.information,
        np.zeros((units, *one.shape)), np.zeros((units, len(one))), np.tile(one, (units, 1, 1)),
        np.zeros(len(one)), np.zeros_like(one), 0.5 * float(gained),
    )  # fmt: skip


def _between_units(alone: Spread, tau: float, score: np.ndarray, information: np.ndarray) -> Spread:
    """score, information: sums over each unit's runs."""
    one = np.eye(alone.evidence.size)
    wider = one + tau**2 * information
    lessened = tau**2 * np.linalg.inv(wider)
    shrunk = np.einsum("uij,uj->ui", lessened, score)
    gained = float((score * shrunk).sum() - np.linalg.slogdet(wider)[1].sum())
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


def _by_unit(spread: Spread, rows: np.ndarray) -> Sums:
    """Sums over each unit's runs within each of some windows (w, runs) bool."""
    evidence, units = spread.evidence, len(spread.evidence.starts)
    score = np.zeros((len(rows), units, evidence.size))
    own = np.zeros((len(rows), units, evidence.size, evidence.size))
    for number, some in enumerate(rows):
        runs = evidence.by_unit[some[evidence.by_unit]]
        unit = evidence.unit[runs]
        starts = np.flatnonzero(np.diff(unit, prepend=-1))
        score[number, unit[starts]] = np.add.reduceat(spread.score[runs], starts)
        own[number, unit[starts]] = np.add.reduceat(spread.information[runs], starts)
    return score, own


def _cumulative_of_each(values: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Cumulative sums of values (n, …) within each group; group: (n,) numbers."""
    order = np.argsort(group, kind="stable")
    total = np.cumsum(values[order], axis=0)
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    before = np.concatenate([np.zeros((1, *values.shape[1:])), total])[starts]
    found = np.empty_like(total)
    found[order] = total - np.repeat(before, np.diff(np.append(starts, len(group))), axis=0)
    return found


def solved(information: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solutions of symmetric systems (…, m, m), (…, m); what nothing determines is zero."""
    ridge = 1e-9 + 1e-6 * np.einsum("...ii->...", information)[..., None, None]
    wider = information + ridge * np.eye(information.shape[-1])
    return np.asarray(np.linalg.solve(wider, right[..., None])[..., 0])
