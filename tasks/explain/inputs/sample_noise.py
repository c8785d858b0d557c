"""Noise and quantisation step of single samples, from the residual of a plain fit."""

from dataclasses import replace

import numpy as np

from tasks.model.fit import plain_prediction
from tasks.motion.whole import Motion

KEPT, MEAN_OF_KEPT = 0.98, 0.8734  # of the squares; their mean for standard normal ones
MAX_READINGS = 50_000  # that the output's step is read off
TIE = 1e-9
MIN_ROWS, MAX_ROWS = 30, 4000  # of a segment
WHOLE, MIN_WHOLE = 0.02, 0.9  # changes are whole steps within this, nine in ten of them
DITHERED = 0.5  # of the readings differ from the one before: noise is larger than the step


def noise_by_segment(
    readings: np.ndarray, motion: Motion, segment: np.ndarray, count: int
) -> np.ndarray:
    """(count + 1, 2) variance of a sample's noise in each segment, by triad; last: between them.

    segment: (n,) index of each row, −1 between them.

    From second differences, the largest left out, so that neither motion nor single bad samples
    count: of what a straight-line fit leaves, or of the readings themselves where that is less, as
    it is where the reference is noisier than the unit.
    """
    # Readings keep their noise where the motion is not known: there it is taken to be none.
    moved = motion.translation
    still = replace(
        motion,
        up=np.nan_to_num(motion.up),
        rate=np.nan_to_num(motion.rate),
        acceleration=np.nan_to_num(motion.acceleration),
        translation=None if moved is None else np.nan_to_num(moved),
    )
    left = readings - plain_prediction(readings, still, ~motion.felt, own_squared_rate=True)
    variances = [_by_segment(course, segment, count) for course in (left, readings)]
    return np.fmin(*variances)


def _by_segment(course: np.ndarray, segment: np.ndarray, count: int) -> np.ndarray:
    """(count + 1, 2) by the second differences of a course (n, 6)."""
    rough = np.full_like(course, np.nan)
    rough[1:-1] = np.diff(course, 2, axis=0) ** 2 / 6.0
    variance = np.full((count + 1, 2), np.nan)
    for k in range(-1, count):
        rows = np.flatnonzero(segment == k)
        if len(rows) < MIN_ROWS:
            continue
        rows = rows[:: 1 + len(rows) // MAX_ROWS]
        for triad in range(2):
            part = rough[rows, 3 * triad : 3 * triad + 3]
            part = part[np.isfinite(part)]
            if len(part):
                # Quantised readings tie at the quantile, where rounding must not choose.
                part = part[part <= np.quantile(part, KEPT) * (1.0 + TIE)]
                variance[k, triad] = part.mean() / MEAN_OF_KEPT
    return variance


def output_steps(readings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(6,) steps of the outputs, 0 if there are none, and whether the noise exceeds them."""
    steps, dithered = np.zeros(6), np.ones(6, bool)
    for channel, reading in enumerate(readings.T):
        changes = np.abs(np.diff(reading[np.isfinite(reading)][:MAX_READINGS]))
        moved = changes[changes > 0]
        if not len(moved):
            continue
        least = float(np.quantile(moved, 0.01))
        parts = moved / least
        if np.mean(np.abs(parts - np.round(parts)) < WHOLE * np.maximum(1.0, parts)) > MIN_WHOLE:
            steps[channel] = least
            dithered[channel] = len(moved) > DITHERED * len(changes)
    return steps, dithered
