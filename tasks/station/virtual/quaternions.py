"""Rotations as unit quaternions (w, x, y, z), many at once in arrays of shape (4, n).

A rotation takes vectors of the inner frame to the outer one: v_outer = R(q)·v_inner.

Written out because scipy's Rotation (1.17) takes thirteen times as long for the tracks of
`tasks.validation.simulated_calibration`, which are made by the thousand; the tests hold it against
scipy.
"""

import numpy as np


def about(direction: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rotations (4, n) about one unit direction (3,) by the angles (n,) in rad."""
    half = np.asarray(angle) / 2.0
    return np.vstack([np.cos(half), direction[:, None] * np.sin(half)])


def conjugate(q: np.ndarray) -> np.ndarray:
    """The rotations back, (4, n)."""
    return q * np.array([[1.0], [-1.0], [-1.0], [-1.0]])


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """R(p)·R(q), (4, n); either may have n = 1."""
    w, x, y, z = p
    a, b, c, d = q
    return np.stack(
        [
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        ]
    )


def up_in_body(q: np.ndarray) -> np.ndarray:
    """The outer frame's third axis in the inner frame, R(q)ᵀ·(0, 0, 1): (3, n)."""
    w, x, y, z = q
    return np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)])


def rotation_vector(q: np.ndarray) -> np.ndarray:
    """Rotation vectors (3, n) in rad of rotations by less than half a turn."""
    sine = np.sqrt(q[1] ** 2 + q[2] ** 2 + q[3] ** 2)
    turning = sine > 0
    factor = np.full_like(sine, 2.0)
    factor[turning] = 2.0 * np.arctan2(sine[turning], q[0][turning]) / sine[turning]
    return q[1:] * factor
