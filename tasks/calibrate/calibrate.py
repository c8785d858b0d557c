"""The calibration of a recording by a specification."""

from schemas.calibration import Calibration
from schemas.recording import Recording
from tasks.calibrate.build import build
from tasks.calibrate.evaluation import Evaluation, evaluation_for
from tasks.calibrate.information import information
from tasks.segments.check import check_segments
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
    checked = check_segments(
        evidence.recording,
        evidence.segments,
        evidence.turning_points,
        specification.conditions,
        channels=evidence.channel_names,
        may_stand_still=evidence.may_stand_still,
    )
    result = specification.estimate(evidence, evaluation.equipment)
    items = {
        item.key: evaluation.item(item, result.items[item.key]) for item in specification.items
    }
    return build(
        specification,
        evidence,
        items,
        result.unavailable,
        remarks=(*result.remarks, *evaluation.remarks, *checked),
        information=information(evidence, items, specification.rate_sensor),
        settings=evaluation.settings,
        run=run,
        code_version=code_version,
    )
