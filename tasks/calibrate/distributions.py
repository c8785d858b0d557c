"""Monte Carlo evaluation of one element (JCGM 101): inputs drawn and put through its equation.

Every item is a sum over its inputs, and some are divided by what the equipment states: a scale
factor by the rate, an accelerometer's by gravity, p by the square of the rate, a misalignment by
the angle turned. With the contributions cᵢδᵢ and the power n of the divisor

    y = (y₀ + Σ cᵢδᵢ)/(1 − Σ cⱼδⱼ/(n·y₀))ⁿ,

i over what is summed, j over what the divisor is made of: to first order the law of propagation.
"""

import hashlib
from dataclasses import replace

import numpy as np

from schemas.uncertainty import Budget
from tasks.specifications.estimate import Estimate
from tasks.specifications.items import ItemDefinition
from tasks.uncertainty.budget import combine
from tasks.uncertainty.monte_carlo import monte_carlo, with_monte_carlo


def monte_carlo_budget(item: ItemDefinition, element: str, estimate: Estimate, seed: str) -> Budget:
    """The budget of one element with u, U and interval by Monte Carlo, to two figures of u.

    seed: any text, the digest of the recording; the same text gives the same draws bit for bit,
    and every element its own.
    Raises Unusable where the draws do not settle.
    """
    result, value, lines = f"{item.key}.{element}", estimate.value, estimate.lines_in(item.unit)
    budget = combine(result, item.unit, value, lines)
    if budget.u_c == 0.0:
        return budget.model_copy(update={"evaluation": "Monte Carlo"})
    divides = [bool(value) and line.quantity.symbol in item.divisor for line in lines]

    def equation(*errors: np.ndarray) -> np.ndarray:
        total, divisor = np.full_like(errors[0], value), np.ones_like(errors[0])
        for line, error, below in zip(lines, errors, divides, strict=True):
            if below:
                divisor -= line.sensitivity * error / (item.power * value)
            else:
                total += line.sensitivity * error
        return np.asarray(total / divisor**item.power)

    number = int.from_bytes(hashlib.sha256(f"{seed} {result}".encode()).digest()[:8])
    errors = [replace(line.quantity, estimate=0.0) for line in lines]
    return with_monte_carlo(budget, monte_carlo(equation, errors, seed=number))
