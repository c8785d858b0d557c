"""The calibration of a recording by a specification."""

from schemas.calibration import Calibration
from schemas.recording import Recording
from tasks.calibrate.build import build
from tasks.calibrate.evaluation import Evaluation, evaluation_for
from tasks.specifications.specification import Specification


def calibrate(
    specification: Specification,
    recording: Recording,
    *,
    run: str,
    code_version: str,
    evaluation: Evaluation | None = None,
) -> Calibration:
    """Every item of the specification that the recording determines, with what must be known.

    evaluation: of the uncertainties; by the law of propagation with the limits of the recording's
    specification where it is not given.
    Raises Unusable for a recording that the specification's method cannot serve.
    """
    specification.check(recording)
    evaluation = evaluation or evaluation_for(recording)
    evidence = specification.gather(recording)
    result = specification.estimate(evidence, evaluation.equipment)
    items = {
        item.key: evaluation.item(item, result.items[item.key]) for item in specification.items
    }
    return build(
        specification, evidence, result, items, evaluation, run=run, code_version=code_version
    )
