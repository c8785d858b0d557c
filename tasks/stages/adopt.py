"""Stage: a run is calibrated again with physics that `explain` found taken off its readings."""

from collections.abc import Sequence

from schemas.base import Unusable
from schemas.calibration import Calibration, Method
from schemas.certificate import Laboratory
from schemas.recording import Recording
from storage import settings
from storage.catalogue import results, runs
from storage.catalogue.runs import Run
from storage.home import Home
from tasks.specifications.evaluation import evaluation_for
from tasks.stages.estimate import BY_STANDARD, METHODS, check_method
from tasks.version import code_version


def adopt_terms(
    run: Run,
    home: Home,
    terms: str,
    method: Method | None = None,
    uncertainty: str = "gum",
    laboratory: Laboratory | None = None,
) -> Calibration:
    """Calibrate a run beside its other results, with the terms' contributions taken off first.

    terms: catalogue names with commas between. The result stands beside the one without them and
    supersedes only one with the same terms.
    Raises Unusable for a name that this recording cannot have, for one that explain cannot
    estimate, and for a method or an evaluation of uncertainty that has its own way with them.
    """
    # Late: a calibration without terms needs none of it.
    from tasks.explain.correction.adopt import adopt
    from tasks.explain.explain import explain
    from tasks.explain.inputs.observed import full_rate
    from tasks.model.catalogue import catalogue

    _check(method, uncertainty)
    recording = runs.load(run, home)
    chosen = method or BY_STANDARD.get(recording.manifest.standard, "jjf2003")
    motion = full_rate(recording).motion
    known = catalogue(recording, motion)
    names = _names(terms, [term.name for term in known], recording)
    explanation = explain(recording, only=names)
    found = {finding.effect: finding for finding in explanation.findings}
    for name in names:
        if name not in found:
            raise Unusable(
                f"--terms {name}: {recording.manifest.recording_id} does not determine it; leave "
                "it out"
            )
    laboratory = laboratory or settings.laboratory(home)
    evaluation = evaluation_for(recording, "GUM", laboratory.limits if laboratory else None)

    def calibrate(read: Recording) -> Calibration:
        return METHODS[chosen](read, run=run.id, code_version=code_version(), evaluation=evaluation)

    calibration = adopt(recording, [found[name] for name in names], calibrate, known, motion)
    results.save(calibration, home)
    return calibration


def _check(method: str | None, uncertainty: str) -> None:
    check_method(method)
    if method == "joint":
        raise Unusable(
            "--terms goes with the clauses of the specification; the joint method has Earth's "
            "rotation in its own model: leave --method joint or --terms out"
        )
    if uncertainty != "gum":
        raise Unusable(
            f"--terms carries the uncertainty of the terms by the law of propagation; leave "
            f"--uncertainty {uncertainty} out"
        )


def _names(terms: str, known: Sequence[str], recording: Recording) -> tuple[str, ...]:
    """The names of an order, each once, in the order of the catalogue's spelling."""
    asked = tuple(sorted({name.strip() for name in terms.split(",")} - {""}))
    unknown = [name for name in asked if name not in known]
    if unknown or not asked:
        raise Unusable(
            f"--terms {', '.join(unknown) or terms!r}: {recording.manifest.recording_id} can have "
            f"{', '.join(sorted(set(known)))}; name some of these with commas between"
        )
    return asked
