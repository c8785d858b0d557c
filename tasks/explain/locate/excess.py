"""What the standard's model leaves of a finding's contribution, in standard deviations of noise."""

import numpy as np

from tasks.explain.explanation import Explanation
from tasks.motion.whole import Motion

ARITHMETIC = 1e-10  # of the largest: smaller eigenvalues are of columns that do not differ


def excess_of(explanation: Explanation, motion: Motion) -> np.ndarray:
    """(findings, n, 6): contribution less what models (1) and (2) take up of it, over the noise.

    JJF 2003-2022, 5.1 and 5.2: gyro columns ω, 1, f; accelerometer columns f, 1 and ωⱼ² of the
    other axes, by least squares. Rows whose motion is not known are zero: nothing is said there.
    """
    courses = np.stack([finding.contribution for finding in explanation.findings])
    left, noise = np.zeros_like(courses), scales(explanation.noise)
    for channel in range(6):
        course = courses[:, :, channel].T / noise[channel]
        columns = _standard_columns(motion, channel)
        known = np.isfinite(columns).all(axis=1) & np.isfinite(course).all(axis=1)
        seen = columns[known]
        left[:, known, channel] = (course[known] - seen @ _taken_up(seen, course[known])).T
    return left


def scales(noise: np.ndarray) -> np.ndarray:
    """The noise (6,), and where there is none (a reading that stands still) that of the triad."""
    usable = np.isfinite(noise) & (noise > 0)
    filled = np.where(usable, noise, 1.0)
    for triad in (slice(0, 3), slice(3, 6)):
        if usable[triad].any():
            filled[triad][~usable[triad]] = np.median(noise[triad][usable[triad]])
    return filled


def _standard_columns(motion: Motion, channel: int) -> np.ndarray:
    """(n, 6 or 7) what one channel's reading is linear in, of order 1."""
    one = np.ones((len(motion.t), 1))
    if channel < 3:
        return np.hstack([motion.rate, one, motion.up])
    return np.hstack([motion.up, one, np.delete(motion.rate**2, channel - 3, axis=1)])


def _taken_up(columns: np.ndarray, course: np.ndarray) -> np.ndarray:
    """Coefficients (k, m) of least squares; the smallest where columns do not differ."""
    gram = columns.T @ columns
    size = np.sqrt(np.diag(gram)) + (np.diag(gram) == 0)
    inverse = np.linalg.pinv(gram / np.outer(size, size), rcond=ARITHMETIC, hermitian=True)
    return np.asarray(inverse @ (columns.T @ course / size[:, None]) / size[:, None])
