"""The unit's temperature: recorded over the whole run, near the air's, and steady."""

from collections.abc import Iterator

import numpy as np

from schemas.text import Remark
from tasks.run_validity.covered import not_covered, readings, within
from tasks.run_validity.remark import run_remark
from tasks.specifications.evidence import ClauseEvidence

COOLER, WARMER = 10.0, 40.0  # K from the air: a unit heats itself, and nothing cools it
LARGEST_CHANGE = 15.0  # K while it is measured: what warming up leaves


def unit_temperature_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """A temperature of the unit that is not known, far from the air's, or changed."""
    recording, segments = evidence.recording, evidence.segments
    t, values = readings(recording.imu, "temperature")
    bare = not_covered(t, segments)
    if bare:
        yield run_remark(
            "unit_temperature_not_recorded", *bare, count=len(bare), of=len(segments),
        )  # fmt: skip
    seen = [np.median(part) for s in segments if len(part := within(t, values, (s,)))]
    if not seen:
        return
    low, high = float(min(seen)), float(max(seen))
    if high - low > LARGEST_CHANGE:
        yield run_remark(
            "unit_temperature_changed", run="invalid", low=f"{low:.1f}", high=f"{high:.1f}",
            limit=f"{LARGEST_CHANGE:g}",
        )  # fmt: skip
    air = within(*readings(recording.environment, "temperature"), segments)
    if not len(air):
        return
    around = float(np.median(air))
    if not around - COOLER <= float(np.median(seen)) <= around + WARMER:
        yield run_remark(
            "unit_temperature_level", run="invalid", level=f"{np.median(seen):.1f}",
            air=f"{around:.1f}", cooler=f"{COOLER:g}", warmer=f"{WARMER:g}",
        )  # fmt: skip
