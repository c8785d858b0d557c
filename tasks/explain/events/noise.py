"""The noise of a sample, from the scatter within blocks."""

import numpy as np

from tasks.motion.whole import Motion

BLOCK = 64  # rows, within which the noise is estimated
RATE_CLASSES = np.array(
    [0.0, 0.02, 0.1, 0.3, 0.6, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, np.inf]
)  # rad/s
MIN_BLOCKS = 3  # that the noise of a class of rates is estimated from
DEAD = 1e-10  # rad/s, m/s²: less scatter is the rounding of sums


def noise_by_rate(residual: np.ndarray, motion: Motion) -> np.ndarray:
    """Standard deviation (n, 6) of a sample at each row's rate: vibration grows with the rate.

    residual: (n, 6), NaN where unknown. The median over the blocks of a class of rates, so that
    a few disturbed blocks do not matter, linear in the rate between the classes.
    """
    blocks = len(residual) // BLOCK
    if blocks == 0:
        return np.full(residual.shape, np.nan)
    scatter = _block_scatter(residual)
    speed = np.linalg.norm(motion.rate, axis=1)
    speeds = speed[: blocks * BLOCK].reshape(blocks, BLOCK).mean(axis=1)
    return np.column_stack([_interpolated_noise(column, speeds, speed) for column in scatter.T])


def without_dead(noise: np.ndarray) -> np.ndarray:
    """The noise (n, 6), NaN in a channel that never scatters: it is dead."""
    return np.where(np.nan_to_num(noise).max(axis=0) > DEAD, noise, np.nan)


def _block_scatter(residual: np.ndarray) -> np.ndarray:
    """Standard deviation (blocks, 6) about a straight line within each whole block of rows."""
    blocks = len(residual) // BLOCK
    cut = residual[: blocks * BLOCK].reshape(blocks, BLOCK, 6)
    line = np.linspace(-1.0, 1.0, BLOCK)
    about = cut - cut.mean(axis=1, keepdims=True)
    slope = np.einsum("bni,n->bi", about, line) / (line @ line)
    total = (about**2).sum(axis=1) - slope**2 * (line @ line)
    return np.sqrt(np.maximum(total, 0.0) / (BLOCK - 2))


def _interpolated_noise(scatter: np.ndarray, speeds: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """Noise (n,) at each speed (n,), from the scatter and the mean speed of blocks (b,)."""
    good = np.isfinite(scatter) & np.isfinite(speeds)
    if not good.any():
        finite = scatter[np.isfinite(scatter)]
        return np.full(len(speed), np.median(finite) if len(finite) else np.nan)
    scatter, speeds = scatter[good], speeds[good]
    label = np.digitize(speeds, RATE_CLASSES)
    classes = [label == k for k in np.unique(label)]
    classes = [c for c in classes if c.sum() >= MIN_BLOCKS or c.all()]
    if not classes:
        return np.full(len(speed), np.median(scatter))
    at = [float(np.median(speeds[c])) for c in classes]
    return np.interp(np.nan_to_num(speed), at, [float(np.median(scatter[c])) for c in classes])
