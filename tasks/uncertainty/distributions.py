"""The distributions of input quantities: divisor, characteristic function, random draws.

GUM 4.3 (JJF 1059.1-2012, Table 3) and JCGM 101:2008, 6.4. All are symmetric about the estimate.
"""

import math

import numpy as np

from schemas.uncertainty import Distribution
from tasks.segments.one_pass import cosine_and_sine

# Half-width over standard uncertainty; a certificate's expanded uncertainty has k = 2.
DIVISORS = {
    "normal": 2.0,
    "rectangular": math.sqrt(3.0),
    "triangular": math.sqrt(6.0),
    "arcsine": math.sqrt(2.0),
}
NEGLIGIBLE = 1e-7  # of a characteristic function
NEARLY_NORMAL_DOF = 60.0  # from which a gamma variance moves the interval by 0.05 % at most
CHUNK = 60  # nodes that Student's t is worked out at before looking whether it has faded


def draw(
    distribution: Distribution, count: int, random: np.random.Generator, dof: float = math.inf
) -> np.ndarray:
    """Values (count,) with mean 0 and u = 1; `t` has scale 1 (6.4.9), so a larger deviation."""
    match distribution:
        case "normal":
            return random.standard_normal(count)
        case "t":
            return random.standard_t(dof, count)
        case "rectangular":
            values = random.uniform(-1.0, 1.0, count)
        case "triangular":
            values = random.triangular(-1.0, 0.0, 1.0, count)
        case "arcsine":
            values = np.sin(random.uniform(-math.pi, math.pi, count))
    return DIVISORS[distribution] * values


def characteristic_function(
    distribution: Distribution, s: np.ndarray, dof: float = math.inf
) -> np.ndarray:
    """φ at s > 0 of a distribution with standard uncertainty 1 (`t`: with scale 1)."""
    if distribution == "normal" or (distribution == "t" and math.isinf(dof)):
        return np.exp(-0.5 * s**2)
    if distribution == "t":
        return _student(s, dof)
    half_width = DIVISORS[distribution] * s
    if distribution == "rectangular":
        return np.asarray(cosine_and_sine(half_width)[1] / half_width)
    if distribution == "triangular":
        return (np.sin(0.5 * half_width) / (0.5 * half_width)) ** 2
    from scipy.special import j0

    return np.asarray(j0(half_width))


def _student(s: np.ndarray, dof: float) -> np.ndarray:
    if dof > NEARLY_NORMAL_DOF:  # normal with a variance ν/χ²: here gamma, of equal moments
        shape = (dof - 4.0) / 2.0
        return np.asarray((1.0 + dof / (dof - 2.0) / (2.0 * shape) * s**2) ** -shape)
    phi = np.zeros(len(s))
    for first in range(0, len(s), CHUNK):
        part = slice(first, first + CHUNK)
        phi[part] = _student_exactly(s[part], dof)
        if phi[part][-1] < NEGLIGIBLE:
            break
    return phi


def _student_exactly(s: np.ndarray, dof: float) -> np.ndarray:
    """K_{ν/2}(z)·z^{ν/2}/(Γ(ν/2)·2^{ν/2−1}) with z = √ν·s."""
    from scipy.special import gammaln, kve

    order, z = dof / 2.0, math.sqrt(dof) * s
    bessel = kve(order, z)
    finite = np.isfinite(bessel)  # it overflows next to zero, where the variance says it all
    phi = np.exp(-0.5 * dof / max(dof - 2.0, 1.0) * s**2)
    power = order * np.log(z[finite]) - z[finite] - gammaln(order) - (order - 1.0) * math.log(2.0)
    phi[finite] = bessel[finite] * np.exp(power)
    return phi
