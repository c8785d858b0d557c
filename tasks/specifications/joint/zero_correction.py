"""The two steps of the joint method, as operators on the segment means.

Step 1: least squares on the simplified model (scale factor times installation error, and bias)
over all dynamic and static samples, weighted by the inverse of their covariance: what drifts
together counts less than its number of samples. The simplified model K_i·(ω_i + ε_ij·ω_j) + B_i
is linear in K_ij = K_i·ε_ij, and the smallest sum of squares is the same in either form, so the
non-linear problem is solved exactly. Step 2, the zero correction: bias and g-sensitivity of the
theoretical model from the rests, with step 1 put in; then step 1 again with the g-sensitivity
taken off. At rest nothing turns, so that step 2 does not feel step 1 but through Earth's
rotation, which the caller takes off round by round until nothing changes.
"""

from dataclasses import dataclass

import numpy as np

from tasks.specifications.linear import BirgeRatio, Solution, birge_ratio, solve

QUIETEST = 0.1  # of the median variance
TINY = 1e-9  # of a variance: keeps a covariance that drift or tilt alone makes invertible


@dataclass(frozen=True)
class Solved:
    """Parameters of one channel as combinations of its segment means.

    operator: (p, n), NaN rows for parameters that the segments do not determine.
    excess: for each parameter, how much more its samples scatter than their noise.
    """

    operator: np.ndarray
    excess: tuple[BirgeRatio, ...]


def least_squares(
    design: np.ndarray, used: np.ndarray, means: np.ndarray, covariance: np.ndarray
) -> Solved:
    """A channel fitted over the used segments, by generalised least squares.

    design: (n, p); used: (n,) bool; means: (n,); covariance: (n, n) of the means by noise and by
    what the equipment does to each.
    """
    operator = np.zeros((design.shape[1], len(used)))
    if not used.any():
        return Solved(operator * np.nan, (BirgeRatio(),) * design.shape[1])
    block = covariance[np.ix_(used, used)]
    solution = _generalised(design[used], block)
    excess = birge_ratio(solution, design[used], means[used], block)
    operator[:, used] = solution.operator
    operator[~solution.estimable] = np.nan
    return Solved(operator, (excess,) * design.shape[1])


def zero_corrected(
    rates: np.ndarray,
    forces: np.ndarray,
    used: np.ndarray,
    zero: np.ndarray,
    means: np.ndarray,
    covariance: np.ndarray,
) -> Solved:
    """One gyro: three elements of K, bias, three of the g-sensitivity, in this order.

    rates (n, 3) rad/s, forces (n, 3) in local g: the regressors. used: the dynamic and static
    segments; zero: the rests of step 2. Where no rest determines the g-sensitivity it is not
    taken off, and the bias is not determined.
    """
    ones = np.ones((len(means), 1))
    at_rest = least_squares(np.hstack([ones, forces]), zero, means, covariance)
    bias, sensitivity = at_rest.operator[:1], at_rest.operator[1:]
    known = np.nan_to_num(sensitivity)
    felt = np.eye(len(means)) - forces @ known  # a reading with what gravity does to it taken off
    spread = felt @ covariance @ felt.T
    turning = least_squares(np.hstack([rates, ones]), used, felt @ np.nan_to_num(means), spread)
    scale = turning.operator[:3] @ felt
    offset = bias if np.isfinite(bias).all() else turning.operator[3:] @ felt
    design = np.hstack([rates, ones, forces * np.isfinite(sensitivity).all(axis=1)])
    whole = np.nan_to_num(np.vstack([scale, offset, sensitivity]))
    excess = BirgeRatio()
    if used.any():
        solution = Solution(whole[:, used], np.ones(len(whole), bool))
        block = covariance[np.ix_(used, used)]
        excess = birge_ratio(solution, design[used], means[used], block)
    return Solved(np.vstack([scale, bias, sensitivity]), (excess,) * 3 + at_rest.excess)


def _generalised(design: np.ndarray, covariance: np.ndarray) -> Solution:
    """Least squares in the norm of the covariance (n, n).

    No mean counts as if its variance were below a tenth of the usual one: a channel that stood
    still is not the truth.
    """
    variance = np.diag(covariance)
    floor = QUIETEST * np.median(variance) or 1.0
    raised = np.maximum(variance, floor)
    root = np.linalg.cholesky(covariance + np.diag(raised - variance + TINY * raised))
    whitened = solve(np.linalg.solve(root, design))
    return Solution(np.linalg.solve(root.T, whitened.operator.T).T, whitened.estimable)
