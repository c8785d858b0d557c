"""Whether positions known from labels alone leave anything for a law of attitude to explain.

Where neither encoders nor poses tell it, each rest is as it was placed, and that is off by what it
is. A law of the attitude with as many parameters as the rests leave values beside the standard's
would make up for any errors of placing.
"""

import numpy as np

from tasks.explain.evidence.evidence import Evidence
from tasks.explain.explanation import Refusal

STANDARD_AT_REST = 12  # accelerometers' matrix and bias
AXES = 3
SLOW = np.radians(0.1)  # rad/s


def made_by_placing(evidence: Evidence, number: int) -> Refusal | None:
    """Where a finding that turns the body has no fewer parameters than the rests leave values."""
    group, motion = evidence.groups[number], evidence.fit.blocks.motion
    if motion.axes is not None or motion.tracking is not None:
        return None
    if not any(term.stage == "motion" for term in group.terms):
        return None
    placed = _placements(evidence)
    if AXES * placed - STANDARD_AT_REST > len(evidence.own[number][0]):
        return None
    return Refusal("placed", group.name, value=float(placed))


def _placements(evidence: Evidence) -> int:
    """Rests that were each positioned separately."""
    blocks = evidence.fit.blocks
    rests = np.linalg.norm(np.nan_to_num(blocks.motion.rate, nan=np.inf), axis=1) < SLOW
    return len(np.unique(blocks.segment[rests & (blocks.segment >= 0)]))
