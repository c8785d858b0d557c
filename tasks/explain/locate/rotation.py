"""Harmonics of a table axis' angle: least squares in every segment that turns a whole turn."""

from dataclasses import dataclass

import numpy as np

from tasks.motion.whole import Motion

BINS = 256  # of a turn
MAX_HARMONIC = 40  # waves per turn
WHOLE_TURN = 0.99 * 2 * np.pi  # rad: less is no turn
SINGULAR = 1e-6


@dataclass(frozen=True)
class Rotation:
    """The rows at which one axis turns a whole turn or more, in s segments.

    name: of the axis. rows: which of the n. cell: their segment and bin of the angle, as one
    number. inverse: (MAX_HARMONIC, s, 3, 3) of the normal equations of 1, cos hθ and sin hθ.
    highest: waves per turn that the fastest turn still has two rows for.
    """

    name: str
    rows: np.ndarray
    cell: np.ndarray
    inverse: np.ndarray
    highest: float

    def harmonic_power(self, values: np.ndarray) -> np.ndarray:
        """(MAX_HARMONIC,) square sum of values (n,) that each number of waves per turn absorbs."""
        sums, counts = (
            _per_segment(self.cell, self.inverse.shape[1], weights)
            for weights in (values[self.rows], None)
        )
        right = np.einsum("sb,hbi->hsi", sums, _basis())
        absorbed = np.einsum("hsi,hsij,hsj->hs", right, self.inverse, right)
        power = (absorbed - right[:, :, 0] ** 2 / counts.sum(axis=1)).sum(axis=1)
        return np.where(np.arange(1, MAX_HARMONIC + 1) <= self.highest, power, 0.0)


def rotations_of(
    motion: Motion, names: tuple[str, ...], segments: tuple[slice, ...]
) -> tuple[Rotation, ...]:
    """The table axes that turn; segments: rows of each."""
    if motion.axes is None:
        return ()
    turning = (
        (name, angle, [rows for rows in segments if _turns_whole(angle[rows])])
        for name, angle in zip(names, motion.axes.angles.T, strict=True)
    )
    return tuple(_rotation(*each) for each in turning if each[2])


def _turns_whole(angle: np.ndarray) -> bool:
    known = angle[np.isfinite(angle)]
    return bool(len(known) and np.ptp(known) >= WHOLE_TURN)


def _rotation(name: str, angle: np.ndarray, segments: list[slice]) -> Rotation:
    rows = np.concatenate([np.arange(each.start, each.stop) for each in segments])
    which = np.repeat(np.arange(len(segments)), [each.stop - each.start for each in segments])
    known = np.isfinite(angle[rows])
    rows, which = rows[known], which[known]
    cell = which * BINS + (angle[rows] / (2 * np.pi) % 1.0 * BINS).astype(int) % BINS
    counts = _per_segment(cell, len(segments), None).astype(float)
    basis = _basis()
    normal = np.einsum("sb,hbi,hbj->hsij", counts, basis, basis, optimize=True)
    inverse = np.linalg.pinv(normal, rcond=SINGULAR, hermitian=True)
    step = max(float(np.nanmedian(np.abs(np.diff(angle[each])))) for each in segments)
    return Rotation(name, rows, cell, inverse, np.pi / max(step, SINGULAR))


def _per_segment(cell: np.ndarray, segments: int, weights: np.ndarray | None) -> np.ndarray:
    """(segments, BINS) sums of weights, or counts, over the cells."""
    return np.bincount(cell, weights, segments * BINS).reshape(segments, BINS)


def _basis() -> np.ndarray:
    """(MAX_HARMONIC, BINS, 3): 1, cos hθ, sin hθ at the middles of the bins."""
    theta = 2 * np.pi * (np.arange(BINS) + 0.5) / BINS * np.arange(1, MAX_HARMONIC + 1)[:, None]
    return np.stack([np.ones_like(theta), np.cos(theta), np.sin(theta)], axis=-1)
