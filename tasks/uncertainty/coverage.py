"""The coverage interval of a linear budget by propagation of distributions, without random draws.

JCGM 101:2008 (JJF 1059.2-2012) asks for the distribution of y = Σ cᵢXᵢ. For independent inputs
that are symmetric about their estimates its characteristic function is the product of theirs,
φ(t) = Π φᵢ(cᵢt), and the probability within ± x is (2/π)∫ φ(t)·sin(tx)/t dt (Gil-Pelaez, 1951).
"""

import math
from collections.abc import Sequence
from functools import cache

import numpy as np

from schemas.uncertainty import Distribution
from tasks.uncertainty.distributions import NEGLIGIBLE, characteristic_function

PROBABILITY = 0.95
SMOOTHING = 0.005  # of u_c, where no input is normal: moves the interval by less than 0.1 %
FADED = 16.0  # over the standard deviation of what is normal or t: nothing is left of it there
LAST = 4.0 / SMOOTHING  # where the smoothing alone leaves 3e-4 of the characteristic function
MAX_STEPS = 60  # of Newton or of halving


def half_width(
    shapes: Sequence[tuple[Distribution, float, float]], probability: float = PROBABILITY
) -> float:
    """Half width x of the interval y ± x that holds the result with a probability.

    shapes: for each input its distribution, |cᵢ|·uᵢ (for `t` the scale s/√n of JCGM 101, 6.4.9)
    and its degrees of freedom; independent of each other. Zero without any uncertainty.
    """
    known = [(kind, size, dof) for kind, size, dof in shapes if size > 0.0]
    scale = math.sqrt(math.fsum(size**2 for _, size, _ in known))
    if scale == 0.0:
        return 0.0
    t, weight = _nodes()
    round_part = math.fsum(size**2 for kind, size, _ in known if kind in ("normal", "t"))
    if round_part > 0.0:
        near = t < FADED * scale / math.sqrt(round_part)
        t, weight = t[near], weight[near]
    phi = np.exp(-0.5 * max(SMOOTHING**2 - round_part / scale**2, 0.0) * t**2)
    for kind, size, dof in known:
        if kind != "t":
            phi = phi * characteristic_function(kind, size / scale * t, dof)
    keep = np.flatnonzero(np.abs(phi) > NEGLIGIBLE)  # Student's t takes longest
    t, weight, phi = t[keep], weight[keep], phi[keep]
    for kind, size, dof in known:
        if kind == "t":
            phi = phi * characteristic_function(kind, size / scale * t, dof)
    return scale * _solve(t, weight * phi / t, weight * phi, probability)


@cache
def _nodes() -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre nodes and weights on panels of [0, LAST], times 2/π.

    The panels are narrow next to zero, where Student's t of few degrees of freedom has no
    derivatives, and as wide as the oscillation allows elsewhere.
    """
    near_zero, middle = (0.0, 0.05, 0.2, 0.5), np.arange(1.0, 10.0)
    edges = np.concatenate([near_zero, middle, np.arange(10.0, LAST + 2.0, 2.0)])
    nodes, weights = np.polynomial.legendre.leggauss(12)
    half = np.diff(edges)[:, None] / 2.0
    t = edges[:-1, None] + half * (1.0 + nodes)
    return t.ravel(), (2.0 / math.pi * half * weights).ravel()


def _solve(t: np.ndarray, cumulative: np.ndarray, density: np.ndarray, probability: float) -> float:
    """The x at which Σ cumulative·sin(tx) is the probability: Newton, kept between bounds."""
    low, high, x = 0.0, math.inf, 1.96
    for _ in range(MAX_STEPS):
        excess = float(cumulative @ np.sin(t * x)) - probability
        low, high = (low, x) if excess > 0.0 else (x, high)
        slope = float(density @ np.cos(t * x))
        step = x - excess / slope if slope > 0.0 else math.nan
        if abs(step - x) < 1e-9 * x:
            return step
        middle = 0.5 * (low + high) if math.isfinite(high) else 2.0 * x
        x = step if low < step < min(high, 2.0 * low + 2.0) else middle
    return x
