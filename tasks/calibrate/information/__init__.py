"""Additional information in the data, beside the results of the clauses; no decision uses it."""

from collections.abc import Mapping

from schemas.calibration import Information, Item
from tasks.calibrate.information.entry import (
    earth_information,
    line_information,
    repeatability_information,
)
from tasks.calibrate.information.lever_arm import lever_arm_information
from tasks.calibrate.information.noise import noise_information
from tasks.specifications.evidence import ClauseEvidence


def information(
    evidence: ClauseEvidence, items: Mapping[str, Item], rate_sensor: str
) -> dict[str, Information]:
    """Everything the recording allows, in the order in which it is printed.

    rate_sensor: `gyro` or `ahrs`, as the results call what senses the rate.
    """
    return {
        **earth_information(evidence.earth, items),
        **lever_arm_information(evidence, items),
        **line_information(evidence, items, rate_sensor),
        **repeatability_information(evidence, rate_sensor),
        **noise_information(evidence, rate_sensor),
    }
