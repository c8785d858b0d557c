"""The unit's supply: recorded over the whole run, and steady."""

from collections.abc import Iterator

import numpy as np

from schemas.text import Remark
from tasks.run_validity.covered import not_covered, readings, within
from tasks.run_validity.remark import run_remark
from tasks.specifications.evidence import ClauseEvidence

STEADY = 0.05  # of the usual voltage, in either direction
LEVEL = (1.0, 60.0)  # V: nothing else supplies an inertial unit


def supply_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """A supply that is unknown, fell, rose, or is implausible."""
    t, values = readings(evidence.recording.environment, "supply_voltage")
    bare = not_covered(t, evidence.segments)
    if bare:
        yield run_remark("supply_not_recorded", *bare, count=len(bare), of=len(evidence.segments))
    volts = within(t, values, evidence.segments)
    if not len(volts):
        return
    low, usual, high = float(volts.min()), float(np.median(volts)), float(volts.max())
    if not LEVEL[0] <= usual <= LEVEL[1]:
        yield run_remark(
            "supply_level", run="invalid", level=f"{usual:.2f}", low=f"{LEVEL[0]:g}",
            high=f"{LEVEL[1]:g}",
        )  # fmt: skip
    elif max(high - usual, usual - low) > STEADY * usual:
        yield run_remark(
            "supply_changed", run="invalid", low=f"{low:.2f}", high=f"{high:.2f}",
            usual=f"{usual:.2f}", percent=f"{100 * STEADY:g}",
        )  # fmt: skip
