"""5.1: from the angles that an AHRS puts out to the angles it was turned by."""

import numpy as np


def sensed_angles(
    output: np.ndarray, misalignment: np.ndarray, zero: np.ndarray, seconds: np.ndarray | float
) -> np.ndarray:
    """A (…, 3) = L⁻¹·(N − B·T), eq. (2) with the product that its «+» stands for.

    output: N (…, 3), accumulated angles; seconds: T (…), since they were zero.
    misalignment: (3, 3) off-diagonal ratios of eq. (1), the diagonal is not looked at.
    zero: B (3,), unit of N per second.
    """
    matrix = np.where(np.eye(3, dtype=bool), 1.0, misalignment)
    offset = np.asarray(seconds)[..., None] * zero
    return np.linalg.solve(matrix, (output - offset)[..., None])[..., 0]
