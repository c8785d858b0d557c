"""What the data show beside the clauses' results. Nothing is decided on it."""

from collections.abc import Mapping

from schemas.calibration import Information, Item
from schemas.recording import Recording
from tasks.specifications.evidence import Evidence
from tasks.specifications.information.earth import earth_information
from tasks.specifications.information.lever_arm import lever_arm_information
from tasks.specifications.information.line import line_information
from tasks.specifications.information.noise import noise_information
from tasks.specifications.information.repeatability import repeatability_information


def information(
    recording: Recording, evidence: Evidence, items: Mapping[str, Item]
) -> dict[str, Information]:
    """Everything the recording allows, in the order in which it is printed."""
    ahrs = "ahrs_scale_factor" in items
    scale = "ahrs_scale_factor" if ahrs else "gyro_scale_factor"
    gravity = recording.manifest.station.gravity_m_s2
    return {
        **earth_information(recording, evidence, items),
        **lever_arm_information(recording, evidence),
        **line_information(evidence, item=scale),
        **repeatability_information(evidence, gravity, ahrs=ahrs),
        **noise_information(recording, evidence, ahrs=ahrs),
    }
