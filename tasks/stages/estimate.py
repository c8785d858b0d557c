"""Stage: estimates every item that a run allows, and stores the result."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import get_args

from schemas.base import Unusable
from schemas.calibration import Calibration, UncertaintyKind
from schemas.certificate import Laboratory
from schemas.equipment import ResultAxes
from schemas.orders import Estimation, UncertaintyName
from schemas.recording import Recording
from storage import settings
from storage.catalogue import results, runs
from storage.catalogue.run_index import Run
from storage.home import Home
from tasks.calibrate.calibrate import calibrate
from tasks.calibrate.evaluation import evaluation_for
from tasks.model.catalogue import catalogue
from tasks.motion.angle_rates import gives_angles
from tasks.readings.codes import codes_put_right
from tasks.specifications.register import specification_for
from tasks.stages.equipment_in_use import limits_in_use, reference_in_use
from tasks.stages.stage import stage
from tasks.version import code_version
from tasks.words import say

UNCERTAINTIES: dict[UncertaintyName, UncertaintyKind] = {
    "gum": "GUM",
    "montecarlo": "Monte Carlo",
    "example": "as the specification's example",
}


@stage("estimate")
def estimate(
    run: Run, home: Home, how: Estimation | None = None, laboratory: Laboratory | None = None
) -> Calibration:
    """Calibrate a run and store the result; the same result twice is stored once.

    laboratory: that of the home, unless given. Its limits, and those of the standards in use, take
    precedence over Table 1 of the specification, errors that the standards state are taken off the
    reference, and its latitude is checked. With terms, the
    readings are corrected for their contributions first; that result stands beside the one without
    them and supersedes only one with the same terms. Raises Unusable for a term that this recording
    cannot have or does not determine.
    """
    laboratory = laboratory or settings.laboratory(home)
    calibration = calibration_of(run, home, how or Estimation(), laboratory)
    results.save(calibration, home)
    return calibration


def calibration_of(
    run: Run, home: Home, how: Estimation, laboratory: Laboratory | None
) -> Calibration:
    """The calibration of a run, which is not kept; see `estimate`."""
    recording = reference_in_use(runs.load(run, home), home, laboratory)
    specification = specification_for(recording.manifest.standard, how.method)
    limits = limits_in_use(recording.manifest, home, laboratory)
    calibrated = partial(
        calibrate,
        specification,
        run=run.id,
        code_version=code_version(),
        evaluation=evaluation_for(recording, UNCERTAINTIES[how.uncertainty], limits, how.axes),
        own_latitude_deg=laboratory.latitude_deg if laboratory else None,
    )
    if how.terms is None:
        return calibrated(recording)
    return _with_terms(codes_put_right(recording), how.terms, calibrated)


def how_made(calibration: Calibration) -> Estimation:
    """How a result was estimated: its method, its way to the uncertainties, its terms, its axes."""
    kind = calibration.settings.get("uncertainty")
    stated = calibration.settings.get("axes")
    names = [name for name, each in UNCERTAINTIES.items() if each == kind]
    return Estimation(
        method=calibration.method,
        uncertainty=names[0] if names else "gum",
        terms=tuple(term.name for term in calibration.terms) or None,
        axes=next((axes for axes in get_args(ResultAxes) if axes == stated), None),
    )


def _with_terms(
    recording: Recording, names: Sequence[str], calibrate: Callable[[Recording], Calibration]
) -> Calibration:
    """The calibration of a recording whose readings were corrected for the named terms."""
    # Late: a calibration without terms needs none of it.
    from tasks.explain.correction.adopt import adopt
    from tasks.explain.explain import explain
    from tasks.explain.inputs.full_rate import full_rate
    from tasks.explain.report.unnamed import refused

    recording_id = recording.manifest.recording_id
    if gives_angles(recording):
        raise Unusable(
            f"--terms {', '.join(names)}: {recording_id} has angle_* and no gyro_*, and terms are "
            "taken off rates alone; calibrate it without --terms"
        )
    known = {term.name for term in catalogue(recording, full_rate(recording).motion)}
    unknown = [name for name in names if name not in known]
    if unknown or not names:
        raise Unusable(
            f"--terms {', '.join(unknown) or repr('')}: {recording_id} can have "
            f"{', '.join(sorted(known))}; name some of these with commas between"
        )
    # What explain found is taken off as it found it; else what is asked for is fitted.
    explanation = explain(recording)
    findings = explanation.by_name
    if not findings.keys() >= set(names):
        explanation = explain(recording, only=names)
        findings = explanation.by_name
    for name in names:
        if name not in findings:
            raise Unusable(f"--terms {name}: {recording_id} does not determine it; leave it out")
        if refusal := findings[name].refusal:
            why = say(refused(refusal, setting=False))
            raise Unusable(f"--terms {name}: {recording_id}: {why} Leave it out")
    found = [findings[name] for name in names]  # two names may be one finding
    taken = [one for k, one in enumerate(found) if all(one is not each for each in found[:k])]
    return adopt(recording, taken, calibrate, explanation.determined)
