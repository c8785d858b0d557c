"""“As the specification's example”: Appendix A of JJF 2003-2022 and of JJF 1536-2015.

Both appendices write down the law of propagation and then do something else: three components,
u₁ of the table, u₂ of the data acquisition, u₃ of the repeatability, added in quadrature with
sensitivity 1 whatever their units, where u₃ is the plain sum of the positions' uncertainties.

One chain of roundings gives every printed number: u_c is rounded half-even to three significant
digits, U = 2·u_c is taken from that, and rounded up to two digits (2.20165e-4 → 2.20e-4 →
4.40e-4 → 4.4e-4; without the first step 4.4033e-4 would be 4.5e-4). JJF 2003, A.2.4 alone
prints U before the last step (5.36e-4).
"""

import math
from collections.abc import Sequence
from decimal import Decimal

from schemas.uncertainty import Budget
from tasks.uncertainty.budget import Contribution, InputQuantity, combine
from tasks.uncertainty.propagation import TWO_SIGMA
from tasks.words import message

TABLE = 1.0e-4  # u₁: U = 2e-4 with k = 2
EXAMPLE = "Appendix A"  # who states that
BITS = 12  # N of the examples; a unit under test has its own
TABLE_NAME = message("uncertainty-example-table")
ACQUISITION_NAME = message("uncertainty-example-acquisition")
REPEATABILITY_NAME = message("uncertainty-example-repeatability")
K = 2.0
DIGITS_OF_U_C = 3


def acquisition(bits: float) -> float:
    """u₂ = 2⁻ᴺ/√3 for N effective bits, eq. (A.3): the whole step taken as half-width."""
    return 2.0**-bits / math.sqrt(3.0)


def combine_as_example(
    result: str,
    unit: str,
    value: float,
    repeatability: Sequence[float],
    table: float = TABLE,
    bits: float = BITS,
    source: str = EXAMPLE,
) -> Budget:
    """A budget as the appendices do it: u_c = √(u₁² + u₂² + u₃²), U = 2·u_c.

    repeatability: standard uncertainties that are added up to u₃. source: who states `table`.
    u_c carries three significant digits, so that a certificate prints the appendix's U (rounded up
    to two digits).
    """
    u3 = math.fsum(repeatability)
    quantities = (
        InputQuantity("u1", TABLE_NAME, unit, table, "B", "normal", source=source),
        InputQuantity("u2", ACQUISITION_NAME, unit, acquisition(bits), "B", "rectangular"),
        InputQuantity("u3", REPEATABILITY_NAME, unit, u3, "A", "normal"),
    )
    exact = combine(result, unit, value, [Contribution(quantity, 1.0) for quantity in quantities])
    u_c = float(f"{exact.u_c:.{DIGITS_OF_U_C - 1}e}")
    # The decimal product: 2 × 2.2e-4 must not be a hair above 4.4e-4.
    return exact.model_copy(
        update={
            "u_c": u_c,
            "k": K,
            "U": float(Decimal(repr(u_c)) * Decimal(K)),
            "coverage_probability": TWO_SIGMA,
            "half_width_95": None,
            "evaluation": "as the specification's example",
        }
    )
