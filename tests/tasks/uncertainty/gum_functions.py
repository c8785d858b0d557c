"""What the published examples need beside the product: budgets of functions, JCGM 101 clause 8."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from schemas.calibration import Budget
from tasks.uncertainty.budget import Contribution, InputQuantity, combine
from tasks.uncertainty.monte_carlo import Interval, numerical_tolerance
from tasks.uncertainty.propagation import TWO_SIGMA

STEP_OF_U, STEP_OF_X = 1e-2, 1e-4  # difference steps: of the uncertainty, of the estimate


def combine_function(
    result: str,
    unit: str,
    function: Callable[..., float],
    quantities: Sequence[InputQuantity],
    correlation: np.ndarray | None = None,
    probability: float = TWO_SIGMA,
) -> Budget:
    """The budget of y = f(x₁, …, xₙ), linearised at the estimates (GUM 5.1.2, 5.2.2).

    function: takes n numbers. Raises what `combine` raises.
    """
    x = np.array([quantity.estimate for quantity in quantities], float)
    u = np.array([quantity.u for quantity in quantities], float)
    c = sensitivities(function, x, u)
    contributions = [Contribution(q, float(ci)) for q, ci in zip(quantities, c, strict=True)]
    return combine(result, unit, float(function(*x)), contributions, correlation, probability)


def sensitivities(
    function: Callable[..., float], estimates: np.ndarray, u: np.ndarray
) -> np.ndarray:
    """∂f/∂xᵢ at the estimates, (n,), by central differences of fourth order.

    The step is a hundredth of u(xᵢ), or 1e-4 of |xᵢ| where that is more, so that neither
    curvature nor rounding is felt. GUM 5.1.3; its numerical form (5.1.4) steps by u itself.
    """
    steps = np.maximum(STEP_OF_U * u, STEP_OF_X * np.abs(estimates))
    steps[steps == 0.0] = STEP_OF_X
    slopes = np.zeros(len(estimates))
    for i, step in enumerate(steps):
        values = []
        for offset in (-2.0, -1.0, 1.0, 2.0):
            moved = estimates.copy()
            moved[i] += offset * step
            values.append(float(function(*moved)))
        slopes[i] = (values[0] - 8.0 * values[1] + 8.0 * values[2] - values[3]) / (12.0 * step)
    return slopes


@dataclass(frozen=True)
class Validation:
    """Whether the GUM's interval stands beside Monte Carlo: both distances ≤ δ (clause 8.1)."""

    d_low: float
    d_high: float
    tolerance: float

    @property
    def valid(self) -> bool:
        return self.d_low <= self.tolerance and self.d_high <= self.tolerance


def validate(budget: Budget, interval: Interval, digits: int = 1) -> Validation:
    """Compare y ± U of the law of propagation with an interval found by Monte Carlo (clause 8).

    The interval should be known better than δ/5 (8.2): from a run with one digit more.
    """
    assert math.isclose(budget.coverage_probability, interval.probability, rel_tol=1e-9)
    return Validation(
        d_low=abs(budget.value - budget.U - interval.low),
        d_high=abs(budget.value + budget.U - interval.high),
        tolerance=numerical_tolerance(budget.u_c, digits),
    )
