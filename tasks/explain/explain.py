"""The whole of `explain`: from a recording to the physics that the model left out."""

from collections.abc import Sequence

from schemas.base import Unusable
from schemas.recording import Recording
from tasks.explain.evidence.confounding import compared, with_play, with_preferred
from tasks.explain.evidence.evidence import Evidence, pruned, with_absorbed
from tasks.explain.evidence.findings import explanation_of
from tasks.explain.explanation import Explanation
from tasks.explain.inputs.prepared import Prepared, prepare
from tasks.explain.inputs.reference import ReferencePrediction
from tasks.explain.progress import Progress, report_progress, silent
from tasks.explain.search.fitted import FittedSelection, Searched, fitted_by_poses, searched
from tasks.model.terms.timing import TIME_OFFSET


def explain(
    recording: Recording,
    *,
    reference: ReferencePrediction | None = None,
    only: Sequence[str] | None = None,
    progress: Progress = silent,
) -> Explanation:
    """Where the standard's model and a recording differ, and which physics is missing.

    reference: what a calibration or another simulator predicts, in place of the fitted model.
    only: names of the catalogue that are fitted, and nothing else; without them a search.
    progress: is told each step.
    Raises Unusable where the recording tells no motion or is too short.
    """
    delay_sought = only is None or TIME_OFFSET.name in only
    prepared = prepare(recording, reference, delay_sought=delay_sought, progress=progress)
    return explained(prepared, only=only, progress=progress)


def explained(
    prepared: Prepared,
    *,
    only: Sequence[str] | None = None,
    progress: Progress = silent,
) -> Explanation:
    """The same of a recording that was prepared, with its delay sought where that may be found."""
    found = searched(prepared, only, progress)
    if only is None:
        evidence = _selected(found, progress)
    else:
        evidence = Evidence.of(found.as_stamped(found.fit))
    report_progress(progress, "evidence")
    return explanation_of(prepared, evidence, ordered=only is not None)


def fitted_effects(recording: Recording, only: Sequence[str]) -> FittedSelection:
    """Some effects of the catalogue fitted to a recording with the standard's model.

    Raises Unusable where the recording tells no motion, is too short, or cannot show one of them.
    """
    found = searched(prepare(recording, delay_sought=TIME_OFFSET.name in only), only)
    fit = found.as_stamped(found.fit)
    missing = set(only) - {key[0] for key in fit.model.places}
    if missing:
        raise Unusable(
            f"{recording.manifest.recording_id} does not show {', '.join(sorted(missing))}: "
            "name effects of the catalogue that it may have"
        )
    return fit


def _selected(found: Searched, progress: Progress) -> Evidence:
    """The evidence of what stands of a search, with what fits as well compared."""
    candidates, trials = found.candidates, len(found.candidates)
    evidence = with_absorbed(pruned(found.fit, trials), candidates, found.blocks)
    if found.prepared.delay:
        evidence = pruned(found.as_stamped(evidence.fit), trials)
    report_progress(progress, "combinations")
    fit = compared(evidence.fit, candidates, lambda fit, kept: pruned(fit, trials, kept).fit)
    fit = with_play(with_preferred(fit, candidates), candidates)
    fit = found.resolved(fit)
    if fit is not evidence.fit:
        evidence = pruned(fit, trials)
    by_poses = fitted_by_poses(evidence.fit)
    return evidence if by_poses is evidence.fit else pruned(by_poses, trials)
