"""Noise of encoder angles, estimated from the angles themselves.

Noise, steps and the scatter of stamps show in the twelfth differences of the angle, stretch by
stretch, so that an axis that rests is exact and one that turns is as good as its encoder; a corner
of the motion is rare among them and does not count. A stretch with one step is no better than the
step, and scatter of the stamps counts by the rate. All are white from sample to sample.
"""

from math import comb

import numpy as np

from tasks.motion.encoder_rate import ROUNDING
from tasks.motion.samples import NORMAL_QUANTILES, in_blocks, noise_by_differences

NODE = 64  # samples that a noise is read off
NEAR = 8  # samples over which a speed is averaged
ORDER = 12  # of the differences: what servos do at some hertz must not count as noise
DIFFERENCE = float(np.sqrt(comb(2 * ORDER, ORDER)))  # what they make of white noise
WHOLE, MOSTLY = 0.1, 0.9  # steps: changes that are mostly whole ones within this are quantised
QUIETEST, LIKE = 0.25, 1.5  # quantile of stretches, and times its noise: as quiet
FEW_STEPS = 20.0  # more are whole within rounding whatever they are


def angle_variance(stamps: np.ndarray, angles: np.ndarray, even: np.ndarray) -> np.ndarray:
    """Variance (n, k) rad² of angles `even` (n, k) rad, resampled evenly from those that were read.

    stamps: (m,) s, angles: (m, k) rad as read; too few to estimate from count as exact.
    """
    if len(even) < NODE + ORDER:
        return np.zeros_like(even)
    changes = np.diff(even, axis=0, prepend=even[:1])
    size = _size(even)
    if len(angles) != len(even) or (angles != even).any():
        # Interpolation smooths neighbours, and the differences of those no longer show all of it.
        least = _least(angles) * np.sqrt(len(even) / len(angles))
        size = np.where(size > ROUNDING, np.maximum(size, least), 0.0)
    size = _by_stretch(size, len(even))
    moved = in_blocks(np.abs(changes[ORDER:]), NODE) > ROUNDING
    steps = encoder_steps(angles)
    # A single change tells its place to within one step: the rate there is as uncertain as any.
    coarse = _by_stretch(moved.any(axis=1) * steps**2 / 12.0, len(even))
    variance = np.maximum(size**2, coarse)
    if (size.mean(axis=0) > _size(angles).mean(axis=0)).any():
        # The samples are even and their stamps are not: interpolation hides most of it.
        jitter = noise_by_differences(stamps, 2, 0.5) * np.sqrt(len(even) / len(angles))
        jitter *= len(even) / np.ptp(stamps)
        near = np.full(NEAR, 1.0 / NEAR)
        moves = np.column_stack([np.convolve(one, near, "same") for one in changes.T])
        variance = np.maximum(variance, (moves * jitter) ** 2)
    return variance


def _least(angles: np.ndarray) -> np.ndarray:
    """(k,) noise rad of angles as read in the stretches where least moves; 0 where none has any."""
    noisy = [own[own > ROUNDING] for own in _size(angles).T]
    return np.array([
        np.median(own[own <= LIKE * np.quantile(own, QUIETEST)]) if len(own) else 0.0
        for own in noisy
    ])  # fmt: skip


def _by_stretch(values: np.ndarray, count: int) -> np.ndarray:
    """Values (m, k) of stretches at each of `count` samples."""
    middles = ORDER // 2 + NODE * (np.arange(len(values)) + 0.5)
    nearest = np.clip(np.round((np.arange(count) - middles[0]) / NODE), 0, len(values) - 1)
    return np.asarray(values[nearest.astype(int)])


def _size(angles: np.ndarray) -> np.ndarray:
    """Standard deviation (m, k) rad of the white noise of angles (n, k) in each stretch."""
    rough = in_blocks(np.abs(np.diff(angles, ORDER, axis=0)), NODE)
    return np.asarray(np.median(rough, axis=1) / NORMAL_QUANTILES[0.5] / DIFFERENCE)


def encoder_steps(angles: np.ndarray) -> np.ndarray:
    """(k,) rad, steps of encoders that read angles (n, k); 0 where changes are not whole steps."""
    return np.array([_step(course) for course in np.abs(np.diff(angles, axis=0)).T])


def _step(changes: np.ndarray) -> float:
    moved = changes[changes > ROUNDING]
    if not len(moved):
        return 0.0
    least = float(np.quantile(moved, 0.01))
    few = moved[moved < FEW_STEPS * least] / least
    whole = np.abs(few - np.round(few)) < WHOLE
    return least if whole.mean() > MOSTLY else 0.0
