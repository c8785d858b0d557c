"""The law of propagation of uncertainty, on arrays.

Sources: GUM (JCGM 100:2008) 5.1.2, 5.2.2, G.4 and G.6; JJF 1059.1-2012, 4.4 and 4.5; for
correlated inputs of finite degrees of freedom R. Willink, Metrologia 44 (2007) 340-349, 4.1.
"""

import math
from collections.abc import Sequence

import numpy as np

from schemas.base import Unusable

TWO_SIGMA = math.erf(math.sqrt(2.0))  # 95.45 %: k = 2 for a normal distribution
NOISE = 1e-9  # rounding error allowed for in degrees of freedom and in correlations


def variance_terms(contributions: np.ndarray, correlation: np.ndarray) -> np.ndarray:
    """cᵢuᵢ·Σⱼ rᵢⱼcⱼuⱼ for each input, (n,): they add up to u_c², GUM eq. (16).

    contributions: (n,) cᵢuᵢ with its sign; correlation: (n, n).
    """
    return contributions * (correlation @ contributions)


def effective_dof(
    contributions: np.ndarray,
    correlation: np.ndarray,
    dof: Sequence[float],
    samples: Sequence[str | None],
) -> float:
    """Effective degrees of freedom, Welch-Satterthwaite: GUM eq. (G.2b).

    The formula is for independent components. Inputs estimated from one sample of simultaneous
    observations (equal names in `samples`, equal degrees of freedom, any correlation) therefore
    count as one component, with their covariances in its variance (Willink 2007, 4.1). Inputs of
    infinitely many degrees of freedom may be correlated with each other: they add nothing.
    Any other correlation has no known effective degrees of freedom and is refused. GTC does the
    same (`multiple_ureal`, `set_correlation`).

    Raises Unusable for a correlation that is refused, or one sample with two numbers of degrees
    of freedom. Without any variance the result is infinite.
    """
    degrees = np.asarray(dof, float)
    _refuse_what_has_no_dof(correlation, degrees, samples)
    total = float(variance_terms(contributions, correlation).sum())
    if total <= 0.0:
        return math.inf
    alone = [i for i, sample in enumerate(samples) if sample is None]
    weight = float(((contributions[alone] ** 2 / total) ** 2 / degrees[alone]).sum())
    for sample in dict.fromkeys(sample for sample in samples if sample is not None):
        members = [i for i, each in enumerate(samples) if each == sample]
        numbers = sorted(set(degrees[members].tolist()))
        if len(numbers) > 1:
            raise Unusable(
                f"the inputs of the sample “{sample}” have {numbers} degrees of freedom; inputs "
                "observed together have one number: give each the same"
            )
        block = np.ix_(members, members)
        part = variance_terms(contributions[members], correlation[block]).sum() / total
        weight += part**2 / degrees[members[0]]
    return 1.0 / weight if weight > 0.0 else math.inf


def coverage_factor(dof: float, probability: float = TWO_SIGMA) -> float:
    """k for a coverage probability: Student's t, GUM G.3 and G.6.4.

    Degrees of freedom that are not an integer are truncated to the next lower one (GUM G.4.1;
    the other choice there, interpolation, gives a smaller k). Infinitely many give the normal
    distribution's factor: 2 for 95.45 %.
    """
    from scipy.special import ndtri, stdtrit

    upper = (1.0 + probability) / 2.0
    if math.isinf(dof):
        return round(float(ndtri(upper)), 12)
    return float(stdtrit(max(math.floor(dof * (1.0 + NOISE)), 1), upper))


def checked_correlation(correlation: np.ndarray | None, count: int) -> np.ndarray:
    """A correlation matrix (count, count); the unit matrix for None.

    Coefficients below 1e-9 are rounding noise and become zero. Raises Unusable unless it is
    symmetric, with ones on its diagonal and no negative variance.
    """
    if correlation is None:
        return np.eye(count)
    r = np.asarray(correlation, float)
    if r.shape != (count, count):
        raise Unusable(
            f"the correlation matrix is {r.shape}; {count} inputs need {count} × {count}"
        )
    if not (np.allclose(r, r.T) and np.allclose(np.diag(r), 1.0)):
        raise Unusable("the correlation matrix must be symmetric with ones on its diagonal")
    smallest = float(np.linalg.eigvalsh(r)[0]) if count else 0.0
    if smallest < -1e-6:
        raise Unusable(
            f"the correlation matrix has the eigenvalue {smallest:.3g}, so some combination would "
            "have a negative variance; correct the coefficients"
        )
    return np.where(np.abs(r) < NOISE, 0.0, r)


def _refuse_what_has_no_dof(
    correlation: np.ndarray, dof: np.ndarray, samples: Sequence[str | None]
) -> None:
    for i, j in np.argwhere(correlation).tolist():
        together = samples[i] is not None and samples[i] == samples[j]
        if i < j and not together and not (math.isinf(dof[i]) and math.isinf(dof[j])):
            raise Unusable(
                f"inputs {i + 1} and {j + 1} are correlated with {dof[i]:g} and {dof[j]:g} degrees "
                "of freedom but not of one sample, for which no effective degrees of freedom are "
                "known; name the sample they were observed in, or use Monte Carlo"
            )
