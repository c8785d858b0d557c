"""The evidence of a smaller model by the equations of a larger one, without fitting it.

What a finding adds is put back into the misfit, its columns are left out, and the others change to
where the normal equations of the rest have their optimum: all of it linear in the columns and the
misfit, so that their products change by a congruence. A term that is not linear in its parameters,
or has a shape, is taken as linear about the fit of the larger model; how far that holds, the
smaller model's own fit tells.
"""

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc

from schemas.recording import AXES
from tasks.explain.evidence.cells import CellEquations, CrossValidation, Scatter
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.explanation import CERTAIN
from tasks.explain.inputs.blocks import Blocks
from tasks.explain.noise import Noise, weighted, whitened_gram
from tasks.explain.search.candidates import Candidate, columns_of
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import FALSE_ALARMS, Selected
from tasks.model.fit import WhitenedEquations, inverse
from tasks.model.model import Model
from tasks.model.term import parameters_of
from tasks.model.terms.standard import GYRO_G_SENSITIVITY, regressors


@dataclass(frozen=True)
class _Change:
    """kept: (k,) the columns that stay, in order. added: (q,) by which every column, times it, is
    put back into the misfit: of those left out what they add now, of the others less their change.
    """

    kept: np.ndarray
    added: np.ndarray

    def of_channel(self, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The matrix (k + 1, m + 1) by which a channel's products change from both sides, and
        which of the columns that stay it has. which: (m,) those that it has now.
        """
        own = np.flatnonzero(np.isin(which, self.kept))
        turn = np.zeros((len(own) + 1, len(which) + 1))
        turn[np.arange(len(own)), own] = 1.0
        turn[-1, :-1], turn[-1, -1] = self.added[which], 1.0
        return turn, np.searchsorted(self.kept, which[own])

    def of_equations(self, equations: WhitenedEquations) -> WhitenedEquations:
        pairs = zip(equations.grams, equations.which, strict=True)
        changed = [(gram, *self.of_channel(which)) for gram, which in pairs]
        return WhitenedEquations(
            tuple(turn @ gram @ turn.T for gram, turn, _ in changed),
            tuple(which for _, _, which in changed),
            len(self.kept),
        )

    def of_cells(self, cells: CellEquations) -> CellEquations:
        """Of every cell."""
        as_one = self.of_equations(WhitenedEquations(cells.grams, cells.which, cells.count))
        return CellEquations(as_one.grams, as_one.which, as_one.count)


def without(evidence: Evidence, number: int) -> Evidence:
    """The evidence of all findings but one, by the equations of all of them.

    What would become negative where no unit has it so is left out as well.
    """
    free = np.flatnonzero(evidence.fit.model.free)
    one_sided = np.zeros(evidence.whole.count, bool)
    one_sided[: len(free)] = _lowest(evidence.fit.model)[free] == 0.0
    left_out = np.isin(np.arange(evidence.whole.count), evidence.own[number][0])
    while True:
        change = _change(evidence, left_out)
        values = evidence.scatter.values - change.added
        below = ~left_out & one_sided & (values < 0.0)
        if not below.any():
            return _reduced(evidence, number, change)
        left_out |= below


def _lowest(model: Model) -> np.ndarray:
    """(p,) the lower end of each parameter's plausible range."""
    return np.array([p.plausible[0] for p in parameters_of(model.terms)])


def _change(evidence: Evidence, left_out: np.ndarray) -> _Change:
    """How the rest changes without some columns (q,) bool."""
    normal, right, _ = evidence.whole.normal()
    values, prior = evidence.scatter.values, evidence.prior
    added = np.where(left_out, values, 0.0)
    fitted = ~left_out
    fitted[list(evidence.known)] = False
    rows = np.flatnonzero(fitted)
    pull = (right + normal @ added - prior * values)[rows]
    added[rows] = -inverse(normal[np.ix_(rows, rows)] + np.diag(prior[rows])) @ pull
    return _Change(np.flatnonzero(~left_out), added)


def _reduced(evidence: Evidence, number: int, change: _Change) -> Evidence:
    kept = change.kept
    values = (evidence.scatter.values - change.added)[kept]
    stay = [n for n in range(len(evidence.groups)) if n != number]
    groups = tuple(evidence.groups[n] for n in stay)
    place = {q: k for k, q in enumerate(kept.tolist())}
    own = [[place[q] for q in evidence.own[n][0] if q in place] for n in stay]
    whole, prior = change.of_equations(evidence.whole), evidence.prior[kept]
    folds = CrossValidation(
        change.of_equations(evidence.folds.whole),
        tuple(map(change.of_equations, evidence.folds.folds)),
    )
    scatter = Scatter(
        change.of_cells(evidence.scatter.cells),
        tuple(np.array(mine, int) for mine in own),
        tuple(group.random for group in groups),
        prior,
        values,
    )
    return Evidence(
        _fit(evidence, number, kept, values, whole.normal()[0] + np.diag(prior)),
        groups,
        whole,
        folds,
        scatter,
        tuple((mine, values[mine]) for mine in own),
        tuple(place[q] for q in evidence.known if q in place),
        prior,
        evidence.smoothing_error[kept],
    )


def _fit(
    evidence: Evidence, number: int, kept: np.ndarray, values: np.ndarray, normal: np.ndarray
) -> FittedSelection:
    """The selection without a finding, its model where the equations have their optimum.

    normal: (k, k) of the columns that stay, with what is known beforehand.
    """
    fit, group = evidence.fit, evidence.groups[number]
    keys = {one.candidate.key for one in group.selected}
    selected = tuple(one for one in fit.selection.selected if one.candidate.key not in keys)
    model, free = fit.model, np.flatnonzero(fit.model.free)
    rows = free[kept[kept < len(free)]]
    moved, still_free = np.zeros(len(model.values)), np.zeros(len(model.values), bool)
    moved[~model.free] = model.values[~model.free]
    moved[rows], still_free[rows] = values[: len(rows)], True
    covariance = np.zeros_like(model.covariance)
    covariance[np.ix_(rows, rows)] = inverse(normal[: len(rows), : len(rows)])
    smaller = replace(model, values=moved, free=still_free, covariance=covariance)
    smaller = smaller.without({term.key for term in group.terms})
    selection = replace(fit.selection, selected=selected)
    return replace(fit, selection=selection, model=smaller)


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

AGREE = 2.0  # chi-squared, the price of a parameter: no decision depends on less
WRONG_MODEL = 2.0  # φ from which on a random drift may be what the rest of the model lacks
ABSORBING = GYRO_G_SENSITIVITY  # absorbs a rate that turns with the vertical
MAX_MISFIT = 1e-3  # p value of what the parameters are beyond the known physics
OBSERVABLE = 1e-9  # of a column's power: less is left of it beside the standard's other columns


def pruned(fit: FittedSelection, trials: int, kept: Collection[str] = ()) -> Evidence:
    """The fitted selection without findings that the others make unnecessary, or that do not stand
    out from the residual.

    The weakest is removed, by the equations of the fit, until all remaining ones are significant;
    then these are fitted. Where their fit is not what the equations said, only the first is
    removed, and the next is decided by the fit of the rest.
    trials: number of candidates tried. kept: names that are not removed. The p value of the
    strongest mismatch is relative to the residual, as its evidence is.
    """
    evidence = Evidence.of(fit)
    chance = [1.0] if _searched(evidence) else [fit.selection.p_value]
    while True:
        smaller = list(_smaller(evidence, trials, kept))
        if not smaller:
            break
        fitted = _fitted(smaller[-1])
        if len(smaller) > 1 and not _agree(fitted, smaller[-1]):
            del smaller[1:]
            fitted = _fitted(smaller[0])
        chance += [_least_chance(each, trials, kept) for each in (evidence, *smaller[:-1])]
        evidence = fitted
    chance.append(_least_chance(evidence, trials, kept))
    selection = replace(evidence.fit.selection, p_value=max(min(chance), fit.selection.p_value))
    return replace(evidence, fit=replace(evidence.fit, selection=selection))


def _smaller(evidence: Evidence, trials: int, kept: Collection[str]) -> Iterator[Evidence]:
    """The evidence without the weakest unsupported finding, without the next, and so on."""
    while True:
        numbers = _in_question(evidence, kept)
        weak = [n for n in numbers if unsupported(evidence, n, trials)]
        if not weak:
            return
        evidence = without(evidence, min(weak, key=evidence.evidence))
        yield evidence


def _fitted(evidence: Evidence) -> Evidence:
    """Of the fit of what it has."""
    return Evidence.of(evidence.fit.reselected(evidence.fit.selection))


def _agree(fitted: Evidence, by_equations: Evidence) -> bool:
    """Whether a fit leaves what the equations of a larger one said that it would."""
    left = max([1.0, *(fitted.scatter.dispersion(n) for n in range(len(fitted.groups)))])
    return abs(fitted.chi2 - by_equations.chi2) < AGREE * left


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
    if group.random and evidence.scatter.dispersion(number) < WRONG_MODEL:
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
