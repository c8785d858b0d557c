"""Monte Carlo of one element (JCGM 101): its inputs drawn, through the item's own equation.

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
from tasks.specifications.measured import Measured
from tasks.uncertainty.budget import combine
from tasks.uncertainty.monte_carlo import monte_carlo, with_monte_carlo

RATES = ("ε1", "ε2", "ε3")  # relative errors of the table's rate
# Symbols of tasks.uncertainty.equipment that an item's divisor is made of, and its power.
DIVISORS = {
    "gyro_scale_factor": (RATES, 1),
    "gyro_cross_coupling": (RATES, 1),
    "accel_scale_factor": (("g",), 1),
    "accel_cross_coupling": (("g",), 1),
    "accel_rate_sensitivity": (RATES, 2),
    "ahrs_scale_factor": (RATES, 1),
    "ahrs_misalignment": (("α1", "α2"), 1),
}


def drawn(result: str, unit: str, found: Measured, seed: str) -> Budget:
    """The budget of one element with u, U and interval by Monte Carlo, to two figures of u.

    result: «item.element». seed: any text, the digest of the recording; the same text gives the
    same draws bit for bit, and every element its own.
    Raises Unusable where the draws do not settle.
    """
    lines = found.lines_in(unit)
    budget = combine(result, unit, found.value, lines)
    if budget.u_c == 0.0:
        return budget.model_copy(update={"evaluation": "Monte Carlo"})
    symbols, power = DIVISORS.get(result.partition(".")[0], ((), 1))
    divides = [bool(found.value) and line.quantity.symbol in symbols for line in lines]

    def equation(*errors: np.ndarray) -> np.ndarray:
        total, divisor = np.full_like(errors[0], found.value), np.ones_like(errors[0])
        for line, each, below in zip(lines, errors, divides, strict=True):
            if below:
                divisor -= line.sensitivity * each / (power * found.value)
            else:
                total += line.sensitivity * each
        return np.asarray(total / divisor**power)

    number = int.from_bytes(hashlib.sha256(f"{seed} {result}".encode()).digest()[:8])
    errors = [replace(line.quantity, estimate=0.0) for line in lines]
    return with_monte_carlo(budget, monte_carlo(equation, errors, seed=number))
