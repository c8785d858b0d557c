"""The uncertainty budget of one result: inputs, sensitivities, combined and expanded
uncertainty.
"""

import math
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, PlainSerializer

from schemas.base import Finite, Frozen
from schemas.text import AnyMessage

Kind = Literal["A", "B"]
Distribution = Literal["normal", "rectangular", "triangular", "arcsine", "t"]
Evaluation = Literal["GUM", "as the specification's example", "Monte Carlo"]


Dof = Annotated[
    float,
    Field(ge=1),
    BeforeValidator(lambda dof: math.inf if dof is None else dof),
    PlainSerializer(
        lambda dof: None if math.isinf(dof) else dof, return_type=float | None, when_used="json"
    ),
]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]


class BudgetInput(Frozen):
    """One line of a budget: an input quantity and what it does to the result.

    `u` is in the input's own unit, `contribution` = |sensitivity|·u in the result's unit.
    `share` of the variance: cᵢ·u(xᵢ, y)/u²(y), with u(xᵢ, y) = Σⱼ cⱼ·u(xᵢ, xⱼ). Without
    correlation it is (cᵢuᵢ)²/u²(y); with it, half of each covariance term goes to either input,
    so that the shares always add up to 1 and one may be negative (the input compensates
    another). Where the result has no uncertainty every share is 0. A limit of the equipment has
    its `half_width`, in `unit`, and the `source` that states it.
    """

    name: str
    name_zh: str
    name_message: AnyMessage = None
    symbol: str
    kind: Kind
    distribution: Distribution
    u: NotNegative
    unit: str
    dof: Dof = Field(default=math.inf, description="degrees of freedom; null: infinitely many")
    sensitivity: Finite
    contribution: NotNegative
    share: Finite
    half_width: NotNegative | None = None
    source: str | None = None


class Correlation(Frozen):
    """A non-zero correlation coefficient between two inputs, given by their symbols."""

    first: str
    second: str
    r: Annotated[float, Field(ge=-1, le=1)]


class Budget(Frozen):
    """The uncertainty budget of one result, in the result's unit.

    U = k·u_c. `half_width_95`: half width of the interval that holds the result with 95 %
    probability by propagation of the distributions of this linear budget (JCGM 101); null where
    inputs are correlated, or where the budget is not one of distributions. `coverage_interval`
    is stated where it need not be value ± U (Monte Carlo); U is then half its length.
    """

    result: str
    unit: str
    value: Finite
    inputs: tuple[BudgetInput, ...]
    correlations: tuple[Correlation, ...] = ()
    u_c: NotNegative
    dof: Dof = Field(
        default=math.inf, description="effective degrees of freedom; null: infinitely many"
    )
    k: NotNegative
    coverage_probability: Annotated[float, Field(gt=0, lt=1)]
    U: NotNegative
    half_width_95: NotNegative | None = None
    evaluation: Evaluation = "GUM"
    coverage_interval: tuple[Finite, Finite] | None = None
