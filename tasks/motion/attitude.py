"""Heading, pitch and roll, and the strapdown matrix: JJF 1536-2015, Appendix B.

The matrix T = C_b^n takes components along the body's x, y, z (right, forward, up) to East,
North, Up. (B.4) is read as heading = atan2(−T12, T22) and roll = atan2(−T31, T33): as printed it
has both with the wrong sign and knows half of the quadrants.
"""

from dataclasses import dataclass

import numpy as np

SEPARABLE = 1e-8  # cos θ below which rounding leaves nothing to tell heading from roll by


@dataclass(frozen=True)
class Attitude:
    """Three angles (rad, any shape, one for all).

    heading, roll: −π to π; pitch: −π/2 to π/2.
    separable: bool; False where pitch is ±90° and only heading + roll (nose up) or heading − roll
        (nose down) exists: that combination is given as the heading, and the roll is zero.
    """

    heading: np.ndarray
    pitch: np.ndarray
    roll: np.ndarray
    separable: np.ndarray


def strapdown_matrix(heading: np.ndarray, pitch: np.ndarray, roll: np.ndarray) -> np.ndarray:
    """T (…, 3, 3) of angles (…) in rad, eq. (B.1)."""
    heading, pitch, roll = np.broadcast_arrays(heading, pitch, roll)
    sin_h, cos_h = np.sin(heading), np.cos(heading)
    sin_p, cos_p = np.sin(pitch), np.cos(pitch)
    sin_r, cos_r = np.sin(roll), np.cos(roll)
    matrix = np.empty((*heading.shape, 3, 3))
    matrix[..., 0, 0] = cos_h * cos_r - sin_h * sin_p * sin_r
    matrix[..., 0, 1] = -sin_h * cos_p
    matrix[..., 0, 2] = cos_h * sin_r + sin_h * sin_p * cos_r
    matrix[..., 1, 0] = sin_h * cos_r + cos_h * sin_p * sin_r
    matrix[..., 1, 1] = cos_h * cos_p
    matrix[..., 1, 2] = sin_h * sin_r - cos_h * sin_p * cos_r
    matrix[..., 2, 0] = -cos_p * sin_r
    matrix[..., 2, 1] = sin_p
    matrix[..., 2, 2] = cos_p * cos_r
    return matrix


def attitude_of(matrix: np.ndarray) -> Attitude:
    """The angles of T (…, 3, 3), eq. (B.4) as corrected, over all quadrants.

    The pitch asin(T32) is taken as atan2(T32, cos θ), the same angle without the loss of digits
    that asin has near ±90°.
    """
    level = np.hypot(matrix[..., 0, 1], matrix[..., 1, 1])  # cos θ
    separable = level >= SEPARABLE
    heading = np.arctan2(-matrix[..., 0, 1], matrix[..., 1, 1])
    roll = np.arctan2(-matrix[..., 2, 0], matrix[..., 2, 2])
    combined = np.arctan2(matrix[..., 1, 0], matrix[..., 0, 0])
    return Attitude(
        heading=np.where(separable, heading, combined),
        pitch=np.arctan2(matrix[..., 2, 1], level),
        roll=np.where(separable, roll, 0.0),
        separable=separable,
    )


def to_navigation(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """East, North, Up components (…, 3) of body vectors (…, 3), eq. (B.2)."""
    return np.einsum("...ij,...j->...i", matrix, vector)
