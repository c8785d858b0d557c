"""The verdict on a unit: each value against its limit, and the risk of the decision."""

from typing import Annotated, Literal

from pydantic import Field

from schemas.base import Finite, Frozen
from schemas.text import Messages
from schemas.tolerance import Quantity, Rule

Verdict = Literal["pass", "fail", "inconclusive"]
Probability = Annotated[float, Field(ge=0, le=1)]


class GlobalRisks(Frozen):
    """Risks over a whole production measured with this uncertainty (JCGM 106, 9.5)."""

    consumer: Probability = Field(description="a unit does not conform and is accepted")
    producer: Probability = Field(description="a unit conforms and is rejected")


class LimitDecision(Frozen):
    """One element against one limit.

    A value is accepted between `accept_lower` and `accept_upper`, which are the limits moved
    inwards by the guard band. `marginal`: it was decided on and lies within U of a limit, or was
    accepted outside one, so the verdict is a conditional one (ILAC-G8:09/2019). The risk of the
    verdict is a probability of false acceptance for a pass, of false rejection for a fail.
    """

    item: str
    element: str
    unit: str
    applied_to: Quantity
    value: Finite | None
    U: Finite | None
    lower: Finite | None
    upper: Finite | None
    verdict: Verdict
    k: Finite | None = None
    nominal: Finite | None = Field(default=None, description="what relative limits count from")
    rule: Rule = "simple_acceptance"
    guard_band_factor: Finite = Field(default=0.0, description="r in w = r·U")
    accept_lower: Finite | None = None
    accept_upper: Finite | None = None
    capability: Finite | None = Field(default=None, description="C_m = T/(2·U)")
    min_capability: Finite | None = Field(default=None, description="C_m that the rule asks for")
    U_max: Finite | None = Field(default=None, description="U that the rule allows")
    marginal: bool = False
    probability_of_conformity: Probability | None = None
    false_acceptance: Probability | None = None
    false_rejection: Probability | None = None
    global_risks: GlobalRisks | None = None


class Decision(Frozen):
    """The verdict on a unit, and what it rests on.

    `marginal`: a pass that a limited element only just reaches, or a fail of which none is
    beyond doubt.
    """

    verdict: Verdict
    rule: str
    document: str | None
    limits: tuple[LimitDecision, ...]
    reasons: tuple[str, ...] = ()
    reasons_zh: tuple[str, ...] = ()
    reasons_message: Messages = ()
    marginal: bool = False
