"""What the standard's model leaves of a contribution, and what it would take up of a pattern."""

from dataclasses import dataclass

import numpy as np

from tasks.explain.explanation import Explanation
from tasks.model.regression import inverse
from tasks.model.terms.standard import regressors
from tasks.motion.whole import Motion

TAKEN_UP = 1e-3  # of a cell's rows: a pattern of which less is left cannot be seen


@dataclass(frozen=True)
class Columns:
    """The k regressors of the standard's model in one channel.

    values: (n, k), zero where the motion is not known. known: (n,) bool.
    inverse: (k, k) of their squares.
    """

    values: np.ndarray
    known: np.ndarray
    inverse: np.ndarray

    @classmethod
    def of(cls, motion: Motion, channel: int) -> "Columns":
        """The columns of channel 0 to 5."""
        values = regressors(motion, channel)
        known = np.isfinite(values).all(axis=1)
        values[~known] = 0.0
        return cls(values, known, inverse(values.T @ values))

    def left(self, course: np.ndarray) -> np.ndarray:
        """(n,) of a course what they do not take up; zero where it or the motion is not known."""
        known = self.known & np.isfinite(course)
        filled = np.where(known, course, 0.0)
        taken = self.values @ (self.inverse @ (self.values.T @ filled))
        return np.where(known, filled - taken, 0.0)

    def pattern(
        self, rows: np.ndarray, within: np.ndarray, sums: np.ndarray
    ) -> tuple[np.ndarray, float]:
        """A step for each cell (c,), fitted to an excess together with the columns themselves.

        rows: (c,) in each cell. within: (c, k) sums of the columns over it. sums: (c,) of the
        excess. Returns the steps and the square sum that they take up.
        """
        size = np.sqrt(np.maximum(rows, 1.0))
        squares = np.diag(rows) - within @ self.inverse @ within.T
        inverse = np.linalg.pinv(squares / np.outer(size, size), rcond=TAKEN_UP, hermitian=True)
        steps = inverse @ (sums / size) / size
        return steps, float(steps @ sums)


def scales(noise: np.ndarray) -> np.ndarray:
    """The noise (6,), and where there is none (a reading that stands still) that of the triad."""
    usable = np.isfinite(noise) & (noise > 0)
    filled = np.where(usable, noise, 1.0)
    for triad in (slice(0, 3), slice(3, 6)):
        if usable[triad].any():
            filled[triad][~usable[triad]] = np.median(noise[triad][usable[triad]])
    return filled


def excess_of(explanation: Explanation, columns: tuple[Columns, ...]) -> np.ndarray:
    """(findings, n, 6): the contributions less what the standard's model takes up, over noise."""
    noise = scales(explanation.noise)
    return np.stack([
        np.column_stack([columns[c].left(finding.contribution[:, c] / noise[c]) for c in range(6)])
        for finding in explanation.findings
    ])  # fmt: skip
