"""The whole of `explain`: from a recording to the physics that the model left out."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.special import comb

from schemas.base import Unusable
from schemas.recording import Recording
from tasks.explain.confounding.compare import compared
from tasks.explain.confounding.families import searched_by_name
from tasks.explain.confounding.play import with_play
from tasks.explain.events.faults import Fault, find_faults
from tasks.explain.evidence.absorption import with_absorbed
from tasks.explain.evidence.assemble import explanation_of
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.fault_findings import put_right, with_faults
from tasks.explain.evidence.pruning import pruned
from tasks.explain.explanation import Explanation
from tasks.explain.inputs.angle_rates import as_mean_rates
from tasks.explain.inputs.blocks import Blocks
from tasks.explain.inputs.event_removal import Cleaned, cleaned
from tasks.explain.inputs.full_rate import FullRate, full_rate
from tasks.explain.inputs.reference import ReferencePrediction
from tasks.explain.progress import Progress, silent, tell
from tasks.explain.search.candidates import (
    Candidate,
    candidates_of,
    plausible_half_ranges,
    with_nuisances,
)
from tasks.explain.search.design import banded_design
from tasks.explain.search.empirical import empirical
from tasks.explain.search.fitted import FittedSelection, all_fitted, searched, with_delay
from tasks.explain.search.time_budget import SEARCH_BUDGET, TimeBudget
from tasks.model.catalogue import catalogue
from tasks.model.term import Term
from tasks.model.terms.reference_frame import REFERENCE_FRAME
from tasks.model.terms.timing import TIME_OFFSET
from tasks.motion.whole import Motion
from tasks.words import message

OF_TRACKING = (TIME_OFFSET.name, REFERENCE_FRAME.name)  # nuisances of poses
SEARCH_RATE, REFIT_RATE = 25.0, 50.0  # Hz
LONG = 1600.0  # s: blocks of a longer run are as much longer, so that it costs no more
ABRUPT = 0.005  # of the rates' variance that lies near half the blocks' rate: they alias


def explain(
    recording: Recording,
    *,
    reference: ReferencePrediction | None = None,
    only: Sequence[str] | None = None,
    progress: Progress = silent,
    budget: float = SEARCH_BUDGET,
) -> Explanation:
    """Where the standard's model and a recording differ, and which physics is missing.

    reference: what a calibration or another simulator predicts, in place of the fitted model.
    only: names of the catalogue that are fitted, and nothing else; without them a search.
    progress: is told each step. budget: s of processor time that the search may take.
    Raises Unusable where the recording tells no motion or is too short.
    """
    tell(progress, "motion")
    recording = as_mean_rates(recording)
    faults, right, full = without_faults(recording, reference)
    tell(progress, "events")
    clean = cleaned(right, full, only is None or TIME_OFFSET.name in only).less(reference, full)
    full = clean.as_stamped(full)
    tell(progress, "candidates")
    evidence = _evidence(right, full, clean, only, progress, budget)
    tell(progress, "evidence")
    ordered = only is not None
    explanation = explanation_of(right, full, clean.events, evidence, reference, ordered)
    if evidence.fit.selection.stopped:
        stopped = message("explain-search-stopped", seconds=f"{budget:g}")
        explanation = replace(explanation, remarks=(*explanation.remarks, stopped))
    return with_faults(explanation, recording, faults)


def fitted_effects(recording: Recording, only: Sequence[str]) -> FittedSelection:
    """Some effects of the catalogue fitted to a recording with the standard's model.

    Raises Unusable where the recording tells no motion, is too short, or cannot show one of them.
    """
    recording = as_mean_rates(recording)
    _, right, full = without_faults(recording)
    clean = cleaned(right, full, TIME_OFFSET.name in only)
    full = clean.as_stamped(full)
    fit = _evidence(right, full, clean, only, silent, SEARCH_BUDGET).fit
    missing = set(only) - {key[0] for key in fit.model.places}
    if missing:
        raise Unusable(
            f"{recording.manifest.recording_id} does not show {', '.join(sorted(missing))}: "
            "name effects of the catalogue that it may have"
        )
    return fit


def without_faults(
    recording: Recording, reference: ReferencePrediction | None = None
) -> tuple[tuple[Fault, ...], Recording, FullRate]:
    """Faults of the logger, and the recording without them, as it is and at the unit's rate."""
    full = full_rate(recording)
    tracked = recording.table is None and recording.reference is not None
    faults = find_faults(full.readings, full.motion, None if reference else tracked)
    right = put_right(recording, faults)
    return faults, right, full_rate(right) if faults else full


def _evidence(
    recording: Recording,
    full: FullRate,
    clean: Cleaned,
    only: Sequence[str] | None,
    progress: Progress,
    budget: float,
) -> Evidence:
    """The evidence of what was asked for; else of what a search selects and what stays of it."""
    share = min(1.0, LONG / float(full.motion.t[-1]))
    coarse, fine = clean.blocks(share * SEARCH_RATE), clean.blocks(share * REFIT_RATE)
    terms = _terms(recording, coarse.motion, only)
    candidates, fit = _fitted(terms, coarse, fine, only is None, progress, budget)

    def as_recorded(fit: FittedSelection) -> FittedSelection:
        late = clean.with_stamps_of(full).blocks(share * REFIT_RATE)
        return with_delay(fit, candidates, clean.delay, late)

    if only is not None:
        return Evidence.of(as_recorded(fit) if clean.delay else fit)
    evidence = with_absorbed(pruned(fit, len(candidates)), candidates, coarse)
    if clean.delay:
        evidence = pruned(as_recorded(evidence.fit), len(candidates))
    tell(progress, "combinations")
    trials = len(candidates)
    fit = compared(evidence.fit, candidates, lambda fit, kept: pruned(fit, trials, kept).fit)
    fit = with_play(fit, candidates)
    if len(fine.t) <= LONG * REFIT_RATE / 2 and _abrupt(fit.blocks):
        stamped = clean.with_stamps_of(full) if clean.delay else clean
        fit = replace(fit, blocks=stamped.blocks(2.0 * fine.rate)).reselected(fit.selection)
    return evidence if fit is evidence.fit else pruned(fit, trials)


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


def _fitted(
    terms: Sequence[Term],
    coarse: Blocks,
    fine: Blocks,
    searching: bool,
    progress: Progress,
    budget: float,
) -> tuple[tuple[Candidate, ...], FittedSelection]:
    """The candidates of some terms; and a fit of those that a search selects, else of all.

    The design, half a gigabyte of an hour's columns, ends with the search that refines it.
    """
    candidates, columns = candidates_of(terms, coarse.motion)
    if coarse.motion.tracking is not None and searching:
        candidates = tuple(with_nuisances(candidates, OF_TRACKING))
    half = plausible_half_ranges(candidates, len(columns))
    tell(progress, "search")
    if not searching:
        design = banded_design(coarse, coarse.readings, columns, half)
        return candidates, all_fitted(design, candidates, fine)
    fit = searched(
        banded_design(coarse, coarse.readings, columns, half),
        searched_by_name(candidates), fine, TimeBudget.of(budget),
        partial(tell, progress, "search"),
    )  # fmt: skip
    return candidates, fit


def _terms(recording: Recording, motion: Motion, only: Sequence[str] | None) -> list[Term]:
    listed = catalogue(recording, motion)
    if only is not None:
        return [term for term in listed if term.name in only]
    return [*listed, *empirical(motion)]
