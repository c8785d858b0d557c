"""Degrees of freedom of a type A uncertainty whose noise was itself estimated from the run."""

import math

import numpy as np

from tasks.segments.summarise import SegmentMean
from tasks.uncertainty.drift import INSTANT
from tasks.uncertainty.type_a import ChannelNoise

PER_DIFFERENCE = 0.8  # degrees of freedom of the white noise for each finest Allan difference
COARSE = 4.0  # Allan differences of a segment, at its two longest blocks, that flicker shows in


def type_a_dof(
    weights: np.ndarray,
    segments: tuple[SegmentMean, ...],
    noise: ChannelNoise,
    channel: int,
    variance: float,
) -> float:
    """Effective degrees of freedom of the variance of o·U, Welch-Satterthwaite (GUM G.4).

    weights: o (n,) of all segment means; variance: of o·U, whole. The white noise of a segment
    comes from its own B blocks: 0.8·(B − 1) degrees (by simulation, within 5 % from 4 blocks
    on). The drift comes from what all segments leave unexplained: as many degrees as there are
    independent contrasts between them (`drift.contrasts`), or, where there are none, four for
    each segment, the differences of its longest blocks. What else is in the variance (readings
    of an angle, by the thousand) counts as known. Without any variance: infinitely many.
    """
    if variance <= 0.0:
        return math.inf
    used = np.flatnonzero(weights)
    seconds = np.array([max(segment.seconds, INSTANT) for segment in segments])
    white = weights[used] ** 2 * noise.white[used, channel] / seconds[used]
    shape = np.tensordot(noise.drift[:, channel], noise.shapes, axes=1)[np.ix_(used, used)]
    drift = max(float(weights[used] @ shape @ weights[used]), 0.0)
    weight = float((white**2 / [_white_degrees(segments[i], segments) for i in used]).sum())
    if drift > 0.0:
        weight += drift**2 / (noise.contrasts[channel] or COARSE * len(segments))
    return max(variance**2 / weight, 1.0) if weight > 0.0 else math.inf


def _white_degrees(segment: SegmentMean, segments: tuple[SegmentMean, ...]) -> float:
    """Those of a segment's own blocks; a turn has the median noise of the segments beside it."""
    if segment.segment.kind != "rotation":
        return _degrees(segment)
    return float(np.median([_degrees(s) for s in segments if s.segment.kind != "rotation"] or [1]))


def _degrees(segment: SegmentMean) -> float:
    return max(PER_DIFFERENCE * (2.0 ** len(segment.tau) - 1.0), 1.0)
