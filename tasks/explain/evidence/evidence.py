"""The evidence for each finding: chi-squared lost without it, in fitted and in held-out
segments.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import chi2
from scipy.stats import f as fisher

from schemas.discrepancy import HeldOut
from tasks.explain.events.saturation import EFFECTS as LIMITS
from tasks.explain.evidence.cells import (
    CrossValidation,
    Scatter,
    cell_equations,
    cross_validation,
    fold_cells,
    scatter_cells,
)
from tasks.explain.evidence.groups import FindingGroup, finding_groups, fitted_columns
from tasks.explain.explanation import CHANNELS, COVERAGE
from tasks.explain.noise import equations_of
from tasks.explain.search.fitted import FittedSelection, fitted
from tasks.model.fit import WhitenedEquations, inverse
from tasks.model.term import EVENTS, Inputs, Parameter, Term, parameters_of
from tasks.model.terms.gyro import GYRO_SCALE_ASYMMETRY
from tasks.motion.whole import Motion


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


# Clipping that a run cannot tell from a scale factor that bends.
#
# A reading that is clipped short of the only rate is too small there, and right everywhere below;
# so is that of a scale factor with a curvature. Rates between rest and the only one are in ramps
# alone.
#
# Clipping as deep as the noise shows in no plateau. It bends a scale factor at one end of the
# range alone, and cuts off the noise there; where a unit rests in a few positions any bend may
# lie at one end, and the noise alone tells.

CLIPPING = {bend: limit for limit in LIMITS for bend in EVENTS[limit].confused_with}
GYRO_CLIPPING = LIMITS[0]
BENDING = (*EVENTS[GYRO_CLIPPING].confused_with, GYRO_SCALE_ASYMMETRY.name)
SLOW_RATE = 0.3  # of the largest rate about an axis: slower ones show neither
HELD = 0.05  # of the largest rate in a second: what changes less is held
ALIKE = 0.05  # relative: rates that differ by less are of one size
NEARLY_ALL = 0.9
END = 0.1  # of the range of a channel's input
MOSTLY = 0.7  # of the bend's power at one end: a parabola over an even input has a quarter there
RESTING = 0.05  # rad/s: what turns faster may vibrate
FEWEST = 200  # readings at rest by whose scatter noise is compared
CUT = 0.9  # of the noise elsewhere: a hundredth is what chance makes


def possibly_clipped(effect: str, channels: tuple[int, ...], motion: Motion) -> tuple[str, ...]:
    """The name of clipping, if an effect bends the scale factor of channels (0 to 5) that turned at
    one size of rate only; nothing otherwise.
    """
    gyros = [channel for channel in channels if channel < 3]
    if effect not in BENDING or not gyros:
        return ()
    return (GYRO_CLIPPING,) if all(_one_size(motion, axis) for axis in gyros) else ()


def _one_size(motion: Motion, axis: int) -> bool:
    """Whether an axis was held at one size of rate, to either side, or at slow ones."""
    rate = np.abs(np.nan_to_num(motion.rate[:, axis]))
    turning = rate > SLOW_RATE * rate.max(initial=0.0)
    if not turning.any():
        return False
    size = float(np.median(rate[turning]))
    held = turning & (np.abs(np.nan_to_num(motion.acceleration[:, axis])) < HELD * size)
    if 2 * held.sum() < turning.sum():
        return False  # never held, as by hand
    return bool(np.mean(np.abs(rate[held] - size) < ALIKE * size) > NEARLY_ALL)


def possibly_clipped_in_noise(
    effect: str, contribution: np.ndarray, readings: np.ndarray, motion: Motion
) -> tuple[str, ...]:
    """The name of clipping, if an effect bends a scale factor at one end or noise is cut there.

    contribution, readings: (n, 6) rad/s and m/s², what the effect adds to the readings, and they.
    The channel that it changes most, in units of its own range, tells where it bends.
    """
    if effect not in CLIPPING:
        return ()
    inputs = Inputs.of(motion)
    felt = np.hstack([inputs.rate, inputs.force])
    channels = [c for c in range(felt.shape[1]) if np.nan_to_num(contribution[:, c]).any()]
    bends = [_bend(felt[:, c], contribution[:, c]) for c in channels]
    total, at_end = max(bends, default=(0.0, 0.0))
    resting = np.linalg.norm(np.nan_to_num(motion.rate), axis=1) < RESTING
    cut = any(_noise_is_cut(felt[:, c], readings[:, c], resting) for c in channels)
    return (CLIPPING[effect],) if cut or at_end > MOSTLY * total > 0.0 else ()


def _bend(own: np.ndarray, added: np.ndarray) -> tuple[float, float]:
    """Power that no straight line takes of what is added (n,) to an input (n,), in units of the
    input's range; and how much of it lies at one end.
    """
    known = np.isfinite(own) & np.isfinite(added)
    own, added = own[known], added[known]
    size = float(np.ptp(own)) if len(own) else 0.0
    if not size > 0.0:
        return 0.0, 0.0
    place = (own - own.min()) / size
    line = np.polynomial.polynomial.polyfit(place, added / size, 1)
    power = (added / size - np.polynomial.polynomial.polyval(place, line)) ** 2
    return float(power.sum()), max(float(power[side].sum()) for side in _ends(place))


def _noise_is_cut(own: np.ndarray, readings: np.ndarray, resting: np.ndarray) -> bool:
    """Whether readings (n,) at rest scatter less at an end of their input (n,) than within it.

    By second differences of three rows that all lie there.
    """
    known = resting & np.isfinite(own)
    if not known.any() or not np.ptp(own[known]) > 0.0:
        return False
    place = (own - own[known].min()) / np.ptp(own[known])
    scatter = np.abs(np.diff(readings, 2))

    def level(rows: np.ndarray) -> float:
        rows = rows & known
        three = rows[:-2] & rows[1:-1] & rows[2:] & np.isfinite(scatter)
        return float(scatter[three].mean()) if three.sum() >= FEWEST else np.nan

    within = level((place >= END) & (place <= 1.0 - END))
    return any(level(end) < CUT * within for end in _ends(place))


def _ends(place: np.ndarray) -> Iterator[np.ndarray]:
    yield from (place < END, place > 1.0 - END)


# When a bias stepped, and how well the readings about the step say so.


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


# How far the parameters of findings depend on other findings that are implausible.
#
# A term fitted far beyond its plausible range has the wrong form, and biases the estimates of the
# terms that are correlated with it (misspecified regressors).


def change_without(evidence: Evidence, numbers: Collection[int]) -> np.ndarray:
    """(q,) by how much each column's factor changes, in the unit of its parameter, when some
    findings are left out and all else is fitted again; 0 for the columns of those findings.

    numbers: of the findings.
    """
    model, blocks = evidence.fit.model, evidence.fit.blocks
    keys = {term.key for number in numbers for term in evidence.groups[number].terms}
    rest = fitted(model.without(keys), blocks, evidence.fit.noises)
    moved = np.abs(model.with_values_of(rest).values - model.values)
    change = np.zeros(evidence.whole.count)
    change[: int(model.free.sum())] = moved[model.free]
    return change
