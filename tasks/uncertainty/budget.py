"""Budgets of linear combinations of input quantities by the law of propagation."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from schemas.base import Unusable
from schemas.calibration import Budget, BudgetInput, Correlation, Distribution, EvaluationType
from tasks.segments.summarise import cosine_and_sine
from tasks.uncertainty.propagation import (
    TWO_SIGMA,
    checked_correlation,
    coverage_factor,
    effective_dof,
    variance_terms,
)
from tasks.uncertainty.type_a import NEGLIGIBLE, characteristic_function
from tasks.words import Message, message, texts

PROBABILITY = 0.95
TWO_DRAWS = (1.5, 2.5)  # between them a sum counts as one of two draws
SMOOTHING = 0.005  # of u_c, where no input is normal: moves the interval by less than 0.1 %
FADED = 16.0  # over the standard deviation of what is normal or t: nothing is left of it there
LAST = 4.0 / SMOOTHING  # where the smoothing alone leaves 3e-4 of the characteristic function
MAX_STEPS = 60  # of Newton or of halving


# The coverage interval of a linear budget by propagation of distributions, without random draws.
#
# JCGM 101:2008 (JJF 1059.2-2012) asks for the distribution of y = Σ cᵢXᵢ. For independent inputs
# that are symmetric about their estimates its characteristic function is the product of theirs,
# φ(t) = Π φᵢ(cᵢt), and the probability within ± x is (2/π)∫ φ(t)·sin(tx)/t dt (Gil-Pelaez, 1951).


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
        near = np.searchsorted(t, FADED * scale / math.sqrt(round_part))
        t, weight = t[:near], weight[:near]
    phi = np.exp(-0.5 * max(SMOOTHING**2 - round_part / scale**2, 0.0) * t**2)
    for shape in dict.fromkeys(kind for kind, _, _ in known if kind != "t"):
        sizes = [size / scale for kind, size, _ in known if kind == shape]
        phi = phi * characteristic_function(shape, np.outer(sizes, t)).prod(axis=0)
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
        cosine, sine = cosine_and_sine(t * x)
        excess = float(cumulative @ sine) - probability
        low, high = (low, x) if excess > 0.0 else (x, high)
        slope = float(density @ cosine)
        step = x - excess / slope if slope > 0.0 else math.nan
        if abs(step - x) < 1e-6 * x:  # what is left of it is about its square
            return step
        middle = 0.5 * (low + high) if math.isfinite(high) else 2.0 * x
        x = step if low < step < min(high, 2.0 * low + 2.0) else middle
    return x


@dataclass(frozen=True)
class InputQuantity:
    """An input quantity X: its best estimate and standard uncertainty, in its own unit.

    dof: degrees of freedom. For the distribution `t`, u is s/√n and dof is n − 1.
    sample: a name common to inputs that were observed together (see `effective_dof`).
    half_width, source: of a limit, and who states it.
    """

    symbol: str
    name: Message | str
    unit: str
    u: float
    kind: EvaluationType
    distribution: Distribution
    estimate: float = 0.0
    dof: float = math.inf
    sample: str | None = None
    half_width: float | None = None
    source: str | None = None


@dataclass(frozen=True)
class Contribution:
    """An input quantity and its sensitivity coefficient c = ∂y/∂x (result unit per own unit).

    draws: how many independent draws of the quantity, as if of equal weight, make up the
    contribution; c is then the root of the sum of the squares of theirs.
    """

    quantity: InputQuantity
    sensitivity: float
    draws: float = 1.0

    @property
    def distribution(self) -> Distribution:
        """Of the contribution: the sum of two rectangular ones is triangular, of more normal."""
        if self.draws > TWO_DRAWS[1]:
            return "normal"
        twice = self.draws > TWO_DRAWS[0] and self.quantity.distribution == "rectangular"
        return "triangular" if twice else self.quantity.distribution

    def scaled(self, factor: float) -> "Contribution":
        """The same contribution to a result in another unit, or multiplied by a factor."""
        return replace(self, sensitivity=self.sensitivity * factor)


def combine(
    result: str,
    unit: str,
    value: float,
    contributions: Sequence[Contribution],
    correlation: np.ndarray | None = None,
    probability: float = TWO_SIGMA,
) -> Budget:
    """The budget of a result that is linear in its inputs, or was made linear.

    u_c² = ΣΣ cᵢcⱼrᵢⱼuᵢuⱼ (GUM eq. (16)), effective degrees of freedom by Welch-Satterthwaite,
    k from Student's t, U = k·u_c. correlation: (n, n), None: all inputs independent.
    Raises Unusable for two inputs of one symbol, a matrix that is no correlation, or a
    correlation for which no effective degrees of freedom are known.
    """
    quantities = [contribution.quantity for contribution in contributions]
    _refuse_equal_symbols(quantities)
    c = np.array([contribution.sensitivity for contribution in contributions], float)
    u = np.array([quantity.u for quantity in quantities], float)
    r = checked_correlation(correlation, len(quantities))
    terms = variance_terms(c * u, r)
    variance = max(float(terms.sum()), 0.0)
    dof = effective_dof(c * u, r, [q.dof for q in quantities], [q.sample for q in quantities])
    k, u_c = coverage_factor(dof, probability), math.sqrt(variance)
    shapes = [
        (each.distribution, abs(x), each.quantity.dof)
        for each, x in zip(contributions, c * u, strict=True)
    ]
    shares = terms / variance if variance > 0.0 else np.zeros(len(terms))
    correlated = [(i, j) for i, j in np.argwhere(r).tolist() if i < j]
    return Budget(
        result=result,
        unit=unit,
        value=value,
        inputs=tuple(
            _line(contribution, share)
            for contribution, share in zip(contributions, shares, strict=True)
        ),
        correlations=tuple(
            Correlation(first=quantities[i].symbol, second=quantities[j].symbol, r=float(r[i, j]))
            for i, j in correlated
        ),
        u_c=u_c,
        dof=dof,
        k=k,
        coverage_probability=probability,
        U=k * u_c,
        half_width_95=None if correlated else half_width(shapes),
    )


def observed(u: float, unit: str, dof: float = math.inf) -> Contribution:
    """The type A line of a standard uncertainty that was itself observed."""
    distribution: Distribution = "normal" if math.isinf(dof) else "t"
    name = message("uncertainty-repeatability")
    quantity = InputQuantity("u_A", name, unit, u, "A", distribution, dof=dof)
    return Contribution(quantity, 1.0)


def resolution(half_width: float, unit: str, sensitivity: float) -> Contribution:
    """The unit's own resolution: readings rounded to a step, half-width step/2 (GUM F.2.2.1).

    sensitivity: ‖o‖ for means with the weights o that are each rounded by an error of their own.
    For a unit whose noise is above its step, averaging removes it and the type A line already
    holds it.
    """
    u = half_width / math.sqrt(3.0)
    name = message("uncertainty-resolution")
    quantity = InputQuantity("q", name, unit, u, "B", "rectangular")
    return Contribution(quantity, sensitivity)


def drift_in_run(shift: float) -> Contribution:
    """What the course of zero and gain over the run does to a value, in the value's unit.

    shift: by how much; it is not corrected, and so its own standard uncertainty.
    """
    name = message("uncertainty-drift-in-run")
    return Contribution(InputQuantity("d", name, "", shift, "A", "normal"), 1.0)


def _line(contribution: Contribution, share: float) -> BudgetInput:
    """A contribution as the line of a budget."""
    quantity = contribution.quantity
    name = texts(quantity.name)
    return BudgetInput(
        name=name["en"],
        name_zh=name["zh"],
        symbol=quantity.symbol,
        kind=quantity.kind,
        distribution=quantity.distribution,
        u=quantity.u,
        unit=quantity.unit,
        dof=quantity.dof,
        sensitivity=contribution.sensitivity,
        contribution=abs(contribution.sensitivity) * quantity.u,
        share=share,
        half_width=quantity.half_width,
        source=quantity.source,
    )


def _refuse_equal_symbols(quantities: Sequence[InputQuantity]) -> None:
    for symbol, count in Counter(quantity.symbol for quantity in quantities).items():
        if count > 1:
            raise Unusable(
                f"the budget has {count} inputs with the symbol {symbol}; give each its own"
            )
