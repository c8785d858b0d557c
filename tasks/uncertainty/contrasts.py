"""What the segment means say of drift, once everything is fitted away that moves them otherwise.

Rates, gravity, and the horizontal parts of Earth's rotation and of the tilt are fitted away; the
likelihood of what is left is that of restricted maximum likelihood (Patterson and Thompson,
Biometrika 58, 1971).
"""

from typing import get_args

import numpy as np

from schemas.recording import AXES, Segment, Up
from tasks.motion.table import EARTH_RATE
from tasks.segments.summarise import SegmentMean
from tasks.uncertainty.drift import LEVELS, TREND, WALK, Contrasts

UPS: tuple[Up, ...] = get_args(Up)
FEWEST_CONTRASTS = 4
# Across the vertical, rad/s and m/s²: Earth's rotation; gravity by a tilt of 20″ (Table 1).
ACROSS = (EARTH_RATE, 1e-3)


def contrasts(
    segments: tuple[SegmentMean, ...], shapes: np.ndarray, variance: np.ndarray, channel: int
) -> Contrasts:
    """What one channel's means (white variances (n,)) say of its drift, with the rest removed."""
    used = [
        i
        for i, segment in enumerate(segments)
        if variance[i] > 0
        and np.isfinite(segment.mean[channel])
        and _is_known(segment.segment, channel)
    ]
    nothing = Contrasts(np.zeros((len(LEVELS), 0)), np.zeros((len(LEVELS), 3, 0)))
    if not used:
        return nothing
    scale = 1.0 / np.sqrt([variance[i] + _left_across(segments[i], channel) ** 2 for i in used])
    design = _design([segments[i] for i in used], channel) * scale[:, None]
    size = np.linalg.norm(design, axis=0)
    left, weight, _ = np.linalg.svd(design[:, size > 0] / size[size > 0])
    free = left[:, (weight > 1e-9 * weight[0]).sum() :]
    if free.shape[1] < FEWEST_CONTRASTS:
        return nothing
    means = np.array([segments[i].mean[channel] for i in used])
    rest = free.T @ (means * scale)
    seen = free.T @ (shapes[:, used][:, :, used] * scale[:, None] * scale) @ free
    value, gain = [], []
    for level in range(len(LEVELS)):
        modes = np.linalg.eigh(seen[level])[1]
        drifts = seen[[level, WALK, TREND]]
        value.append(modes.T @ rest)
        gain.append((modes * (drifts @ modes)).sum(axis=1).clip(min=0.0))
    return Contrasts(np.array(value), np.array(gain))


def _is_known(label: Segment, channel: int) -> bool:
    """Whether a segment's inputs are known to the level of a bias.

    A turn about a gyro's own axis is not: the table's rate and the straightness of the line come
    in. Nor is a rest in which an accelerometer lies flat: each setting of the table tilts it anew.
    """
    if label.up is None or label.kind == "rotation":
        return False
    if label.kind == "static":
        return channel < len(AXES) or not _is_flat(label, channel)
    return label.rate_deg_s is not None and label.axis != dict(enumerate(AXES)).get(channel)


def _left_across(segment: SegmentMean, channel: int) -> float:
    """What parts of a turn leave of the field across the vertical, as one more noise of a mean."""
    label = segment.segment
    if label.kind != "rate" or label.rate_deg_s is None or not _is_flat(label, channel):
        return 0.0
    share = np.sinc(label.rate_deg_s * segment.seconds / 360.0)
    return ACROSS[channel // len(AXES)] * abs(float(share))


def _is_flat(label: Segment, channel: int) -> bool:
    """Whether a channel's axis lies across the vertical."""
    return (label.up or "")[1:] != AXES[channel % len(AXES)]


def _design(segments: list[SegmentMean], channel: int) -> np.ndarray:
    """Columns (n, …) of what moves a channel's mean without drift: bias, gravity, turning, field.

    The horizontal part of Earth's rotation reaches the gyros that lie flat, by the heading of the
    rest; where it is not told, anything goes. An accelerometer that lies flat in a run of rates is
    tilted by one amount in all of it.
    """
    columns = [np.ones(len(segments))]
    for axis in AXES:
        about = np.array([s.segment.rate_deg_s or 0.0 if s.segment.axis == axis else 0.0
                          for s in segments]) / 100.0  # fmt: skip
        columns += [np.array([(s.segment.up == f"+{axis}") - float(s.segment.up == f"-{axis}")
                              for s in segments]), about**2]  # fmt: skip
        if channel < len(AXES):
            columns.append(about)
    labels = [segment.segment for segment in segments]
    flat = [s.kind == "static" and _is_flat(s, channel) for s in labels]
    if channel >= len(AXES):
        turning = [s.kind == "rate" and _is_flat(s, channel) for s in labels]
        columns += [np.array([t and s.up == up for t, s in zip(turning, labels, strict=True)],
                             float) for up in UPS]  # fmt: skip
    for i, label in enumerate(labels):
        if flat[i] and label.turn_deg is None:
            columns.append(np.eye(len(labels))[i])
    for up in UPS:
        held = np.array([f and s.up == up for f, s in zip(flat, labels, strict=True)])
        told = held * np.array([s.turn_deg is not None for s in labels])
        heading = np.radians([s.turn_deg or 0.0 for s in labels])
        columns += [told * np.cos(heading), told * np.sin(heading).round(9)]
    return np.column_stack(columns)
