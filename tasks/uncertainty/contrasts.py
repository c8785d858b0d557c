"""Error contrasts of the segment means, which only drift and white noise affect.

Rates, gravity, and the horizontal parts of Earth's rotation and of the tilt are fitted away; the
likelihood of the residuals is that of restricted maximum likelihood (Patterson and Thompson,
Biometrika 58, 1971).
"""

import math
from typing import get_args

import numpy as np

from schemas.recording import AXES, Segment, Up
from tasks.motion.table import EARTH_RATE
from tasks.segments.summarise import SegmentMean
from tasks.uncertainty.drift import LEVELS, TREND, WALK, Contrasts, strength_grid, strength_prior

FACES: tuple[Up, ...] = get_args(Up)
MIN_CONTRASTS = 4
GRAVITY = 9.8  # m/s², for what a tilt does to a level accelerometer
MAX_SHARE = 1e6  # of a variance in that of the white noise: a tilt of arcminutes at full rate
SHOWN_TILT = 1e-9  # of what tilts do to the means: less is rounding
TILT_ABSENT = 0.5  # a priori probability that no point is tilted for itself
# Across the vertical, rad/s and m/s²: Earth's rotation; gravity by a tilt of 20″ (Table 1).
LEVEL_FIELD = (EARTH_RATE, 1e-3)


def contrasts(
    segments: tuple[SegmentMean, ...], shapes: np.ndarray, variance: np.ndarray, channel: int
) -> Contrasts:
    """The error contrasts of one channel's means; variance: (n,) white variances of the means."""
    used = [
        i
        for i, segment in enumerate(segments)
        if variance[i] > 0
        and math.isfinite(segment.mean[channel])
        and _has_known_input(segment.segment, channel)
    ]
    tilted = np.zeros(len(segments))
    none = Contrasts(np.zeros((len(LEVELS), 0)), np.zeros((len(LEVELS), 3, 0)), tilted)
    if not used:
        return none
    known = [segments[i] for i in used]
    means = np.array([segment.mean[channel] for segment in known])
    design, shapes = _design(known, channel), shapes[:, used][:, :, used]
    spread = variance[used] + _level_residuals(known, channel) ** 2
    tilting = _tilting(known, channel) ** 2
    if tilting.any():
        shown = np.array([shapes[0], np.diag(tilting)])
        residual, covariance = _without(design, means, shown, spread)
        # Where the turns themselves leave nothing of a tilt over, none is shown.
        shows = np.trace(covariance[1]) > SHOWN_TILT * (tilting / spread).sum()
        if len(residual) >= MIN_CONTRASTS and shows:
            tilted[used] = tilting * _tilt_variance(residual, *covariance)
            spread = spread + tilted[used]
    residual, covariance = _without(design, means, shapes, spread)
    if len(residual) < MIN_CONTRASTS:
        return none
    modes = np.linalg.eigh(covariance[: len(LEVELS)])[1]
    drifts = covariance[[[level, WALK, TREND] for level in range(len(LEVELS))]]
    gain = (modes[:, None] * (drifts @ modes[:, None])).sum(axis=2).clip(min=0.0)
    return Contrasts(residual @ modes, gain, tilted)


def _without(
    design: np.ndarray, means: np.ndarray, covariances: np.ndarray, spread: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Residuals (m,) of unit variance by `spread` (n,), and the covariances (…, m, m) there."""
    scale = 1.0 / np.sqrt(spread)
    scaled = design * scale[:, None]
    size = np.linalg.norm(scaled, axis=0)
    vectors, weight, _ = np.linalg.svd(scaled[:, size > 0] / size[size > 0])
    null_space = vectors[:, (weight > 1e-9 * weight[0]).sum() :]
    of_residuals = null_space.T @ (covariances * scale[:, None] * scale) @ null_space
    return null_space.T @ (means * scale), of_residuals


def _tilting(segments: list[SegmentMean], channel: int) -> np.ndarray:
    """What a tilt of a rate point's axis does to its mean, (n,) per rad."""
    across = np.array([
        s.segment.kind == "rate" and s.segment.axis != AXES[channel % len(AXES)] for s in segments
    ])  # fmt: skip
    if channel >= len(AXES):
        return GRAVITY * across
    rate = np.radians([segment.segment.rate_deg_s or 0.0 for segment in segments])
    return np.asarray(across * np.abs(rate))


def _tilt_variance(residual: np.ndarray, flicker: np.ndarray, tilted: np.ndarray) -> float:
    """Mean variance (rad²) of the tilt that each rate point has for itself, beside flicker.

    It belongs to the rate points alone; taken for drift it would enter every item at rest.
    residual: (m,) of unit variance by noise; flicker, tilted: (m, m), its covariance per unit.
    """
    strengths = []
    for shape in (flicker, tilted):
        detectable = 1.0 / np.linalg.eigvalsh(shape)[-1]
        strengths.append((strength_grid(detectable, MAX_SHARE * detectable), detectable))
    (flickers, usual), (tilts, visible) = strengths
    # Bordered by the residual, each factor ends with a row that is the residual whitened.
    count = len(residual)
    total = np.empty((len(flickers), len(tilts), count + 1, count + 1))
    total[..., :count, :count] = np.multiply.outer(flickers, flicker)[:, None] + np.eye(count)
    total[..., :count, :count] += np.multiply.outer(tilts, tilted)
    total[..., count, :count] = total[..., :count, count] = residual
    total[..., count, count] = 1.0 + 2.0 * residual @ residual  # so much that it stays positive
    root = np.linalg.cholesky(total)
    likelihood = -np.log(np.diagonal(root, axis1=2, axis2=3)[..., :count]).sum(axis=2)
    likelihood = likelihood - 0.5 * (root[..., count, :count] ** 2).sum(axis=2)
    prior = strength_prior(tilts, visible, TILT_ABSENT)
    posterior = np.exp(likelihood - likelihood.max())
    posterior *= strength_prior(flickers, usual, 0.0)[:, None] * prior
    return float(posterior.sum(axis=0) @ tilts / posterior.sum())


def _has_known_input(label: Segment, channel: int) -> bool:
    """Whether a segment's inputs are known to the level of a bias.

    For a turn about a gyro's own axis they are not: the table's rate and the linearity matter. Nor
    for a rest with a level accelerometer: each setting of the table has another tilt.
    """
    if label.up is None or label.kind == "rotation":
        return False
    if label.kind == "static":
        return channel < len(AXES) or not _is_level(label, channel)
    return label.rate_deg_s is not None and label.axis != dict(enumerate(AXES)).get(channel)


def _level_residuals(segments: list[SegmentMean], channel: int) -> np.ndarray:
    """What parts of a turn leave (n,) of the field across the vertical, as one more noise."""
    labels = [segment.segment for segment in segments]
    level = [label.kind == "rate" and _is_level(label, channel) for label in labels]
    turns = np.array([(s.segment.rate_deg_s or 0.0) * s.seconds for s in segments]) / 360.0
    return LEVEL_FIELD[channel // len(AXES)] * np.abs(level * np.sinc(turns))


def _is_level(label: Segment, channel: int) -> bool:
    """Whether a channel's axis lies across the vertical."""
    return (label.up or "")[1:] != AXES[channel % len(AXES)]


def _design(segments: list[SegmentMean], channel: int) -> np.ndarray:
    """Columns (n, …) of what moves a channel's mean without drift: bias, gravity, turning, field.

    The horizontal part of Earth's rotation reaches the gyros that lie level, by the heading of the
    rest; a rest of unknown heading has a column of its own. An accelerometer that lies level in a
    run of rates is tilted by one amount in all of it.
    """
    labels = [segment.segment for segment in segments]
    up = np.array([label.up or "" for label in labels])
    about = np.array([label.axis or "" for label in labels])
    kind = np.array([label.kind for label in labels])
    rate = np.array([label.rate_deg_s or 0.0 for label in labels]) / 100.0
    heading = np.radians([label.turn_deg or 0.0 for label in labels])
    has_heading = np.array([label.turn_deg is not None for label in labels])
    level = np.array([_is_level(label, channel) for label in labels])
    columns = [np.ones(len(labels))]
    for axis in AXES:
        turning = np.where(about == axis, rate, 0.0)
        columns += [1.0 * (up == f"+{axis}") - (up == f"-{axis}"), turning**2]
        if channel < len(AXES):
            columns.append(turning)
    if channel >= len(AXES):
        columns += [1.0 * (level & (kind == "rate") & (up == face)) for face in FACES]
    at_rest = level & (kind == "static")
    columns += list(np.eye(len(labels))[at_rest & ~has_heading])
    for face in FACES:
        held = at_rest & has_heading & (up == face)
        columns += [held * np.cos(heading), held * np.sin(heading).round(9)]
    return np.column_stack(columns)
