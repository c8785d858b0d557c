"""The two steps of the joint method, as operators on the segment means.

Step 1: least squares on the simplified model (scale factor times installation error, and bias)
over all dynamic and static samples, weighted by the inverse of their covariance: what drifts
together counts less than its number of samples. The simplified model K_i·(ω_i + ε_ij·ω_j) + B_i
is linear in K_ij = K_i·ε_ij, and the smallest sum of squares is the same in either form, so the
non-linear problem is solved exactly. Step 2, the zero correction: bias and g-sensitivity of the
theoretical model from the rests, with step 1 put in; then step 1 again with the g-sensitivity
taken off. At rest nothing turns, so that step 2 does not feel step 1 but through Earth's
rotation, which the caller takes off round by round until nothing changes. Terms beyond the
standard's are fitted in both steps.

An operator is kept, and not only its values: each uncertainty of the equipment goes through it.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from tasks.specifications.linear import RANK_TOLERANCE, BirgeRatio, Solution, birge_ratio, solve

QUIETEST = 0.1  # of the median variance
TINY = 1e-9  # of a variance: keeps a covariance that drift or tilt alone makes invertible
Role = Literal["dynamic", "bias", "g-sensitivity", "further"]


@dataclass(frozen=True)
class Solved:
    """Parameters as combinations of the means.

    operator: (p, n), NaN rows for parameters that the segments do not determine.
    excess: for each parameter, how much more its samples scatter than their noise.
    """

    operator: np.ndarray
    excess: tuple[BirgeRatio, ...]


def least_squares(
    design: np.ndarray, used: np.ndarray, means: np.ndarray, covariance: np.ndarray
) -> Solved:
    """Means fitted over the used segments, by generalised least squares.

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
    design: np.ndarray,
    roles: tuple[Role, ...],
    used: np.ndarray,
    zero: np.ndarray,
    means: np.ndarray,
    covariance: np.ndarray,
) -> Solved:
    """Both steps for means (n,); design: (n, p), its columns with their roles.

    used: (n,) bool, the dynamic and static segments; zero: (n,) bool, the rests of step 2, where
    bias and g-sensitivity are estimated beside the further columns. If no rest determines the
    g-sensitivity it is not subtracted, and the bias is not determined. Without a column to correct,
    step 1 is all.
    """
    role = np.array(roles)
    rest, g = np.isin(role, ("bias", "g-sensitivity", "further")), role == "g-sensitivity"
    corrected = rest & (role != "further")
    if not corrected.any():
        return least_squares(design, used, means, covariance)
    at_rest = least_squares(design[:, rest], zero, means, covariance)
    operator = np.full(design.T.shape, np.nan)
    operator[rest] = at_rest.operator
    # A reading with what gravity does to it taken off.
    reduced = np.eye(len(means)) - design[:, g] @ np.nan_to_num(operator[g])
    spread = reduced @ covariance @ reduced.T
    first = least_squares(design[:, ~g], used, reduced @ np.nan_to_num(means), spread)
    by_all = np.full(design.T.shape, np.nan)
    by_all[~g] = first.operator @ reduced
    operator[~corrected] = by_all[~corrected]
    excess = BirgeRatio()
    if used.any():
        undetermined = g & ~np.isfinite(operator).all(axis=1)
        # Where no rest gives the bias, residuals are about that of step 1.
        whole = np.where(np.isfinite(operator).all(axis=1)[:, None], operator, by_all)
        solution = Solution(np.nan_to_num(whole[:, used]), np.ones(len(role), bool))
        block = covariance[np.ix_(used, used)]
        shown = np.where(undetermined, 0.0, design)[used]
        excess = birge_ratio(solution, shown, means[used], block)
    ratios = np.full(len(role), excess, dtype=object)
    ratios[corrected] = at_rest.excess[0]
    return Solved(operator, tuple(ratios))


def _generalised(design: np.ndarray, covariance: np.ndarray) -> Solution:
    """Least squares in the norm of the covariance (n, n).

    No mean counts as if its variance were below a tenth of the usual one: a channel that stood
    still is not the truth.
    """
    variance = np.diag(covariance)
    floor = QUIETEST * np.median(variance) or 1.0
    raised = np.maximum(variance, floor)
    root = np.linalg.cholesky(covariance + np.diag(raised - variance + TINY * raised))
    basis, estimable = _determined(design)
    whitened = solve(np.linalg.solve(root, design @ basis))
    operator = basis @ np.linalg.solve(root.T, whitened.operator.T).T
    return Solution(operator, estimable)


def _determined(design: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Combinations (p, r) of parameters that a design (n, p) determines; (p,) bool, which alone.

    Of the design itself: whitening by a nearly singular covariance loses the digits.
    """
    scale = np.linalg.norm(design, axis=0)
    scale[scale == 0] = 1.0
    _, sizes, rows = np.linalg.svd(design / scale, full_matrices=False)
    kept = rows[sizes > RANK_TOLERANCE * sizes.max(initial=0.0)]
    if len(kept) == design.shape[1]:
        return np.eye(len(kept)), np.ones(len(kept), bool)
    return kept.T / scale[:, None], np.abs((kept**2).sum(axis=0) - 1.0) < 1e-6
