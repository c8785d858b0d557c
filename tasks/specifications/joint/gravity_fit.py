"""Accelerometers calibrated by gravity alone: |K⁻¹·(a − B)| = g in every rest, at any attitude.

Source: Tedaldi, Pretto and Menegatti, “A robust and easy to implement method for IMU calibration
without external equipments”, ICRA 2014, eq. (10); the body axes as in `joint.gravity_alone`.
"""

from dataclasses import dataclass

import numpy as np

from tasks.specifications.linear import BirgeRatio, Solution, birge_ratio

UPPER = tuple((i, j) for i in range(3) for j in range(i, 3))
FEWEST_RESTS = 12  # nine parameters, and some rests to contradict them
TIGHT = 1e-15  # of cost, step and gradient: to the last digit
CONDITION = 1e4  # of the scaled equations: beyond it the attitudes do not tell the parameters apart


@dataclass(frozen=True)
class GravityFit:
    """Nine accelerometer parameters from rests.

    matrix: K (3, 3), upper triangular; bias: (3,) m/s².
    felt: (n, 3) specific force K⁻¹(a − B) of each rest; misses: (n,) its size less gravity, m/s².
    operator: (9, n, 3), how the parameters (K in the order of UPPER, then the bias) follow each
    mean reading; by_gravity: (9,) how they follow gravity.
    excess: how much more the misses scatter than the noise of the means explains.
    """

    matrix: np.ndarray
    bias: np.ndarray
    felt: np.ndarray
    misses: np.ndarray
    operator: np.ndarray
    by_gravity: np.ndarray
    excess: BirgeRatio


def fit_gravity(means: np.ndarray, gravity: float, noise: np.ndarray) -> GravityFit | None:
    """Fit K and B to the mean readings (n, 3) m/s² of rests; None where they do not determine them.

    noise: (3, n, n) covariance of the means of each channel. Levenberg and Marquardt from an
    ideal unit.
    """
    from scipy.optimize import least_squares  # late: most rests have a label

    if len(means) < FEWEST_RESTS:
        return None
    start = np.append([float(i == j) for i, j in UPPER], np.zeros(3))
    solved = least_squares(
        lambda values: _equations(values, means, gravity)[1],
        start,
        jac=lambda values: _equations(values, means, gravity)[2],
        method="lm", x_scale="jac", ftol=TIGHT, xtol=TIGHT, gtol=TIGHT,
    )  # fmt: skip
    felt, misses, slopes = _equations(solved.x, means, gravity)
    scale = np.linalg.norm(slopes, axis=0)
    if not solved.success or not np.linalg.cond(slopes / np.where(scale, scale, 1.0)) < CONDITION:
        return None
    follow = np.linalg.pinv(slopes)
    readout = -slopes[:, 6:]  # d miss/d reading: what it does to the bias, the other way
    spread = sum(readout[:, c, None] * noise[c] * readout[None, :, c] for c in range(3))
    solution = Solution(follow, np.ones(9, bool))
    return GravityFit(
        matrix=_matrix(solved.x),
        bias=solved.x[6:],
        felt=felt,
        misses=misses,
        operator=-follow[:, :, None] * readout[None],
        by_gravity=follow.sum(axis=1),
        excess=birge_ratio(solution, slopes, misses, np.asarray(spread)),
    )


def _matrix(values: np.ndarray) -> np.ndarray:
    matrix = np.zeros((3, 3))
    matrix[tuple(zip(*UPPER, strict=True))] = values[:6]
    return matrix


def _equations(
    values: np.ndarray, means: np.ndarray, gravity: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Specific force (n, 3), misses (n,) and their derivatives (n, 9) by the parameters (9,)."""
    inverse = np.linalg.inv(_matrix(values))
    felt = (means - values[6:]) @ inverse.T
    size = np.linalg.norm(felt, axis=1)
    back = felt / size[:, None] @ inverse  # (K⁻ᵀ·f/|f|) of each rest
    slopes = np.column_stack([*(-back[:, i] * felt[:, j] for i, j in UPPER), -back])
    return felt, size - gravity, slopes
