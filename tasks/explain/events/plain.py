"""How noisy it is where: the scatter within blocks of what a plain fit leaves."""

import numpy as np

from tasks.motion.whole import Motion

BLOCK = 64  # rows; noise is told from what scatters within so many
CLASSES = np.array([0.0, 0.02, 0.1, 0.3, 0.6, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, np.inf])
DEAD = 1e-10  # rad/s, m/s²: what scatters less is the rounding of sums
FEWEST = 3  # blocks that a class of rates needs to tell its noise


def read_at(at: np.ndarray, t: np.ndarray, courses: np.ndarray) -> np.ndarray:
    """Courses (n, k) at times t (n,) s, between their rows at the times `at` (m,): (m, k)."""
    return np.column_stack([np.interp(at, t, course) for course in courses.T])


def noise_of(residual: np.ndarray, motion: Motion) -> np.ndarray:
    """Standard deviation (n, 6) of a sample: vibration makes it grow with the rate.

    From what scatters about a straight line within blocks of rows, by classes of rate; the median
    of a class, so that few disturbed blocks do not matter.
    """
    blocks = len(residual) // BLOCK
    if blocks == 0:
        return np.full(residual.shape, np.nan)
    scatter = block_scatter(residual)
    speed = np.linalg.norm(motion.rate, axis=1)
    speeds = speed[: blocks * BLOCK].reshape(blocks, BLOCK).mean(axis=1)
    noise = np.empty(residual.shape)
    for channel in range(6):
        noise[:, channel] = _by_rate(scatter[:, channel], speeds, speed)
    return noise


def alive(noise: np.ndarray) -> np.ndarray:
    """The noise (n, 6), NaN of a channel that never scatters: it is dead."""
    return np.where(np.nan_to_num(noise).max(axis=0) > DEAD, noise, np.nan)


def block_scatter(residual: np.ndarray) -> np.ndarray:
    """Standard deviation (blocks, 6) of whole blocks of rows about a straight line each."""
    blocks = len(residual) // BLOCK
    cut = residual[: blocks * BLOCK].reshape(blocks, BLOCK, 6)
    line = np.linspace(-1.0, 1.0, BLOCK)
    about = cut - cut.mean(axis=1, keepdims=True)
    slope = np.einsum("bni,n->bi", about, line) / (line @ line)
    total = (about**2).sum(axis=1) - slope**2 * (line @ line)
    return np.sqrt(np.maximum(total, 0.0) / (BLOCK - 2))


def _by_rate(scatter: np.ndarray, speeds: np.ndarray, speed: np.ndarray) -> np.ndarray:
    good = np.isfinite(scatter) & np.isfinite(speeds)
    if not good.any():
        finite = scatter[np.isfinite(scatter)]
        return np.full(len(speed), np.median(finite) if len(finite) else np.nan)
    level = np.digitize(speeds[good], CLASSES)
    at, noise = [], []
    for each in np.unique(level):
        inside = level == each
        if inside.sum() >= FEWEST or inside.sum() == good.sum():
            at.append(float(np.median(speeds[good][inside])))
            noise.append(float(np.median(scatter[good][inside])))
    if not at:
        at, noise = [0.0], [float(np.median(scatter[good]))]
    return np.interp(np.nan_to_num(speed), at, noise)
