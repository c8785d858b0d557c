"""What smoothing removes from the motion of a tracked body, and its influence on a fit.

The filter that keeps the noise of poses out of their derivatives takes a little of the motion too,
most of it near the end of the band. What it takes follows the motion, so that no scatter shows it:
parameters that follow the same motion make up for it. How much it takes, the smoothed poses tell
when they are smoothed again.
"""

from dataclasses import replace

import numpy as np

from schemas.recording import Recording
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.other_readings import equations_on
from tasks.explain.inputs.full_rate import FullRate
from tasks.model.regression import inverse
from tasks.motion.pose import motion_smoothed_twice


def with_smoothing_error(
    evidence: Evidence, recording: Recording, full: FullRate, masked: np.ndarray
) -> Evidence:
    """The evidence, with u that covers what smoothing the poses moves its parameters by.

    masked: (n, 6) bool, readings that are not used.
    """
    pose = recording.reference
    if full.motion.tracking is None or pose is None or not evidence.groups:
        return evidence
    again = motion_smoothed_twice(recording, pose, full.motion.t + full.start)
    twice = replace(
        full.motion, up=again.up, north=again.north, rate=again.rate,
        translation=again.translation,
    )  # fmt: skip
    model = evidence.fit.model
    lost = model.prediction(full.motion) - model.prediction(twice)
    normal, right = equations_on(replace(full, readings=lost), masked, evidence)
    moved = inverse(normal + np.diag(evidence.prior)) @ right
    return replace(evidence, smoothing_error=np.abs(moved))
