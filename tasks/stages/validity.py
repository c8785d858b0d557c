"""Whether a run can be relied on, before anything is said of its unit."""

from schemas.base import Unusable
from schemas.calibration import OF_NO_STANDARD, OF_STANDARD
from schemas.text import Validity, texts_fields
from storage import settings
from storage.catalogue import results, runs
from storage.catalogue.run_index import Run
from storage.home import Home
from tasks.calibrate.calibrate import calibrate
from tasks.calibrate.evaluation import evaluation_for
from tasks.specifications.register import SPECIFICATIONS
from tasks.stages.equipment_in_use import limits_in_use, reference_in_use
from tasks.version import code_version
from tasks.words import statement


def validity_of(run: Run, home: Home) -> Validity:
    """The verdict on a run by the method of its specification; that of its result, if it has one
    of the readings as recorded.

    A run that the method cannot serve at all is valid with that remark: it was not judged.
    """
    method = OF_STANDARD.get(run.standard, OF_NO_STANDARD)
    for kept in reversed(results.of_run(run, home)):
        made = kept.calibration
        if (made.method, made.code_version) == (method, code_version()) and not made.terms:
            return made.validity
    # Late: a run with a result needs none of it.
    recording = runs.load(run, home)
    laboratory = settings.laboratory(home)
    try:
        own = limits_in_use(recording.manifest, home, laboratory)
        recording = reference_in_use(recording, home, laboratory)
        evaluation = evaluation_for(recording, own=own)
        calibration = calibrate(
            SPECIFICATIONS[method], recording, run=run.id, code_version="", evaluation=evaluation,
            own_latitude_deg=laboratory.latitude_deg if laboratory else None,
        )  # fmt: skip
    except Unusable as fault:
        return Validity(verdict="remarks", **texts_fields("reasons", (statement(str(fault)),)))
    return calibration.validity
