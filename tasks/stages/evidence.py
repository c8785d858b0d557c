"""The evidence file of a result, made again from its recording."""

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.certificate import Laboratory
from schemas.decision import Decision
from schemas.evidence import EvidenceFile
from schemas.orders import ExportOrder
from schemas.recording import Recording
from storage import settings
from storage.catalogue import run_index, runs
from storage.home import Home
from tasks.calibrate.evaluation import evaluation_for
from tasks.calibrate.evidence_file import evidence_file
from tasks.specifications.register import specification_for
from tasks.stages.calibration_input import read_calibration
from tasks.stages.equipment_in_use import limits_in_use, reference_in_use
from tasks.stages.estimate import how_made


def evidence_of(
    calibration: Calibration,
    recording: Recording,
    home: Home,
    laboratory: Laboratory | None,
    decision: Decision | None = None,
) -> EvidenceFile:
    """What a result of a recording rests on; Unusable where it has no evidence file.

    calibration: as it is stated. recording: with its reference as it was in use. laboratory: whose
    limits the result was made with. decision: what was decided on it.
    """
    specification = specification_for(recording.manifest.standard, calibration.method)
    limits = limits_in_use(recording.manifest, home, laboratory)
    evaluation = evaluation_for(recording, own=limits, axes=how_made(calibration).axes)
    return evidence_file(calibration, specification, recording, evaluation, decision)


def as_text(evidence: EvidenceFile) -> str:
    """The text of the file."""
    return evidence.model_dump_json() + "\n"


def export_evidence(order: ExportOrder, home: Home) -> str:
    """The evidence file of a result, without a decision; Unusable where it has none, or where its
    recording is not in the store.
    """
    calibration = read_calibration(order.calibration, home)
    for run in run_index.all_runs(home):
        if run.digest == calibration.digest:
            laboratory = settings.laboratory(home)
            recording = reference_in_use(runs.load(run, home), home, laboratory)
            return as_text(evidence_of(calibration, recording, home, laboratory))
    raise Unusable(
        f"run {calibration.run} of {calibration.recording_id} is not in {home.path}, and its "
        "evidence is made of the recording: import that."
    )
