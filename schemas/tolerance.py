"""Limits of a product model, and what a result is worth against them."""

from typing import Literal, Self

from pydantic import Field, model_validator

from schemas.base import Finite, Frozen

Verdict = Literal["pass", "fail", "inconclusive"]
Quantity = Literal["value", "value_without_earth_rotation", "value_model"]


class Limit(Frozen):
    """Limits on every element of an item (or the listed ones), in the item's own unit.

    lower and upper are signed; one alone is a one-sided limit. magnitude limits |value|.
    """

    item: str
    unit: str
    lower: Finite | None = None
    upper: Finite | None = None
    magnitude: Finite | None = Field(default=None, gt=0)
    elements: tuple[str, ...] | None = None
    applied_to: Quantity = "value"

    @model_validator(mode="after")
    def _limits_something(self) -> Self:
        if self.magnitude is not None and (self.lower is not None or self.upper is not None):
            raise ValueError(f"the limit on {self.item} has magnitude beside lower or upper")
        if self.magnitude is None and self.lower is None and self.upper is None:
            raise ValueError(f"the limit on {self.item} has no lower, upper or magnitude")
        if self.lower is not None and self.upper is not None and self.lower >= self.upper:
            raise ValueError(f"the limit on {self.item} has lower ≥ upper")
        return self


class Tolerance(Frozen):
    """The limits of one product model (a TOML or JSON file, format `mimu-tolerance/1`)."""

    format: Literal["mimu-tolerance/1"] = "mimu-tolerance/1"
    manufacturer: str
    model: str
    document: str = Field(description="where the limits come from, for the certificate")
    rule: Literal["simple_acceptance"] = "simple_acceptance"
    limits: tuple[Limit, ...] = Field(min_length=1)


def bounds(limit: Limit) -> tuple[float | None, float | None]:
    """Lower and upper limit, signed; None where there is none."""
    if limit.magnitude is not None:
        return -limit.magnitude, limit.magnitude
    return limit.lower, limit.upper


class LimitDecision(Frozen):
    """One element against one limit."""

    item: str
    element: str
    unit: str
    applied_to: Quantity
    value: Finite | None
    U: Finite | None
    lower: Finite | None
    upper: Finite | None
    verdict: Verdict


class Decision(Frozen):
    """The verdict on a unit, and what it rests on."""

    verdict: Verdict
    rule: str
    document: str | None
    limits: tuple[LimitDecision, ...]
    reasons: tuple[str, ...] = ()
    reasons_zh: tuple[str, ...] = ()
