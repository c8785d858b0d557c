"""Operations on thousands of small symmetric positive definite matrices at once.

LAPACK spends more on calling than on computing where a matrix has a few rows; here every step of
the elimination runs over all matrices. None needs pivots.
"""

import numpy as np


def inverses(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Inverses (n, m, m) and logarithms of the determinants (n,) of (n, m, m), by Gauss–Jordan."""
    left = _side_by_side(matrices)
    logarithm = np.zeros(left.shape[-1])
    for k in range(len(left)):
        pivot = left[k, k].copy()
        logarithm += np.log(pivot)
        left[k, k] = 1.0
        left[k] /= pivot
        row, column = left[k].copy(), left[:, k].copy()
        column[k] = 0.0
        left[:, k] = 0.0
        left[k] = row
        left -= column[:, None] * row
    return np.ascontiguousarray(np.moveaxis(left, -1, 0)), logarithm


def quadratic_forms(matrices: np.ndarray, right: np.ndarray) -> np.ndarray:
    """(n,) rᵀ·A⁻¹·r of matrices A (n, m, m) and right sides r (n, m), by elimination."""
    left, rest = _side_by_side(matrices), np.array(right.T)
    total = np.zeros(left.shape[-1])
    for k in range(len(left)):
        total += rest[k] ** 2 / left[k, k]
        column = left[k + 1 :, k] / left[k, k]
        rest[k + 1 :] -= column * rest[k]
        left[k + 1 :, k + 1 :] -= column[:, None] * left[k, k + 1 :]
    return total


def _side_by_side(matrices: np.ndarray) -> np.ndarray:
    """A copy (m, m, n), in which the same element of all matrices is contiguous."""
    return np.array(np.moveaxis(matrices, 0, -1), order="C")
