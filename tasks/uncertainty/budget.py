"""Budgets of linear combinations of input quantities by the law of propagation."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from schemas.base import Unusable
from schemas.uncertainty import Budget, BudgetInput, Correlation, Distribution, Kind
from tasks.uncertainty.coverage import half_width
from tasks.uncertainty.propagation import (
    TWO_SIGMA,
    checked_correlation,
    coverage_factor,
    effective_dof,
    variance_terms,
)
from tasks.words import Message, message, texts


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
    kind: Kind
    distribution: Distribution
    estimate: float = 0.0
    dof: float = math.inf
    sample: str | None = None
    half_width: float | None = None
    source: str | None = None


@dataclass(frozen=True)
class Contribution:
    """An input quantity and its sensitivity coefficient c = ∂y/∂x (result unit per own unit)."""

    quantity: InputQuantity
    sensitivity: float

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
    shapes = [(q.distribution, abs(x), q.dof) for q, x in zip(quantities, c * u, strict=True)]
    shares = terms / variance if variance > 0.0 else np.zeros(len(terms))
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
            for i, j in zip(*np.nonzero(np.triu(r, 1)), strict=True)
        ),
        u_c=u_c,
        dof=dof,
        k=k,
        coverage_probability=probability,
        U=k * u_c,
        half_width_95=None if (r != np.eye(len(r))).any() else half_width(shapes),
    )


def observed(u: float, unit: str, dof: float = math.inf) -> Contribution:
    """The type A line of a standard uncertainty that was itself observed."""
    distribution: Distribution = "normal" if math.isinf(dof) else "t"
    name = message("uncertainty-repeatability")
    quantity = InputQuantity("u_A", name, unit, u, "A", distribution, dof=dof)
    return Contribution(quantity, 1.0)


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
