"""The two steps of the joint method, as operators on the segment means.

Step 1: least squares on the simplified model (scale factor times installation error, and bias)
over all dynamic and static samples. The simplified model K_i·(ω_i + ε_ij·ω_j) + B_i is linear in
K_ij = K_i·ε_ij, and the smallest sum of squares is the same in either form, so the non-linear
problem is solved exactly. Step 2, the zero correction: bias and g-sensitivity of the theoretical
model from the rests, with step 1 put in; then step 1 again with the g-sensitivity taken off. At
rest nothing turns, so that step 2 does not feel step 1 but through Earth's rotation, which the
caller takes off round by round until nothing changes.
"""

from dataclasses import dataclass

import numpy as np

from tasks.items.linear import Solution, solve
from tasks.items.parts import Excess, excess_scatter


@dataclass(frozen=True)
class Solved:
    """Parameters of one channel as combinations of its segment means.

    operator: (p, n), NaN rows for parameters that the segments do not determine.
    excess: for each parameter, how much more its samples scatter than their noise.
    """

    operator: np.ndarray
    excess: tuple[Excess, ...]


def least_squares(
    design: np.ndarray, used: np.ndarray, samples: np.ndarray, means: np.ndarray, noise: np.ndarray
) -> Solved:
    """A channel fitted over the used segments, each counted with its samples.

    design: (n, p); used: (n,) bool; samples, means: (n,); noise: (n, n) covariance of the means.
    """
    solution = _weighted(design[used], samples[used])
    excess = Excess()
    if used.any():
        block = noise[np.ix_(used, used)]
        excess = excess_scatter(solution, design[used], means[used], block)
    operator = np.full((design.shape[1], len(used)), 0.0)
    operator[:, used] = solution.operator
    operator[~solution.estimable] = np.nan
    return Solved(operator, (excess,) * design.shape[1])


def zero_corrected(
    rates: np.ndarray,
    forces: np.ndarray,
    used: np.ndarray,
    zero: np.ndarray,
    samples: np.ndarray,
    means: np.ndarray,
    noise: np.ndarray,
) -> Solved:
    """One gyro: three elements of K, bias, three of the g-sensitivity, in this order.

    rates (n, 3) rad/s, forces (n, 3) in local g: the regressors. used: the dynamic and static
    segments; zero: the rests of step 2. Where no rest determines the g-sensitivity it is not
    taken off, and the bias is not determined.
    """
    ones = np.ones((len(means), 1))
    at_rest = least_squares(np.hstack([ones, forces]), zero, samples, means, noise)
    bias, sensitivity = at_rest.operator[:1], at_rest.operator[1:]
    known = np.nan_to_num(sensitivity)
    felt = np.eye(len(means)) - forces @ known  # a reading with what gravity does to it taken off
    spread = felt @ noise @ felt.T
    turning = least_squares(
        np.hstack([rates, ones]), used, samples, felt @ np.nan_to_num(means), spread
    )
    operator = np.vstack([turning.operator[:3] @ felt, bias, sensitivity])
    return Solved(operator, turning.excess[:3] + at_rest.excess)


def _weighted(design: np.ndarray, samples: np.ndarray) -> Solution:
    """Least squares in which each mean counts as often as it has samples."""
    root = np.sqrt(samples)
    solution = solve(design * root[:, None])
    return Solution(solution.operator * root, solution.estimable)
