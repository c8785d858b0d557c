"""The whole of `explain`: from a recording to the physics that the model left out."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from schemas.recording import Recording
from tasks.explain.evidence.absorption import soaked_up
from tasks.explain.evidence.assemble import assembled
from tasks.explain.evidence.weigh import Weighed, groups_of
from tasks.explain.explanation import Explanation
from tasks.explain.inputs.event_removal import without_happenings
from tasks.explain.inputs.observed import (
    SEARCH_RATE,
    Observed,
    full_rate,
    in_blocks,
)
from tasks.explain.inputs.reference import Told
from tasks.explain.regression.spectrum import Noise
from tasks.explain.search.candidates import Candidate, candidates_of, columns_of, plausible_sizes
from tasks.explain.search.empirical import empirical
from tasks.explain.search.pool import Pool, pooled, renewed, residuals
from tasks.explain.search.proposals import proposed
from tasks.explain.search.rank import members_of, precision_of
from tasks.explain.search.refit import Model, delayed, fitted, linearised, model_of, started
from tasks.explain.search.stepwise import Chosen, Found, beside, first_noises, search
from tasks.model.catalogue import catalogue
from tasks.model.term import Term
from tasks.model.terms.timing import TIME_OFFSET

REFIT_RATE = 50.0  # Hz
LOOKS = 3  # at most: searches, each after a fit of all that was found in its real form

Progress = Callable[[str], None]


def explain(
    recording: Recording,
    *,
    told: Told | None = None,
    only: Sequence[str] | None = None,
    progress: Progress = lambda said: None,
) -> Explanation:
    """Where the standard's model and a recording differ, and which physics is missing.

    told: what a calibration or another simulator predicts, in place of the fitted model. only:
    names of the catalogue that are fitted, and nothing else; without them a search.
    Raises Unusable where the recording tells no motion or is too short.
    """
    progress("motion")
    full = full_rate(recording)
    progress("events")
    offset_asked = only is None or TIME_OFFSET.name in only
    late, events, freed, masked = without_happenings(recording, full, offset_asked)
    if told is not None:
        freed = replace(freed, readings=freed.readings - told.beyond_ideal(full.motion))
    coarse = in_blocks(freed, SEARCH_RATE, masked)
    fine = in_blocks(freed, REFIT_RATE, masked)
    progress("candidates")
    terms = _terms(recording, coarse, only)
    listed, columns = candidates_of(terms, coarse.motion)
    candidates = list(listed)
    half = plausible_sizes(candidates, len(columns))
    pool = pooled(coarse, coarse.readings, columns, half)
    progress("search")
    if only is None:
        noises = first_noises(pool)
        pool, candidates = proposed(pool, candidates, residuals(pool, (), noises), noises)
        found = search(pool, candidates, (), noises)
        found, model = _looked_again(pool, candidates, found, fine)
        found, model = _needed(found, model, fine, coarse, len(candidates))
        found, model = _soaked_up(pool, candidates, found, model, fine)
    else:
        chosen = _whole_ones(candidates)
        found = search(pool, chosen, chosen)
        model = fitted(_model(found, fine), fine, _at_rate(found.noises, fine, coarse))
        found = _with_shapes(found, model)
    if late:
        noises = _at_rate(found.noises, fine, coarse)
        found, model = _late_again(found, model, candidates, late, fine, noises)
        fine = in_blocks(replace(freed, motion=full.motion), REFIT_RATE, masked)
        found, model = _needed(found, model, fine, coarse, len(candidates))
    progress("evidence")
    noises = _at_rate(found.noises, fine, coarse)
    return assembled(recording, full, fine, events, found, model, noises, told)


def _terms(recording: Recording, observed: Observed, only: Sequence[str] | None) -> list[Term]:
    listed = catalogue(recording, observed.motion)
    if only is not None:
        return [term for term in listed if term.name in only]
    return [*listed, *empirical(observed.motion)]


def _looked_again(
    pool: Pool, candidates: list[Candidate], found: Found, fine: Observed
) -> tuple[Found, Model]:
    """Everything found is fitted in its real form, and what is then left is searched again."""
    noises = _at_rate(found.noises, fine, pool.observed)
    model = fitted(_model(found, fine), fine, noises)
    for _ in range(LOOKS - 1 if found.chosen else 0):
        shaped = _as_fitted([one.candidate for one in found.chosen], model)
        candidates = _updated(candidates, shaped)
        columns, readings = linearised(model, pool.observed, shaped)
        pool = renewed(pool, columns, readings)
        # Random courses make up for what the shapes of others lacked: they prove themselves anew.
        firm = [one for one in shaped if one.prior is None]
        noises = beside(pool, firm, found.noises)
        left = residuals(pool, members_of(firm), noises)
        pool, candidates = proposed(pool, candidates, left, noises, firm)
        again = search(pool, candidates, firm, noises)
        found = replace(again, p_value=found.p_value)
        same = {one.candidate.key for one in found.chosen} == {one.key for one in shaped}
        noises = _at_rate(found.noises, fine, pool.observed)
        model = fitted(started(_model(found, fine), model), fine, noises)
        if same:
            break
    return _with_shapes(found, model), model


def _late_again(
    found: Found,
    model: Model,
    candidates: Sequence[Candidate],
    late: float,
    fine: Observed,
    noises: Sequence[Noise],
) -> tuple[Found, Model]:
    """What was found with the stamps taken back, for the stamps as they are."""
    names = [one.candidate.name for one in found.chosen]
    if TIME_OFFSET.name not in names:
        offset = next(one for one in candidates if one.name == TIME_OFFSET.name)
        found = replace(found, chosen=(Chosen(offset, 0.0, 0.0, ()), *found.chosen))
        model = fitted(started(_model(found, fine), model), fine, noises)
        found = _with_shapes(found, model)
    # What fits the little that was left as well does not fit the whole, which is nobody's remnant.
    chosen = (
        replace(one, gain=np.inf, rivals=()) if one.candidate.name == TIME_OFFSET.name else one
        for one in found.chosen
    )
    return replace(found, chosen=tuple(chosen)), delayed(model, late)


def _needed(
    found: Found, model: Model, fine: Observed, coarse: Observed, tried: int
) -> tuple[Found, Model]:
    """Without the findings that the real form of the others has made needless."""
    noises = _at_rate(found.noises, fine, coarse)
    while found.chosen:
        groups = groups_of(found)
        weighed = Weighed.of(model, fine, noises, groups)
        weak = [
            (weighed.gain(n), group)
            for n, group in enumerate(groups)
            if weighed.needless(n, group, tried)
        ]
        if not weak:
            break
        least = min(weak, key=lambda pair: pair[0])[1]
        dropped = {one.candidate.key for one in least.chosen}
        kept = tuple(one for one in found.chosen if one.candidate.key not in dropped)
        found = replace(found, chosen=kept)
        model = fitted(started(_model(found, fine), model), fine, noises)
        found = _with_shapes(found, model)
    return found, model


def _soaked_up(
    pool: Pool, candidates: Sequence[Candidate], found: Found, model: Model, fine: Observed
) -> tuple[Found, Model]:
    """What was found, and the known physics that the standard's parameters soak up whole."""
    coarse, names = pool.observed, {one.candidate.name for one in found.chosen}
    for known in (one for one in candidates if one.known and one.name not in names):
        (effect,) = columns_of(known.term, coarse.motion)
        chosen = soaked_up(known, effect, coarse, found.noises)
        if chosen is not None:
            found = replace(found, chosen=(*found.chosen, chosen))
            model = fitted(
                started(_model(found, fine), model), fine, _at_rate(found.noises, fine, coarse)
            )
            found = _with_shapes(found, model)
    return found, model


def _model(found: Found, fine: Observed) -> Model:
    pairs = [(one.candidate, _prior(found, one.candidate)) for one in found.chosen]
    return model_of(pairs, fine)


def _prior(found: Found, candidate: Candidate) -> np.ndarray:
    """Prior precision (m,) of a candidate's parameters, in their own units."""
    members = list(candidate.members)
    if candidate.prior is None:
        return np.zeros(len(candidate.own))
    scale = found.state.scale[members]
    precision = precision_of(found.state, [candidate], members)
    return np.divide(precision, scale**2, out=np.full(len(members), 1e30), where=scale > 0)


def _as_fitted(candidates: Sequence[Candidate], model: Model) -> list[Candidate]:
    """The candidates with the shapes that the fit gave their terms, in the same order."""
    terms = {term.key: term for term in model.terms}
    return [replace(one, term=terms[one.term.key], fitted=True) for one in candidates]


def _whole_ones(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Of each name the first term with all its parameters."""
    first: dict[str, Candidate] = {}
    for one in candidates:
        first.setdefault(one.name, one)
    return list(first.values())


def _with_shapes(found: Found, model: Model) -> Found:
    """What was found with the terms as the model has them."""
    shaped = _as_fitted([one.candidate for one in found.chosen], model)
    pairs = zip(found.chosen, shaped, strict=True)
    return replace(found, chosen=tuple(replace(one, candidate=new) for one, new in pairs))


def _updated(candidates: Sequence[Candidate], fitted: Sequence[Candidate]) -> list[Candidate]:
    """The candidates with the fitted ones in their places, and their parts with the same terms."""
    by_key = {one.key: one for one in fitted}
    terms = {one.term.key: one.term for one in fitted}
    return [
        by_key.get(one.key) or replace(one, term=terms.get(one.term.key, one.term))
        for one in candidates
    ]


def _at_rate(noises: Sequence[Noise], observed: Observed, searched: Observed) -> tuple[Noise, ...]:
    """The same spectrum for blocks of another rate."""
    factor = observed.rate / searched.rate
    return tuple(Noise(noise.white * factor, noise.flicker * factor) for noise in noises)
