"""What a fitted selection is worth: its findings, the evidence for each, and what of them stands.

Chi-squared that is lost without a finding, in all rows and in segments that a fit did not use, is
counted against how much the cells of the recording disagree on it.
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.special import chdtrc
from scipy.stats import chi2
from scipy.stats import f as fisher

from schemas.discrepancy import HeldOut
from schemas.recording import AXES
from tasks.explain.evidence.cells import (
    CellEquations,
    CellInfluence,
    CrossValidation,
    cell_equations,
    cell_influence,
    cross_validation,
    fold_cells,
    scatter_cells,
)
from tasks.explain.explanation import CERTAIN, CHANNELS, COVERAGE, UNNAMED
from tasks.explain.inputs.blocks import Blocks
from tasks.explain.noise import Noise, equations_of, weighted, whitened_gram
from tasks.explain.search.candidates import Candidate, columns_of
from tasks.explain.search.fitted import FittedSelection, fitted, is_at_bound
from tasks.explain.search.stepwise import FALSE_ALARMS, Selected, Selection
from tasks.model.fit import WhitenedEquations, inverse
from tasks.model.model import Model
from tasks.model.term import Column, Parameter, Term, parameters_of
from tasks.model.terms.standard import GYRO_G_SENSITIVITY, regressors
from tasks.motion.whole import Motion

# Which selected candidates form one finding, and which findings can be given a name.

PER_TURN = "per_turn"  # the shape of what comes so many times a turn
SAME_STEP = 5.0  # s within which jumps are one step, found anew in each triad or gradual


@dataclass(frozen=True)
class FindingGroup:
    """One finding: its name, the terms that model it, and the candidates selected of it."""

    name: str
    terms: tuple[Term, ...]
    selected: tuple[Selected, ...]

    @property
    def random(self) -> bool:
        """Whether it is a random drift, or a random function of its own drive."""
        return self.selected[0].candidate.prior is not None

    @property
    def unlisted(self) -> bool:
        """Whether it is a kind of behaviour in a form that no publication lists."""
        return self.selected[0].candidate.unlisted

    @property
    def nuisance(self) -> bool:
        """Whether every model of such a recording has it."""
        return self.selected[0].candidate.nuisance

    @property
    def known(self) -> bool:
        """Whether its size is known beforehand, so that it cannot be a shadow of something else."""
        return self.absorbed_by is not None or any(one.candidate.known for one in self.selected)

    @property
    def absorbed_by(self) -> str | None:
        return self.selected[0].absorbed_by

    @property
    def parameter_count(self) -> int:
        """What it is charged for: of a random drift one for each candidate."""
        if self.random:
            return len(self.selected)
        return sum(len(one.candidate.own) for one in self.selected if not one.candidate.known)


def finding_groups(selection: Selection) -> tuple[FindingGroup, ...]:
    """Groups of candidates that form one finding: those of one name, those that compensate for each
    other, those without a name of one term; several steps are jumps.

    If the strongest form of a name was driven to its limit, the finding loses its name; likewise if
    neighbouring orders of a once-per-turn component were selected.
    """
    named: dict[object, list[Selected]] = {}
    for one in selection.selected:
        name = one.candidate.name
        key = one.candidate.term.key if name == UNNAMED else one.group or name
        named.setdefault(key, []).append(one)
    return tuple(_group(_name_of(some), some) for some in named.values())


def _group(name: str, some: Sequence[Selected]) -> FindingGroup:
    terms = {one.candidate.term.key: one.candidate.term for one in some}
    return FindingGroup(name, tuple(terms.values()), tuple(some))


def _name_of(some: Sequence[Selected]) -> str:
    first = some[0].candidate.term
    times = [one.candidate.term.at[0] for one in some if first.time_course == "jump"]
    several = max(times, default=0.0) - min(times, default=0.0) > SAME_STEP
    doubtful = any(one.candidate.unlisted and UNNAMED in one.rivals for one in some)
    unnamed = several or doubtful or _at_one_place(some) or is_at_bound(first)
    return UNNAMED if unnamed else first.name


def _at_one_place(some: Sequence[Selected]) -> bool:
    """Whether waves of neighbouring orders a turn are the series of something at one place of it.

    What comes N times a turn has that order and its multiples.
    """
    terms = [one.candidate.term for one in some]
    orders = sorted(
        (term.at[1:], term.at[0])
        for term in terms
        if term.shapes[:1] and term.shapes[0].name == PER_TURN
    )
    return any(
        axis == other and lower > 1.0 and higher == lower + 1.0
        for (axis, lower), (other, higher) in pairwise(orders)
    )


def fitted_columns(
    model: Model, groups: Sequence[FindingGroup], motion: Motion
) -> tuple[list[Column], np.ndarray]:
    """Of a model's free parameters, then of known physics in the order of the groups; and what
    the model predicts, (n, 6).
    """
    design = model.linearised(motion, model.free)
    columns = [design.columns[p] for p in np.flatnonzero(model.free).tolist()]
    for term in (term for group in groups for term in group.terms if not term.parameters):
        effect = model.effect_of({term.key}, motion, design.prediction)
        columns.append(dict(enumerate(effect.T)))
    return columns, design.prediction


# The evidence for each finding.

MOST_PRIOR = 0.5  # of what is known of a parameter: with more of it the data do not determine it


@dataclass(frozen=True)
class Evidence:
    """A fitted selection as findings, and its model's equations: of all rows, by fold, by cell.

    own: for each group the columns (k,) that are its own. values: (q,) that the columns are
    multiplied by. prior: (q,) precision beforehand. known: (m,) columns of physics whose factor is
    one. smoothing_error: (q,) by which the smoothing of poses may have moved each factor.
    """

    fit: FittedSelection
    groups: tuple[FindingGroup, ...]
    whole: WhitenedEquations
    folds: CrossValidation
    cells: CellEquations
    own: tuple[np.ndarray, ...]
    known: np.ndarray
    values: np.ndarray
    prior: np.ndarray
    smoothing_error: np.ndarray

    @classmethod
    def of(cls, fit: FittedSelection) -> "Evidence":
        model, blocks = fit.model, fit.blocks
        groups = finding_groups(fit.selection)
        columns, prediction = fitted_columns(model, groups, blocks.motion)
        free = np.flatnonzero(model.free)
        known, own = iter(range(len(free), len(columns))), []
        for group in groups:
            mine = [[next(known)] for term in group.terms if not term.parameters]
            places = [model.places[term.key] for term in group.terms]
            mine += [np.flatnonzero((free >= p.start) & (free < p.stop)).tolist() for p in places]
            own.append(np.array([q for some in mine for q in some], int))
        misfit = blocks.readings - prediction
        fold, cells = fold_cells(blocks), scatter_cells(blocks)
        by_fold = by_cell = cell_equations(columns, misfit, blocks, fit.noises, fold)
        if not np.array_equal(fold, cells):
            by_cell = cell_equations(columns, misfit, blocks, fit.noises, cells)
        more = len(columns) - len(free)
        return cls(
            fit,
            groups,
            equations_of(columns, misfit, blocks, fit.noises),
            cross_validation(by_fold),
            by_cell,
            tuple(own),
            np.arange(len(free), len(columns)),
            np.concatenate([model.values[free], np.ones(more)]),
            np.concatenate([model.prior[free], np.zeros(more)]),
            np.zeros(len(columns)),
        )

    def dispersion(self, number: int) -> float:
        """φ ≥ 1: how much more the cells disagree on a finding than the fit's noise makes them."""
        return self._influences[number][1].dispersion

    def degrees(self, number: int) -> float:
        """Of freedom with which φ is known; infinite where it is one."""
        return self._influences[number][1].degrees

    def determined(self, number: int) -> np.ndarray:
        """Which of a finding's own columns (m,) the data determine, by their place among them."""
        return self._influences[number][0]

    def effective_cells(self, number: int) -> np.ndarray:
        """(m,) number of equal cells that would be as informative about each determined column."""
        return self._influences[number][1].effective_cells

    def information_by_cell(self, number: int) -> np.ndarray:
        """(cells,) share of the information on a finding's parameters that comes from each cell."""
        influence = self._influences[number][1]
        return np.einsum("ij,cji->c", influence.covariance, influence.by_cell)

    def channel_dispersion(self, number: int, channel: int) -> float:
        """φ of a finding in one channel alone; where it does not touch it, of all its columns."""
        used = np.zeros((self.cells.cells, len(self.cells.grams)), bool)
        used[:, channel] = True
        read = self.cells.which[channel]
        own = np.intersect1d(self.own[number], read)
        own = own if len(own) else read
        return self._among(own, *self.cells.normal(used))[1].dispersion

    def by_cells(self, number: int) -> tuple[CellInfluence, np.ndarray]:
        """What each cell asks of a finding's own columns (k,), and by how much the cells' optimum
        differs from the fit's values (k,).
        """
        return cell_influence(*self._by_cell, self.own[number], self.prior, self.values)

    @cached_property
    def _by_cell(self) -> tuple[np.ndarray, np.ndarray]:
        return self.cells.normal()

    @cached_property
    def _influences(self) -> list[tuple[np.ndarray, CellInfluence]]:
        """For each finding its determined columns, and the influence of each cell on them.

        A random drift follows whatever the cells require: the influence of its channels' other
        columns shows how far the residual may be counted as noise.
        """
        random = [own for own, group in zip(self.own, self.groups, strict=True) if group.random]
        steady = np.setdiff1d(np.arange(len(self.prior)), np.concatenate([*random, []]))
        return [
            self._among(self._beside(own, steady) if group.random else own, *self._by_cell)
            for own, group in zip(self.own, self.groups, strict=True)
        ]

    def _beside(self, own: np.ndarray, steady: np.ndarray) -> np.ndarray:
        """The steady columns in the channels of some others."""
        read = [which for which in self.cells.which if np.isin(own, which).any()]
        return np.intersect1d(steady, np.concatenate([*read, []])).astype(int)

    def _among(
        self, own: np.ndarray, normal: np.ndarray, right: np.ndarray
    ) -> tuple[np.ndarray, CellInfluence]:
        influence = cell_influence(normal, right, own, self.prior, self.values)[0]
        variance = np.diag(influence.covariance)
        determined = np.flatnonzero((variance > 0) & (variance * self.prior[own] < MOST_PRIOR))
        if len(determined) < len(own):
            influence = cell_influence(normal, right, own[determined], self.prior, self.values)[0]
        return determined, influence

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
        gain = max(self.gain(number), 0.0) / self.dispersion(number)
        readings = self._independent(number)
        return float(readings * np.log1p(gain / readings))

    def delta_bic(self, number: int) -> float:
        """The evidence minus the cost of the determined parameters: ln(1 + n) for each, where n
        is the number of informative cells, since readings within a cell repeat each other
        (effective sample size; Bayarri and others, Prior-based Bayesian information criterion,
        2019). For a random drift the search has charged everything except its strength.
        """
        counts = self.effective_cells(number)
        if self.groups[number].random:
            counts = np.full(self.groups[number].parameter_count, float(self.cells.cells))
        else:
            mine = self.own[number][self.determined(number)]
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
        left, degrees = self.dispersion(number), self.degrees(number)
        return max(self.used / left, degrees) if np.isfinite(degrees) else float(self.used)

    def chance(self, number: int) -> float:
        """p value of the evidence for a finding."""
        count = self._parameter_count(number)
        gain = max(self.gain(number), 0.0) / self.dispersion(number)
        degrees = self.degrees(number)
        if np.isinf(degrees):
            return float(chi2.sf(gain, count))
        return float(fisher.sf(gain / count, count, degrees))

    def held_out_gain(self, number: int) -> float:
        """Log-likelihood (nats) that one finding adds on held-out segments, relative to the
        residual.
        """
        gain = self._joint_deviance([number])[0] - self._joint_deviance_after[0]
        return 0.5 * gain / self.dispersion(number)

    def channel_gains(self, number: int) -> np.ndarray:
        """(6,) the same in each channel beside the others, relative to the residual there."""
        gains = 0.5 * (self._joint_deviance([number])[1] - self._joint_deviance_after[1])
        left = [self.channel_dispersion(number, c) for c in range(len(gains))]
        return np.asarray(gains / np.array(left))

    def added_power(self, number: int) -> np.ndarray:
        """(6,) chi-squared of what a finding adds to each channel beside all others."""
        mine = self.own[number]
        power = np.zeros(len(self.whole.grams))
        for channel, (gram, which) in enumerate(
            zip(self.whole.grams, self.whole.which, strict=True)
        ):
            is_own = np.isin(which, mine)
            own, others = np.flatnonzero(is_own), np.flatnonzero(~is_own)
            shared = gram[np.ix_(others, own)]
            left = gram[np.ix_(own, own)]
            left = left - shared.T @ inverse(gram[np.ix_(others, others)]) @ shared
            x = self.values[which[own]]
            power[channel] = x @ left @ x / self.channel_dispersion(number, channel)
        return power

    def parameters(self, number: int) -> list[Parameter | None]:
        """Of each of a finding's own columns; none: known physics, whose factor is one."""
        model = self.fit.model
        every = parameters_of(model.terms)
        free = [every[p] for p in np.flatnonzero(model.free)]
        return [free[q] if q < len(free) else None for q in self.own[number].tolist()]

    def u(self, number: int) -> np.ndarray:
        """(k,) standard uncertainties of its own columns, widened by the residual and by what
        the smoothing of poses may have shifted.
        """
        model, mine = self.fit.model, self.own[number]
        u = model.u[model.free] * np.sqrt(self.dispersion(number))
        own = np.sqrt(np.maximum(np.diag(self.by_cells(number)[0].covariance), 0.0))
        own *= np.sqrt(self.dispersion(number))
        fitted = np.flatnonzero(mine < len(u))
        own[fitted] = u[mine[fitted]]
        return np.hypot(own, self.smoothing_error[mine])

    def correlation(self, number: int) -> np.ndarray:
        """(k, k) of its own columns; known physics goes with nothing."""
        mine, free = self.own[number], self.fit.model.free
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
            return max(1, len(self.own[number]))
        mine = self.own[number]
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
        left_out = {q for number in without for q in self.own[number].tolist()}
        every = range(self.whole.count - len(self.known))
        return [q for q in every if q not in left_out]

    def _added(self, numbers: Sequence[int]) -> np.ndarray:
        """What the columns of some findings are multiplied by now, which their misfit lacks."""
        added = np.zeros(self.whole.count)
        for number in numbers:
            added[self.own[number]] = self.values[self.own[number]]
        return added


# What of a search stands beside all the rest, and known physics that is absorbed and yet stands.
#
# What does not stand out beside the others and the residual is removed.
#
# Known physics may be absorbed whole by the standard's parameters, and yet leave its mark on
# them. Two positions cannot tell Earth's rotation from g-sensitivity: no residual is left. But
# physics whose size is known beforehand predicts the values of the parameters that absorb it.
# Where they have those values, and are otherwise nothing, it is the likelier cause: a parameter
# that is free over its plausible range would have hit that value by chance. Where not, nothing is
# claimed.

WRONG_MODEL = 2.0  # φ from which on a random drift may be what the rest of the model lacks
ABSORBING = GYRO_G_SENSITIVITY  # absorbs a rate that turns with the vertical
MAX_MISFIT = 1e-3  # p value of what the parameters are beyond the known physics
OBSERVABLE = 1e-9  # of a column's power: less is left of it beside the standard's other columns


def pruned(fit: FittedSelection, trials: int, kept: Collection[str] = ()) -> Evidence:
    """The fitted selection without findings that the others make unnecessary, or that do not stand
    out from the residual: the weakest is removed and the rest fitted again, until all that remain
    are significant.

    trials: number of candidates tried. kept: names that are not removed. The p value of the
    strongest mismatch is relative to the residual, as its evidence is.
    """
    evidence = Evidence.of(fit)
    chance = [1.0] if _searched(evidence) else [fit.selection.p_value]
    while True:
        chance.append(_least_chance(evidence, trials, kept))
        weak = [n for n in _in_question(evidence, kept) if unsupported(evidence, n, trials)]
        if not weak:
            break
        weakest = min(weak, key=evidence.evidence)
        evidence = Evidence.of(evidence.fit.without(evidence.groups[weakest].selected))
    selection = replace(evidence.fit.selection, p_value=max(min(chance), fit.selection.p_value))
    return replace(evidence, fit=replace(evidence.fit, selection=selection))


def _least_chance(evidence: Evidence, trials: int, kept: Collection[str]) -> float:
    """Of the findings in question, corrected for the number tried."""
    return min((trials * evidence.chance(n) for n in _in_question(evidence, kept)), default=np.inf)


def _in_question(evidence: Evidence, kept: Collection[str]) -> list[int]:
    return [n for n in _searched(evidence) if evidence.groups[n].name not in kept]


def unsupported(evidence: Evidence, number: int, trials: int) -> bool:
    """Whether a finding gains no more than chance would, with so many candidates tried, or
    segments that a fit did not use are not predicted better with it.
    """
    group, held_out_gain = evidence.groups[number], evidence.held_out_gain(number)
    if group.absorbed_by:
        return False
    if group.random and evidence.dispersion(number) < WRONG_MODEL:
        return held_out_gain <= 0.0  # the search has charged it for its course
    chance = evidence.chance(number) * trials
    return held_out_gain <= 0.0 or chance > FALSE_ALARMS or evidence.delta_bic(number) <= 0.0


def _searched(evidence: Evidence) -> list[int]:
    """The numbers of the findings that are not in every model of such a recording."""
    return [n for n, group in enumerate(evidence.groups) if not group.nuisance]


def with_absorbed(evidence: Evidence, candidates: Sequence[Candidate], blocks: Blocks) -> Evidence:
    """The evidence with the known physics that the readings ask for though it is absorbed.

    blocks: those of the search.
    """
    fit, names = evidence.fit, {one.name for one in evidence.fit.selection.candidates}
    for known in (one for one in candidates if one.known and one.name not in names):
        claim = absorbed(known, blocks, fit.selection.noises)
        if claim is not None:
            selected = (*fit.selection.selected, claim)
            # Odds are as improbable by chance as they are large (Markov's inequality).
            p_value = min(fit.selection.p_value, math.exp(-0.5 * claim.score))
            fit = fit.reselected(replace(fit.selection, selected=selected, p_value=p_value))
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
    if gain - rival < CERTAIN or chdtrc(count, beyond) < MAX_MISFIT:
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
    rows = [*base, effect, blocks.readings[:, number]]
    signals = weighted(rows, blocks.weight[:, number], blocks)
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
