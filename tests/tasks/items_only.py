"""The items of a recording by a specification, for tests that ask for nothing else of it."""

from schemas.calibration import Calibration
from schemas.recording import Recording
from tasks.calibrate.calibrate import Evaluation, evaluation_for, without_information
from tasks.specifications.estimate import Specification


def items_only(
    specification: Specification,
    recording: Recording,
    evaluation: Evaluation | None = None,
    run: str = "r",
    code_version: str = "v",
) -> Calibration:
    """As `calibrate`, without what else the recording tells, which takes as long again."""
    specification.check(recording)
    return without_information(
        specification, specification.gather(recording), evaluation or evaluation_for(recording),
        run=run, code_version=code_version,
    )  # fmt: skip
