"""What the unit went through in each segment, on average."""

import numpy as np

from schemas.recording import AXES, Recording
from tasks.motion.table import labelled_direction, mean_rate
from tasks.motion.whole import (
    Motion,
    attitude_stream,
    gravity_of,
    unit_vector,
    whole_motion,
)
from tasks.segments.rates import held_rate
from tasks.specifications.evidence import ClauseEvidence

SAMPLES = 400  # times within a segment at which its attitude is looked up
SAME_VERTICAL = np.cos(np.radians(10.0))  # encoders and gravity agree on the axis up within this


def mean_motion(evidence: ClauseEvidence) -> tuple[Motion, np.ndarray]:
    """Mean motion of each segment, and (n,) bool where the vertical in it is known.

    Rests and rates that labels and witnesses contradict are taken as `gather` took them: the axis
    up by gravity, the rate by the encoders. A turn about the vertical has no mean north.
    """
    recording, segments = evidence.recording, evidence.segments
    looked = [np.linspace(s.t_start, s.t_end, SAMPLES, endpoint=False) for s in segments]
    whole = whole_motion(recording, np.concatenate([np.zeros(0), *looked]))
    shape = (len(segments), SAMPLES, 3)
    up, north = whole.up.reshape(shape).mean(axis=1), whole.north.reshape(shape).mean(axis=1)
    rate = mean_rates(evidence)
    rate = np.where(_turned(evidence), rate, 0.0 * rate)
    vertical, stream = np.zeros(len(segments), bool), attitude_stream(recording)
    for i, segment in enumerate(segments):
        shown = labelled_direction(recording.manifest, segment.segment, unit_vector(evidence.up[i]))
        agrees = not np.isfinite(shown).all() or up[i] @ shown >= SAME_VERTICAL
        if stream is None or not np.isfinite(up[i]).all() or not agrees:
            up[i], north[i] = shown, np.nan
        vertical[i] = np.isfinite(up[i]).all()
        if segment.segment.kind != "static":
            north[i] = np.nan_to_num(north[i])
            if not vertical[i] and segment.has_accel:
                up[i] = segment.mean[3:] / gravity_of(recording)
    t = np.array([0.5 * (segment.t_start + segment.t_end) for segment in segments])
    return Motion(t, up, north, rate, np.zeros_like(rate), gravity_of(recording)), vertical


def mean_rates(evidence: ClauseEvidence) -> np.ndarray:
    """Mean rate (n, 3) rad/s of each segment about the unit's axes; NaN where nobody knows it."""
    rates = [_rate(evidence.recording, evidence, i) for i in range(len(evidence.segments))]
    return np.array(rates).reshape(-1, 3)


def _turned(evidence: ClauseEvidence) -> np.ndarray:
    """(3,) bool: axes with a run of rates or a turn; the rest about the others is misalignment.

    Ten microradians of it would otherwise count as an input, and the axis as one that was turned.
    """
    return np.array([bool(evidence.points[axis] or evidence.turns[axis]) for axis in AXES])


def _rate(recording: Recording, evidence: ClauseEvidence, i: int) -> np.ndarray:
    """Mean body rate (3,) rad/s of a segment; NaN where nobody knows it."""
    label = evidence.segments[i].segment
    if label.kind == "static":
        return np.zeros(3)
    if label.kind == "rate" and not np.isfinite(evidence.rate[i]):
        return np.full(3, np.nan)
    shown = held_rate if label.kind == "rate" else mean_rate
    by_table = shown(recording, label)
    if by_table is not None:
        return by_table
    about = np.eye(3)[AXES.index(label.axis or "x")]
    about = labelled_direction(recording.manifest, label, about)
    if label.kind == "rate":
        return np.asarray(evidence.rate[i] * about)
    angle = np.radians(np.nan if label.angle_deg is None else label.angle_deg)
    return about * angle / evidence.segments[i].seconds
