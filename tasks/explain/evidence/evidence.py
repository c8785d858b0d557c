"""The evidence for each finding: chi-squared lost without it, in fitted and in held-out
segments.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import chi2
from scipy.stats import f as fisher

from schemas.discrepancy import HeldOut
from tasks.explain.channels import CHANNELS
from tasks.explain.evidence.cells import (
    CrossValidation,
    cell_equations,
    cross_validation,
    fold_cells,
    scatter_cells,
)
from tasks.explain.evidence.groups import FindingGroup, finding_groups, fitted_columns
from tasks.explain.evidence.scatter import Scatter
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.whitening import equations_of
from tasks.model.regression import WhitenedEquations, inverse
from tasks.model.term import Parameter, parameters_of


@dataclass(frozen=True)
class Evidence:
    """A fitted selection as findings, and its model's columns, whitened, on all rows and by fold.

    own: for each group the columns that are its own and what they are multiplied by now.
    prior: (q,) precision beforehand. known: columns of physics whose factor is one. scatter:
    between the cells of the recording, against which the evidence is counted. smoothing_error: (q,)
    by which the smoothing of poses may have moved each column's factor.
    """

    fit: FittedSelection
    groups: tuple[FindingGroup, ...]
    whole: WhitenedEquations
    folds: CrossValidation
    scatter: Scatter
    own: tuple[tuple[list[int], np.ndarray], ...]
    known: tuple[int, ...]
    prior: np.ndarray
    smoothing_error: np.ndarray

    @classmethod
    def of(cls, fit: FittedSelection) -> "Evidence":
        model, blocks = fit.model, fit.blocks
        groups = finding_groups(fit.selection)
        columns, prediction = fitted_columns(model, groups, blocks.motion)
        free = np.flatnonzero(model.free).tolist()
        position, own_places = {p: q for q, p in enumerate(free)}, model.places
        own: list[tuple[list[int], np.ndarray]] = []
        known: list[int] = []
        for group in groups:
            mine: list[int] = []
            values: list[float] = []
            for term in group.terms:
                place = own_places[term.key]
                if not term.parameters:
                    known.append(len(free) + len(known))
                    mine.append(known[-1])
                    values.append(1.0)
                fitted = [p for p in range(place.start, place.stop) if p in position]
                mine += [position[p] for p in fitted]
                values += model.values[fitted].tolist()
            own.append((mine, np.array(values)))
        misfit = blocks.readings - prediction
        fold, cells = fold_cells(blocks), scatter_cells(blocks)
        by_fold = by_cell = cell_equations(columns, misfit, blocks, fit.noises, fold)
        if not np.array_equal(fold, cells):
            by_cell = cell_equations(columns, misfit, blocks, fit.noises, cells)
        prior = np.concatenate([model.prior[free], np.zeros(len(known))])
        scatter = Scatter(
            by_cell,
            tuple(np.array(mine, int) for mine, _ in own),
            tuple(group.random for group in groups),
            prior,
            np.concatenate([model.values[free], np.ones(len(known))]),
        )
        return cls(
            fit,
            groups,
            equations_of(columns, misfit, blocks, fit.noises),
            cross_validation(by_fold),
            scatter,
            tuple(own),
            tuple(known),
            prior,
            np.zeros(len(prior)),
        )

    @cached_property
    def used(self) -> int:
        """Readings that the fit used."""
        return self.fit.blocks.used

    @cached_property
    def chi2(self) -> float:
        """Of all rows, with every finding."""
        return self._chi2([])

    def gain(self, *numbers: int) -> float:
        """Chi-squared lost when some findings are left out and all else is fitted again."""
        return self._chi2(numbers) - self.chi2

    def evidence(self, number: int) -> float:
        """The gain relative to the residual, gain/φ, as 2·ln of the likelihood ratio of so many
        readings whose noise is not known beforehand (quasi-likelihood).
        """
        gain = max(self.gain(number), 0.0) / self.scatter.dispersion(number)
        readings = self._independent(number)
        return float(readings * np.log1p(gain / readings))

    def delta_bic(self, number: int) -> float:
        """The evidence minus the cost of the determined parameters: ln(1 + n) for each, where n
        is the number of informative cells, since readings within a cell repeat each other
        (effective sample size; Bayarri and others, Prior-based Bayesian information criterion,
        2019). For a random drift the search has charged everything except its strength.
        """
        counts = self.scatter.effective_cells(number)
        if self.groups[number].random:
            counts = np.full(self.groups[number].parameter_count, float(self.scatter.cells.cells))
        else:
            mine = np.array(self.own[number][0], int)[self.scatter.determined(number)]
            counts = counts[~np.isin(mine, self.known)]
        return self.evidence(number) - float(np.log1p(counts).sum())

    def together(self, number: int) -> float:
        """Chi-squared that a finding removes in the company of all others: the mean of what it
        removes as the first and as the last of them (Shapley's value of two).
        """
        every = range(len(self.groups))
        others = [n for n in every if n != number]
        return 0.5 * (self.gain(*every) - self.gain(*others) + self.gain(number))

    def _independent(self, number: int) -> float:
        """Number of effective readings: n/φ, but not fewer than the cells from which φ is
        estimated.
        """
        left, degrees = self.scatter.dispersion(number), self.scatter.degrees(number)
        return max(self.used / left, degrees) if np.isfinite(degrees) else float(self.used)

    def chance(self, number: int) -> float:
        """p value of the evidence for a finding."""
        count = self._parameter_count(number)
        gain = max(self.gain(number), 0.0) / self.scatter.dispersion(number)
        degrees = self.scatter.degrees(number)
        if np.isinf(degrees):
            return float(chi2.sf(gain, count))
        return float(fisher.sf(gain / count, count, degrees))

    def held_out_gain(self, number: int) -> float:
        """Log-likelihood (nats) that one finding adds on held-out segments, relative to the
        residual.
        """
        gain = self._joint_deviance([number])[0] - self._joint_deviance_after[0]
        return 0.5 * gain / self.scatter.dispersion(number)

    def channel_gains(self, number: int) -> np.ndarray:
        """(6,) the same in each channel beside the others, relative to the residual there."""
        gains = 0.5 * (self._joint_deviance([number])[1] - self._joint_deviance_after[1])
        left = [self.scatter.channel_dispersion(number, c) for c in range(len(gains))]
        return np.asarray(gains / np.array(left))

    def added_power(self, number: int) -> np.ndarray:
        """(6,) chi-squared of what a finding adds to each channel beside all others."""
        mine, values = self.own[number]
        size = dict(zip(mine, values.tolist(), strict=True))
        power = np.zeros(len(self.whole.grams))
        for channel, (gram, which) in enumerate(
            zip(self.whole.grams, self.whole.which, strict=True)
        ):
            is_own = np.isin(which, mine)
            own, others = np.flatnonzero(is_own), np.flatnonzero(~is_own)
            shared = gram[np.ix_(others, own)]
            left = gram[np.ix_(own, own)]
            left = left - shared.T @ inverse(gram[np.ix_(others, others)]) @ shared
            x = np.array([size[q] for q in which[own].tolist()])
            power[channel] = x @ left @ x / self.scatter.channel_dispersion(number, channel)
        return power

    def parameters(self, number: int) -> list[Parameter | None]:
        """Of each of a finding's own columns; none: known physics, whose factor is one."""
        model = self.fit.model
        every = parameters_of(model.terms)
        free = [every[p] for p in np.flatnonzero(model.free)]
        return [free[q] if q < len(free) else None for q in self.own[number][0]]

    def u(self, number: int) -> np.ndarray:
        """(k,) standard uncertainties of its own columns, widened by the residual and by what
        the smoothing of poses may have shifted.
        """
        model, mine = self.fit.model, self.own[number][0]
        u = model.u[model.free] * np.sqrt(self.scatter.dispersion(number))
        by_cells = self.scatter.u(number)
        own = [u[q] if q < len(u) else by_cells[k] for k, q in enumerate(mine)]
        return np.hypot(own, self.smoothing_error[mine])

    def correlation(self, number: int) -> np.ndarray:
        """(k, k) of its own columns; known physics goes with nothing."""
        mine, free = np.array(self.own[number][0], int), self.fit.model.free
        covariance = np.eye(self.whole.count)
        fitted = np.arange(int(free.sum()))
        covariance[np.ix_(fitted, fitted)] = self.fit.model.covariance[np.ix_(free, free)]
        size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))[mine]
        return np.asarray(covariance[np.ix_(mine, mine)] / size[:, None] / size)

    def held_out(self, by_events: np.ndarray) -> HeldOut:
        """How segments that a fit did not use are predicted, before and after.

        by_events: (6,) chi-squared per reading that events remove: few parameters to many readings,
        which the regression never sees.
        """
        before, after = self._deviance(range(len(self.groups))), self._deviance_after
        before = before + by_events * self.fit.blocks.used_by_channel
        ratio = {
            name: float(np.sqrt(after[c] / before[c]))
            for c, name in enumerate(CHANNELS)
            if before[c] > 0 and after[c] > 0
        }
        return HeldOut(
            rms_ratio=ratio,
            chi2_per_dof_before=float(before.sum() / self.used),
            chi2_per_dof_after=float(after.sum() / self.used),
        )

    def _parameter_count(self, number: int) -> float:
        """Of a random drift as many as the data determine of it."""
        if not self.groups[number].random:
            return max(1, len(self.own[number][0]))
        mine = np.array(self.own[number][0], int)
        normal = self.whole.normal()[0][np.ix_(mine, mine)]
        known = inverse(normal + np.diag(self.prior[mine]))
        return max(1.0, float(np.trace(known @ normal)))

    @cached_property
    def _deviance_after(self) -> np.ndarray:
        return self._deviance([])

    def _deviance(self, without: Sequence[int]) -> np.ndarray:
        """(6,) of held-out segments, without some findings."""
        return self.folds.deviance(self._kept(without), self._added(without), self.prior)

    @cached_property
    def _joint_deviance_after(self) -> tuple[float, np.ndarray]:
        return self._joint_deviance([])

    def _joint_deviance(self, without: Sequence[int]) -> tuple[float, np.ndarray]:
        return self.folds.joint_deviance(self._kept(without), self._added(without), self.prior)

    def _chi2(self, without: Sequence[int]) -> float:
        """Of a fit to all rows, without some findings."""
        normal, right, misfit = self.whole.normal()
        rows, added = self._kept(without), self._added(without)
        misfit += float(2.0 * added @ right + added @ normal @ added)
        right = right + normal @ added
        block = normal[np.ix_(rows, rows)] + np.diag(self.prior[rows])
        return float(misfit - right[rows] @ inverse(block) @ right[rows])

    def _kept(self, without: Sequence[int]) -> list[int]:
        """The columns that are fitted when some findings are left out."""
        left_out = {q for number in without for q in self.own[number][0]} | set(self.known)
        return [q for q in range(self.whole.count) if q not in left_out]

    def _added(self, numbers: Sequence[int]) -> np.ndarray:
        """What the columns of some findings are multiplied by now, which their misfit lacks."""
        added = np.zeros(self.whole.count)
        for number in numbers:
            mine, values = self.own[number]
            added[mine] = values
        return added
