"""Vibration of the unit during rests."""

from collections.abc import Iterator

import numpy as np

from schemas.recording import AXES
from schemas.text import Remark
from tasks.run_validity.remark import run_remark
from tasks.segments.summarise import CHANNELS
from tasks.specifications.evidence import ClauseEvidence

# Standard deviation of the rows of a rest: noise of no unit that is worth a calibration.
LARGEST = np.array([np.radians(1.0)] * len(AXES) + [0.5] * len(AXES))  # rad/s, m/s²
ABOVE_OTHERS = 5.0  # times that of the run's usual rest
STEPS = 2.0  # of the output: what rounding makes of a quiet rest


def vibration_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Rests that scatter more than any unit's noise, or much more than the others."""
    rests = [evidence.segments[i] for i in evidence.of_kind("static")]
    if not rests:
        return
    deviation = np.array([rest.deviation for rest in rests])
    usual = np.median(deviation, axis=0)
    step = np.max([rest.step for rest in rests], axis=0)
    limit = np.minimum(LARGEST, np.maximum(ABOVE_OTHERS * usual, STEPS * step))
    above = deviation > limit
    for channel in np.flatnonzero(above.any(axis=0)).tolist():
        shaken = [rests[i].segment.name for i in np.flatnonzero(above[:, channel])]
        yield run_remark(
            "vibration", *shaken, run="invalid", channel=CHANNELS[channel], count=len(shaken),
            first=shaken[0], deviation=f"{deviation[:, channel].max():.3g}",
            limit=f"{limit[channel]:.3g}",
        )  # fmt: skip
