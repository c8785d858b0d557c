"""What a triad reads per unit of each input, in the directions that the recording excites.

Range, unit and axes are the coarsest facts of a unit: a matrix fitted to means over short windows
shows them before anything else is known. A delay, a motion of its own or a fault of the codes
would bend that matrix, too; so that it must leave next to nothing of what is read.
"""

from dataclasses import dataclass

import numpy as np

from tasks.explain.channels import TRIADS
from tasks.motion.samples import in_blocks
from tasks.motion.whole import Motion

WINDOW = 0.25  # s of a mean
EXCITED = (0.05, 0.5)  # rad/s, m/s²: standard deviation of an input that shows how it is read
SLOW = 0.5  # rad/s below which an accelerometer off the axis feels next to nothing of a turn
MIN_WINDOWS = 20
MAX_LEFT = 0.25  # of what is read: root of the share of its power that the matrix leaves


@dataclass(frozen=True)
class TriadMatrix:
    """directions: (3, r) orthonormal inputs that vary; reads: (3, r) what is read of each."""

    directions: np.ndarray
    reads: np.ndarray


def triad_matrix(readings: np.ndarray, motion: Motion, triad: int) -> TriadMatrix | None:
    """The matrix of a triad, 0 or 1, from readings (n, 6) rad/s, m/s²; None if it does not fit.

    A single attitude shows the response of the accelerometers to gravity except for their bias.
    """
    means = _means(readings[:, list(TRIADS[triad])], motion, triad)
    if means is None:
        return None
    read, felt = means
    centre, middle = read.mean(axis=0), felt.mean(axis=0)
    sizes, axes = np.linalg.eigh(np.cov((felt - middle).T))
    directions = axes[:, sizes > EXCITED[triad] ** 2]
    if not directions.size:
        if triad == 0:
            return None
        size = float(np.linalg.norm(middle))
        return TriadMatrix(middle[:, None] / size, centre[:, None] / size)
    along = (felt - middle) @ directions
    reads = np.linalg.lstsq(along, read - centre, rcond=None)[0].T
    left = read - centre - along @ reads.T
    if np.sum(left**2) > MAX_LEFT**2 * np.sum((read - centre) ** 2):
        return None
    return TriadMatrix(directions, reads)


def _means(
    readings: np.ndarray, motion: Motion, triad: int
) -> tuple[np.ndarray, np.ndarray] | None:
    """Readings and inputs (m, 3) over whole windows in which both are known."""
    rows = max(1, round(WINDOW / max(motion.interval, 1e-9)))
    inputs = (motion.rate, motion.force)[triad]
    both = np.hstack([readings, inputs])
    if triad == 1:  # while it turns fast, only where nothing else was recorded
        slow = np.linalg.norm(motion.rate, axis=1) < SLOW
        still = np.where(slow[:, None], both, np.nan)
        if np.isfinite(in_blocks(still, rows)).all(axis=(1, 2)).sum() >= MIN_WINDOWS:
            both = still
    blocks = in_blocks(both, rows)
    blocks = blocks[np.isfinite(blocks).all(axis=(1, 2))]
    if len(blocks) < MIN_WINDOWS:
        return None
    means = blocks.mean(axis=1)
    return means[:, :3], means[:, 3:]
