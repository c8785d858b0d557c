"""Mixed-up units of a recording, revealed by what its segments state."""

import numpy as np

from schemas.recording import AXES
from tasks.segments.summarise import GYRO_COLUMNS, SegmentMean


def wrong_rate_unit(
    segments: tuple[SegmentMean, ...], columns: str = "gyro columns", unit: str = "rad/s"
) -> str | None:
    """What is wrong with the unit of the rates, as a sentence, or None.

    If in most rate segments the gyro reads 57.3 times more or less than the label, either the
    labels are not in °/s or the columns are not in their unit: nothing may be computed.
    columns, unit: what the rates come from.
    """
    ratios = []
    for segment in segments:
        label = segment.segment
        if label.kind == "rate" and label.axis and label.rate_deg_s and segment.has_gyro:
            read = np.degrees(segment.mean[GYRO_COLUMNS])[AXES.index(label.axis)]
            ratios.append((abs(read / label.rate_deg_s), label.name, read, label.rate_deg_s))
    for factor in (np.degrees(1.0), np.radians(1.0)):
        off = [ratio for ratio in ratios if abs(ratio[0] / factor - 1) < 0.1]
        if ratios and len(off) > len(ratios) / 2:
            _, name, read, label_rate = off[0]
            return (
                f"rate_deg_s of {len(off)} segments is in the wrong unit: {name} says "
                f"{label_rate:g} deg/s and the {columns} read {read:.4g} deg/s, a factor of 57.3; "
                f"write rate_deg_s in deg/s and the {columns} in {unit}, or import with --units"
            )
    return None
