"""The matrix by which a triad reads its inputs, and the signed permutation that it is near.

A working unit reads each axis along itself, to within a few degrees: a matrix that does so only
after some axes are exchanged or inverted tells which.
"""

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from tasks.motion.samples import in_blocks
from tasks.motion.whole import Motion

TRIADS = ((0, 1, 2), (3, 4, 5))
WINDOW = 0.25  # s of a mean
EXCITED = (0.05, 0.5)  # rad/s, m/s²: standard deviation of an input that shows how it is read
SLOW = 0.5  # rad/s below which an accelerometer off the axis feels next to nothing of a turn
MIN_WINDOWS = 20
MAX_LEFT = 0.25  # of what is read: root of the share of its power that the matrix leaves
ALIGNED = np.radians(20.0)  # from the axis it should be on: a working unit, roughly fixed
ASTRAY = np.radians(60.0)  # from there: another axis, or the other way round
MATRICES = tuple(
    np.eye(3)[list(order)] * np.array(signs)[:, None]
    for order in permutations(range(3))
    for signs in product((1.0, -1.0), repeat=3)
)


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
    return matrix_of(read, felt, EXCITED[triad], forces=triad == 1)


def matrix_of(
    read: np.ndarray, felt: np.ndarray, excited: float, *, forces: bool
) -> TriadMatrix | None:
    """The matrix by means of readings and inputs (m, 3); None where it leaves much of them.

    excited: standard deviation of an input that shows how it is read. forces: whether a single
    input shows the response, too.
    """
    centre, middle = read.mean(axis=0), felt.mean(axis=0)
    sizes, axes = np.linalg.eigh(np.cov((felt - middle).T))
    directions = axes[:, sizes > excited**2]
    if not directions.size:
        if not forces:
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


def fitting(found: TriadMatrix) -> list[np.ndarray]:
    """The signed permutations with which a triad reads along its axes, fewest changes first."""
    if _astray(found, np.eye(3)) < ASTRAY:
        return [np.eye(3)]
    good = [matrix for matrix in MATRICES if _astray(found, matrix) < ALIGNED]
    return sorted(good, key=_changes)


def _astray(found: TriadMatrix, matrix: np.ndarray) -> float:
    """The largest angle between the response to an input and that of a permutation."""
    expected = matrix @ found.directions
    size = np.linalg.norm(found.reads, axis=0)
    cosine = np.sum(expected * found.reads, axis=0) / np.where(size > 0, size, 1.0)
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)).max())


def _changes(matrix: np.ndarray) -> tuple[int, int]:
    """How many axes are not read as they should be, and how many of them are inverted."""
    return int(3 - np.sum(np.diag(matrix) == 1.0)), int(np.sum(matrix < 0))
