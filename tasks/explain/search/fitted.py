"""Fits the selected effects in their exact form, alternating search and fit."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.special import comb

from tasks.explain.explanation import UNNAMED
from tasks.explain.inputs.blocks import Blocks, well_known
from tasks.explain.inputs.prepared import Prepared
from tasks.explain.noise import Noise, equations_of, scores_of
from tasks.explain.progress import Progress, report_progress, silent
from tasks.explain.search.candidates import (
    Candidate,
    behaviours,
    candidates_of,
    is_instant,
    plausible_half_ranges,
    searched_by_name,
    with_nuisances,
    with_proposed_shapes,
)
from tasks.explain.search.design import (
    BandedDesign,
    banded_design,
    normal_equations,
    residual_noises,
    with_columns,
)
from tasks.explain.search.empirical import empirical
from tasks.explain.search.stepwise import (
    Selected,
    Selection,
    initial_noises,
    noises_beside,
    rank,
    search,
    with_rivals,
)
from tasks.model.catalogue import catalogue
from tasks.model.fit import Step, WhitenedEquations, gauss_newton
from tasks.model.model import Model
from tasks.model.term import COUNTS, Column, Term
from tasks.model.terms.hysteresis import PLAYS
from tasks.model.terms.reference_frame import REFERENCE_FRAME
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.model.terms.timing import TIME_OFFSET
from tasks.motion.whole import Motion

# Fits the standard's model and the selected terms together in their exact, non-linear form.
#
# In the transformed domain noise of S = w + b/f is independent from coefficient to coefficient:
# generalised least squares, whose covariance holds for samples that drift.

MAX_STEPS = 10
SETTLED = 0.02  # of a standard uncertainty: nothing moves any more
NO_GAIN = 0.01  # chi-squared that a step promises: what still moves is not determined


def model_of(selected: Sequence[tuple[Candidate, np.ndarray]], blocks: Blocks) -> Model:
    """The standard's model at its ideal values and the selected terms at nothing.

    selected: candidates with the prior precision (m,) of their parameters, zero for most. What the
    recording does not let the standard's model determine (a scale factor where nothing turned)
    stays as an ideal unit has it.
    """
    terms: list[Term] = list(STANDARD_TERMS)
    ideal = Model.of(STANDARD_TERMS)
    columns = ideal.linearised(blocks.motion).columns
    observable = np.array([_observable(column, blocks.weight) for column in columns])
    free = {key: observable[place] for key, place in ideal.places.items()}
    prior = {key: np.zeros(len(own)) for key, own in free.items()}
    for candidate, precision in selected:
        term = candidate.term
        if term.key not in free:
            terms.append(term)
            free[term.key] = np.zeros(len(term.parameters), bool)
            prior[term.key] = np.array([4.0 / np.ptp(p.plausible) ** 2 for p in term.parameters])
        if term.parameters:
            free[term.key][list(candidate.own)] = True
            prior[term.key][list(candidate.own)] += precision
    return Model.of(
        tuple(terms), free=np.concatenate([*free.values()]), prior=np.concatenate([*prior.values()])
    )


def _observable(column: Column, weight: np.ndarray) -> bool:
    return any(np.nan_to_num(signal * weight[:, c]).any() for c, signal in column.items())


def with_later_clock(model: Model, delay: float) -> Model:
    """The model with a clock that is `delay` seconds later still."""
    values = model.values.copy()
    for (name, _), place in model.places.items():
        if name == TIME_OFFSET.name:
            values[place] += delay
    return replace(model, values=values)


def fitted(model: Model, blocks: Blocks, noises: Sequence[Noise]) -> Model:
    """The model with its free parameters and continuous shapes fitted.

    noises: of a coefficient at the blocks' rate.
    """

    def whiten(columns: Sequence[Column], misfit: np.ndarray) -> WhitenedEquations:
        return equations_of(columns, misfit, blocks, noises)

    def scores(columns: Sequence[Column], misfit: np.ndarray) -> tuple[np.ndarray, float]:
        return scores_of(columns, misfit, blocks, noises)

    motion, readings = blocks.motion, blocks.readings
    settled = _Settled(blocks.used)
    return gauss_newton(model, motion, readings, whiten, settled, MAX_STEPS, scores)[0]


class _Settled:
    """Whether nothing moves any more beside its standard uncertainty, or promises to gain.

    Nor need what is so nearly linear be linearised again that the first step with the columns of
    the one before it has nothing left to do.
    """

    def __init__(self, used: int) -> None:
        """used: number of readings."""
        self.used = used
        self.first: Step | None = None  # with the present columns
        self.tried, self.nearly_linear = 0, False

    def __call__(self, model: Model, step: Step) -> bool:
        if self.first is None or step.columns is not self.first.columns:
            self.first, self.tried, self.nearly_linear = step, 0, False
        elif step.change is self.first.change:
            return self.nearly_linear or self._small(step)
        else:
            self.tried += 1
            self.nearly_linear = self.tried == 1 and self._small(step, SETTLED**2)
        return self._small(step)

    def _small(self, step: Step, no_gain: float = NO_GAIN) -> bool:
        # u is as much larger as the model is wrong
        dispersion = max(1.0, step.misfit / self.used)
        moves = np.abs(step.change) > SETTLED * np.sqrt(dispersion) * step.u + 1e-300
        return not moves.any() or step.gain < no_gain * dispersion


def linearised(
    model: Model, blocks: Blocks, selected: Sequence[Candidate]
) -> tuple[dict[int, Column], np.ndarray]:
    """Columns of the selected candidates' parameters (by their number in the design) where the fit
    put them, and the readings (n, 6) that a linear model of these columns would have had.
    """
    own, columns = model.places, dict[int, Column]()
    wanted = np.zeros(len(model.values), bool)
    for candidate in (one for one in selected if not one.known):
        wanted[[own[candidate.term.key].start + q for q in candidate.own]] = True
    design = model.linearised(blocks.motion, wanted)
    readings = blocks.readings - design.prediction
    for candidate in selected:
        if candidate.known:
            effect = model.effect_of({candidate.term.key}, blocks.motion, design.prediction)
            columns[candidate.members[0]] = dict(enumerate(effect.T))
            readings = readings + effect
            continue
        first = own[candidate.term.key].start
        for p, q in zip(candidate.members, candidate.own, strict=True):
            columns[p] = design.columns[first + q]
            for channel, signal in columns[p].items():
                readings[:, channel] += model.values[first + q] * signal
    return columns, _known_without(readings, model, blocks, selected)


def _known_without(
    readings: np.ndarray, model: Model, blocks: Blocks, selected: Sequence[Candidate]
) -> np.ndarray:
    """The linear model's readings (n, 6), where the candidates are unknown those beside the rest.

    As beside a gap, where what happened before is not known: their columns say nothing there, but
    those of the standard's model do.
    """
    if not (np.isnan(readings) & (blocks.weight > 0.0)).any():
        return np.nan_to_num(readings)
    rest = model.without({one.term.key for one in selected})
    beside = blocks.readings - rest.prediction(blocks.motion)
    return np.nan_to_num(np.where(np.isnan(readings), beside, readings))


OF_TRACKING = (TIME_OFFSET.name, REFERENCE_FRAME.name)  # nuisances of poses
SEARCH_RATE, REFIT_RATE = 25.0, 50.0  # Hz
MAX_RESOLVED = 40_000  # blocks that may be halved
ABRUPT = 0.005  # of the rates' variance that lies near half the blocks' rate: they alias
NOISE_ROUNDS = 2  # of a fit and the noise that it leaves
MAX_SEARCHES = 3  # each after a fit of all that was selected in its real form


@dataclass(frozen=True)
class FittedSelection:
    """What was selected, its candidates with the shapes of the model that was fitted to them.

    blocks: what the model is fitted to. search_rate: of the blocks whose noise the selection has.
    """

    selection: Selection
    model: Model
    blocks: Blocks
    search_rate: float

    @classmethod
    def of(
        cls, selection: Selection, blocks: Blocks, search_rate: float, start: Model | None = None
    ) -> "FittedSelection":
        """start: a model whose values the fit starts from."""
        candidates = selection.candidates
        model = model_of([(one, selection.prior_precision(one)) for one in candidates], blocks)
        if start is not None:
            model = model.with_values_of(start)
        model = fitted(model, blocks, _at_rate(selection.noises, blocks.rate / search_rate))
        terms = {term.key: term for term in model.terms}
        shaped = [replace(one, term=terms[one.term.key], fitted=True) for one in candidates]
        return cls(selection.with_candidates(shaped), model, blocks, search_rate)

    @property
    def noises(self) -> tuple[Noise, ...]:
        """The noise of the blocks that the model is fitted to."""
        return _at_rate(self.selection.noises, self.blocks.rate / self.search_rate)

    def reselected(self, selection: Selection) -> "FittedSelection":
        """Another selection, fitted from the values of this one."""
        return FittedSelection.of(selection, self.blocks, self.search_rate, self.model)

    def without(self, selected: Sequence[Selected]) -> "FittedSelection":
        """The same selection without some members, fitted again."""
        keys = {one.candidate.key for one in selected}
        kept = tuple(one for one in self.selection.selected if one.candidate.key not in keys)
        return self.reselected(replace(self.selection, selected=kept))


@dataclass(frozen=True)
class Searched:
    """What a search of a recording selected, or was asked for, fitted to it.

    candidates: all that were tried. blocks: those of the search.
    """

    prepared: Prepared
    candidates: tuple[Candidate, ...]
    blocks: Blocks
    fit: FittedSelection

    def as_stamped(self, fit: FittedSelection) -> FittedSelection:
        """What was selected with the stamps taken back, for the stamps as they are."""
        if not self.prepared.delay:
            return fit
        if TIME_OFFSET.name not in [one.name for one in fit.selection.candidates]:
            offset = next(one for one in self.candidates if one.name == TIME_OFFSET.name)
            selected = (Selected(offset, 0.0, 0.0), *fit.selection.selected)
            fit = fit.reselected(replace(fit.selection, selected=selected))
        # What fits the little that was left as well does not fit the whole, which no other absorbs.
        selected = tuple(
            replace(one, gain=np.inf, rivals=()) if one.candidate.name == TIME_OFFSET.name else one
            for one in fit.selection.selected
        )
        selection = replace(fit.selection, selected=selected)
        model = with_later_clock(fit.model, self.prepared.delay)
        late = self.prepared.blocks_as_stamped(REFIT_RATE)
        return replace(fit, selection=selection, model=model, blocks=late)

    def resolved(self, fit: FittedSelection) -> FittedSelection:
        """The same fitted to blocks half as long, where the motion reverses within one."""
        if len(fit.blocks.t) > MAX_RESOLVED or not _abrupt(fit.blocks):
            return fit
        prepared = self.prepared
        blocks_at = prepared.blocks_as_stamped if prepared.delay else prepared.blocks
        return replace(fit, blocks=blocks_at(2.0 * REFIT_RATE)).reselected(fit.selection)


def _abrupt(blocks: Blocks) -> bool:
    """Whether much of the rates' variance lies in the fastest changes that blocks show.

    A delay of a turn that reverses within a block is not told by the means of blocks. Poses are
    compared below their own band alone.
    """
    if blocks.motion.tracking is not None:
        return False
    rate = blocks.motion.rate[np.isfinite(blocks.motion.rate).all(axis=1)]
    white = float(comb(4, np.arange(5)) @ comb(4, np.arange(5)))  # of a fourth difference
    fastest = (np.diff(rate, 4, axis=0) ** 2).sum(axis=1).mean() / white
    return bool(fastest > ABRUPT * rate.var(axis=0).sum())


def searched(
    prepared: Prepared,
    only: Sequence[str] | None = None,
    progress: Progress = silent,
) -> Searched:
    """The effects that a search selects of the catalogue and of empirical terms.

    only: names of the catalogue that are fitted instead, without a search.
    """
    report_progress(progress, "candidates")
    coarse, fine = prepared.blocks(SEARCH_RATE), prepared.blocks(REFIT_RATE)
    listed = catalogue(prepared.recording, coarse.motion)
    if only is not None:
        candidates, columns = candidates_of(
            [term for term in listed if term.name in only], coarse.motion
        )
        # and not the random drifts that a search tries besides
        candidates = tuple(one for one in candidates if one.name in only)
        report_progress(progress, "search")
        fit = all_fitted(_design(coarse, candidates, columns), candidates, fine)
        return Searched(prepared, candidates, coarse, fit)
    terms = [*listed, *empirical(coarse.motion)]
    found = _searched(prepared, terms, coarse, fine, progress)
    if prepared.delay:
        return found
    kinds = with_kinds(listed, found.fit.selection.selected, coarse.motion)
    if not kinds:
        return found
    again = _searched(prepared, kinds, coarse, fine, progress)
    return again if any(one.unlisted for one in again.fit.selection.candidates) else found


def _searched(
    prepared: Prepared, terms: Sequence[Term], coarse: Blocks, fine: Blocks, progress: Progress
) -> Searched:
    candidates, columns = candidates_of(terms, coarse.motion)
    if coarse.motion.tracking is not None:
        candidates = tuple(with_nuisances(candidates, OF_TRACKING))
    report_progress(progress, "search")
    # The design, half a gigabyte of an hour's columns, ends with the search that refines it.
    fit = alternated(
        _design(coarse, candidates, columns), searched_by_name(candidates), fine,
        partial(report_progress, progress, "search"),
    )  # fmt: skip
    return Searched(prepared, candidates, coarse, fit)


def _design(
    blocks: Blocks, candidates: Sequence[Candidate], columns: Sequence[Column]
) -> BandedDesign:
    half = plausible_half_ranges(candidates, len(columns))
    return banded_design(blocks, blocks.readings, columns, half)


def all_fitted(
    design: BandedDesign, candidates: Sequence[Candidate], blocks: Blocks
) -> FittedSelection:
    """Of each name the first term with all its parameters, at the likeliest of the instants that
    are proposed, fitted without a search by the noise that the terms leave: what they explain is
    not noise.
    """
    noises = initial_noises(design)
    design, candidates = with_proposed_shapes(design, candidates, noises)
    whole: dict[tuple[str, int], Candidate] = {}
    for one in candidates:
        whole.setdefault(one.term.key, one)
    gains = {one.candidate.key: one.gain for one in rank(normal_equations(design, noises),
                                                         list(whole.values()), ())}  # fmt: skip
    first: dict[str, Candidate] = {}
    for one in whole.values():
        before = first.setdefault(one.name, one)
        if is_instant(one.term) and gains.get(one.key, 0.0) > gains.get(before.key, 0.0):
            first[one.name] = one
    start = list(first.values())
    for _ in range(NOISE_ROUNDS):
        # A random drift would take flicker for its own.
        noises = noises_beside(design, [one for one in start if one.prior is None], noises)
        fit = FittedSelection.of(search(design, start, start, noises), blocks, design.blocks.rate)
        start = fit.selection.candidates
        design = with_columns(design, *linearised(fit.model, design.blocks, start))
    return fit


def alternated(
    design: BandedDesign,
    candidates: Sequence[Candidate],
    blocks: Blocks,
    done: Callable[[float], None],
) -> FittedSelection:
    """Alternates search and fit: after each fit, the residual is searched again about its values.

    done: is called with the share of searches completed.
    """
    noises = initial_noises(design)
    nuisances = [one for one in candidates if one.nuisance]
    design, candidates = with_proposed_shapes(design, candidates, noises, nuisances)
    selection = search(design, candidates, nuisances, noises)
    fit = FittedSelection.of(selection, blocks, design.blocks.rate)
    for number in range(1, MAX_SEARCHES if selection.selected else 1):
        done(number / MAX_SEARCHES)
        before = fit.selection.candidates
        candidates = _updated(candidates, before)
        design = with_columns(design, *linearised(fit.model, design.blocks, before))
        # Random drifts make up for what the shapes of others lacked: they prove themselves anew.
        firm = [one for one in before if one.prior is None]
        noises = noises_beside(design, firm, fit.selection.noises)
        design, candidates = with_proposed_shapes(design, candidates, noises, firm)
        again = search(design, candidates, firm, noises)
        fit = fit.reselected(replace(again, p_value=selection.p_value))
        if {one.key for one in again.candidates} == {one.key for one in before}:
            break
    rivalled = with_rivals(fit.selection, design, _updated(candidates, fit.selection.candidates))
    return replace(fit, selection=rivalled)


def _at_rate(noises: Sequence[Noise], factor: float) -> tuple[Noise, ...]:
    return tuple(noise.at_rate(factor) for noise in noises)


def _updated(candidates: Sequence[Candidate], fitted: Sequence[Candidate]) -> list[Candidate]:
    """The candidates with the fitted ones in their places, and their parts with the same terms."""
    by_key = {one.key: one for one in fitted}
    terms = {one.term.key: one.term for one in fitted}
    return [
        by_key.get(one.key) or replace(one, term=terms.get(one.term.key, one.term))
        for one in candidates
    ]


# A selection of a tracked body, fitted as the noise of its poses has it.

DERIVATIVES = (2, 4)  # powers of frequency by which noise of poses rises in rates and in forces


def fitted_by_poses(fit: FittedSelection) -> FittedSelection:
    """The same fitted once more where poses tell the motion as it was, each frequency by what
    their derivatives' noise leaves there; as it is where the motion is not from poses.

    What is selected stays: as long as something is missing, it lies where the motion is and would
    be taken for noise that does not rise.
    """
    tracking = fit.blocks.motion.tracking
    if tracking is None:
        return fit
    fit = replace(fit, blocks=replace(fit.blocks, band=well_known(tracking)))
    for _ in range(NOISE_ROUNDS):
        model, blocks = fit.model, fit.blocks
        columns = model.design(blocks.motion).columns
        misfit = blocks.readings - model.prediction(blocks.motion)
        design = banded_design(blocks, misfit, columns, np.ones(len(columns)))
        left = residual_noises(design, range(len(columns)), fit.noises, DERIVATIVES)
        factor = fit.search_rate / blocks.rate
        noises = tuple(noise.at_rate(factor) for noise in left)
        fit = fit.reselected(replace(fit.selection, noises=noises))
    return fit


# Where a kind of behaviour may stand in a form that no publication lists, and what competes there.
#
# Classes are compared: a kind of behaviour, as a random function of its own drive, with the listed
# forms of every name and with empirical terms, less those that the kinds have among their forms.


def with_kinds(
    listed: Sequence[Term], selected: Sequence[Selected], motion: Motion
) -> tuple[Term, ...]:
    """The terms to search with kinds of behaviour; none where none is in question.

    listed: terms of the catalogue. selected: what a search of them and of empirical terms selected.
    Kinds are in question where something has no name, or a form in doubt, or where a kind's name
    does not stand alone: the second may be what the first one's form lacks. But not where a delay
    or a filter is as clear, or in every model: what one differs by from the other follows changes
    of the motion, as memory does.
    """
    kinds = tuple(behaviours(motion))
    names = {kind.name for kind in kinds}
    several = len([one for one in selected if not one.candidate.nuisance]) > 1
    doubtful = [
        one for one in selected
        if _in_doubt(one.candidate) or (several and one.candidate.name in names)
    ]  # fmt: skip
    signal = [one for one in selected if one.candidate.term.stage == "signal"]
    least = max((one.gain for one in signal), default=0.0)
    clear = any(one.gain > least for one in doubtful)
    if not clear or any(one.candidate.nuisance for one in signal):
        return ()
    of_kinds = [kind.form_of for kind in kinds]
    left_out: dict[str, tuple[int, ...]] = {}
    for one in of_kinds:
        for follows in one.empirical:
            left_out[follows] = (*left_out.get(follows, ()), *one.channels)
    forms = {
        one.candidate.term.equation for one in doubtful
        if one.candidate.name in names and _in_doubt(one.candidate)
    }  # fmt: skip
    return (
        *(term for term in listed if term.source != PLAYS and term.equation not in forms),
        *empirical(motion, left_out),
        *kinds,
    )


def _in_doubt(one: Candidate) -> bool:
    """Whether it may be a behaviour in another form: it has no name; it is a sum of plays, which
    any hysteresis is; or its shape is driven to where its own form ends.
    """
    doubtful = one.name == UNNAMED or one.term.source == PLAYS or is_at_bound(one.term)
    return doubtful and not one.nuisance


def is_at_bound(term: Term) -> bool:
    """Whether a continuous shape was driven out of what is plausible: another form fits better."""
    for shape, value in zip(term.shapes, term.at, strict=True):
        low, high = shape.plausible
        searched = shape.unit not in (COUNTS, "deg") and shape.name != "time"
        if searched and (value >= 0.99 * high or value <= 1.01 * low):
            return True
    return False
