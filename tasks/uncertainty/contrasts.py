"""What the segment means say of drift, once everything is fitted away that moves them otherwise.

Rates, gravity, and the horizontal parts of Earth's rotation and of the tilt are fitted away; the
likelihood of what is left is that of restricted maximum likelihood (Patterson and Thompson,
Biometrika 58, 1971).
"""

from typing import get_args

import numpy as np

from schemas.recording import AXES, Up
from tasks.segments.summarise import SegmentMean
from tasks.uncertainty.drift import LEVELS, TREND, WALK, Contrasts

UPS: tuple[Up, ...] = get_args(Up)
FEWEST_CONTRASTS = 4
WHOLE_TURN = 0.1  # what may be left of a horizontal field after the turns of one rate run


def contrasts(
    segments: tuple[SegmentMean, ...], shapes: np.ndarray, variance: np.ndarray, channel: int
) -> Contrasts:
    """What one channel's means (white variances (n,)) say of its drift, with the rest removed."""
    used = [
        i
        for i, segment in enumerate(segments)
        if _is_known(segment, channel) and np.isfinite(segment.mean[channel]) and variance[i] > 0
    ]
    nothing = Contrasts(np.zeros((len(LEVELS), 0)), np.zeros((len(LEVELS), 3, 0)))
    if not used:
        return nothing
    scale = 1.0 / np.sqrt(variance[used])
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


def _is_known(segment: SegmentMean, channel: int) -> bool:
    """Whether a segment's inputs are known to the level of a bias.

    A turn about a gyro's own axis is not: the table's rate and the straightness of the line come
    in. Nor is a run over few turns, in which Earth's rotation and the tilt do not average out.
    """
    label = segment.segment
    if label.up is None or label.kind == "rotation":
        return False
    if label.kind == "static":
        return True
    if label.rate_deg_s is None or label.axis == dict(enumerate(AXES)).get(channel):
        return False
    return bool(abs(np.sinc(label.rate_deg_s * segment.seconds / 360.0)) < WHOLE_TURN)


def _design(segments: list[SegmentMean], channel: int) -> np.ndarray:
    """Columns (n, …) of what moves a channel's mean without drift: bias, gravity, turning, field.

    The horizontal parts of Earth's rotation (gyro) and of gravity by tilt (accelerometer) reach
    the channels that lie flat, by the heading of the rest; where it is not told, anything goes.
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
    flat = [s.kind == "static" and (s.up or "")[1:] != AXES[channel % 3] for s in labels]
    for i, label in enumerate(labels):
        if flat[i] and label.turn_deg is None:
            columns.append(np.eye(len(labels))[i])
    for up in UPS:
        held = np.array([f and s.up == up for f, s in zip(flat, labels, strict=True)])
        told = held * np.array([s.turn_deg is not None for s in labels])
        heading = np.radians([s.turn_deg or 0.0 for s in labels])
        columns += [told * np.cos(heading), told * np.sin(heading).round(9)]
    return np.column_stack(columns)
