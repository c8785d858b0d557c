"""The evidence of a recording for JJF 2003: its segments summarised and sorted."""

from dataclasses import replace

import numpy as np

from schemas.recording import AXES, Recording, Up
from tasks.segments.find import GRAVITY_LIKE, find_segments, up_of
from tasks.segments.rates import turning_points
from tasks.segments.summarise import (
    ACCEL_COLUMNS,
    MIN_ROWS,
    SegmentMean,
    rows_of,
    summarise_all,
)
from tasks.specifications.earth_rotation import earth_rotation_gain
from tasks.specifications.evidence import ClauseEvidence
from tasks.uncertainty.type_a import fit_noise


def gather(recording: Recording) -> ClauseEvidence:
    """Summarise a recording's segments, labelled or found, and sort them."""
    labels = recording.manifest.segments
    if labels:
        long_enough = tuple(s for s in labels if rows_of(recording, s) >= MIN_ROWS)
        segments = summarise_all(recording, long_enough, "label")
    else:
        segments = summarise_all(recording, find_segments(recording), "found")
    points = turning_points(recording, segments)
    rate = np.array([points[i].rate if i in points else np.nan for i in range(len(segments))])
    up = tuple(_up(segment) for segment in segments)
    evidence = ClauseEvidence(
        recording=recording,
        segments=segments,
        means=np.array([segment.mean for segment in segments]).reshape(-1, 6),
        noise=fit_noise(segments, up, rate),
        up=up,
        rate=rate,
        turning_points=points,
    )
    return replace(evidence, earth=earth_rotation_gain(evidence))


def _up(segment: SegmentMean) -> Up | None:
    """The axis up: what gravity shows, else the label; None where gravity shows no axis.

    While turning, only what is felt along the spin axis is gravity: a lever arm adds its own
    acceleration across it.
    """
    label = segment.segment
    found_rest = segment.origin == "found" and label.kind == "static"
    if found_rest or not segment.has_accel or label.kind == "rotation":
        return label.up
    accel = segment.mean[ACCEL_COLUMNS]
    if label.kind != "rate" or label.axis is None:
        return up_of(accel)
    along = accel[AXES.index(label.axis)]
    if not GRAVITY_LIKE[0] < abs(along) < GRAVITY_LIKE[1]:
        return None
    return f"{'+' if along > 0 else '-'}{label.axis}"  # type: ignore[return-value]
