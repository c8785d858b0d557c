"""What goes in waves with the turns of one table axis, by least squares in every segment."""

from dataclasses import dataclass

import numpy as np

from tasks.motion.whole import Motion

BINS = 256  # of a turn
HIGHEST = 40  # waves per turn
WHOLE_TURN = 0.99 * 2 * np.pi  # rad: less is no turn
SINGULAR = 1e-6


@dataclass(frozen=True)
class Turns:
    """The rows at which one axis turns a whole turn or more, in s segments.

    name: of the axis. rows: which of the n. cell: their segment and bin of the angle, as one
    number. inverse: (HIGHEST, s, 3, 3) of the normal equations of 1, cos hθ and sin hθ.
    most: waves per turn that the fastest turn still has two rows for.
    """

    name: str
    rows: np.ndarray
    cell: np.ndarray
    inverse: np.ndarray
    most: float

    def waves(self, course: np.ndarray) -> np.ndarray:
        """(HIGHEST,) square sum of a course (n,) that each number of waves per turn takes up."""
        segments = self.inverse.shape[1]
        sums = np.bincount(self.cell, course[self.rows], segments * BINS).reshape(-1, BINS)
        right = np.einsum("sb,hbi->hsi", sums, _basis())
        counts = np.bincount(self.cell, minlength=segments * BINS).reshape(-1, BINS).sum(axis=1)
        taken = np.einsum("hsi,hsij,hsj->hs", right, self.inverse, right)
        held = (taken - right[:, :, 0] ** 2 / counts).sum(axis=1)
        return np.where(np.arange(1, HIGHEST + 1) <= self.most, held, 0.0)


def turns_of(
    motion: Motion, names: tuple[str, ...], segments: tuple[slice, ...]
) -> tuple[Turns, ...]:
    """The table axes that turn; segments: rows of each."""
    if motion.axes is None:
        return ()
    found = []
    for name, angle in zip(names, motion.axes.angles.T, strict=True):
        turning = [each for each in segments if _turned(angle[each]) >= WHOLE_TURN]
        if turning:
            found.append(_turns(name, angle, turning))
    return tuple(found)


def _turned(angle: np.ndarray) -> float:
    known = angle[np.isfinite(angle)]
    return float(np.ptp(known)) if len(known) else 0.0


def _turns(name: str, angle: np.ndarray, segments: list[slice]) -> Turns:
    rows = np.concatenate([np.arange(each.start, each.stop) for each in segments])
    which = np.repeat(np.arange(len(segments)), [each.stop - each.start for each in segments])
    known = np.isfinite(angle[rows])
    rows, which = rows[known], which[known]
    cell = which * BINS + (angle[rows] / (2 * np.pi) % 1.0 * BINS).astype(int) % BINS
    counts = np.bincount(cell, minlength=len(segments) * BINS).reshape(-1, BINS)
    basis = _basis()
    gram = np.einsum("sb,hbi,hbj->hsij", counts.astype(float), basis, basis, optimize=True)
    inverse = np.linalg.pinv(gram, rcond=SINGULAR, hermitian=True)
    step = max(float(np.nanmedian(np.abs(np.diff(angle[each])))) for each in segments)
    return Turns(name, rows, cell, inverse, np.pi / max(step, SINGULAR))


def _basis() -> np.ndarray:
    """(HIGHEST, BINS, 3): 1, cos hθ, sin hθ at the middles of the bins."""
    theta = 2 * np.pi * (np.arange(BINS) + 0.5) / BINS * np.arange(1, HIGHEST + 1)[:, None]
    return np.stack([np.ones_like(theta), np.cos(theta), np.sin(theta)], axis=-1)
