"""The limits of a product model, and the decision rule for each."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from schemas.base import Frozen

Quantity = Literal["value", "value_without_earth_rotation", "value_model"]
Rule = Literal["simple_acceptance", "guard_band", "shared_risk"]
MAX = 1e9  # in any item's unit; its square must not overflow
Positive = Annotated[float, Field(gt=0, le=MAX, strict=True)]
Signed = Annotated[float, Field(ge=-MAX, le=MAX, strict=True)]
Factor = Annotated[float, Field(ge=-1, allow_inf_nan=False, strict=True)]

FACTOR = "r in w = r·U; below −1 a value wholly outside its limits would pass"
MIN_CAPABILITY = "smallest C_m = T/(2·U) at which a two-sided limit is decided on"


class ProductionPrior(Frozen):
    """Prior knowledge of the production: a normal distribution, in the limit's unit."""

    mean: Signed
    sd: Positive


class Limit(Frozen):
    """Limits on every element of an item (or the listed ones), in the item's own unit.

    lower and upper are signed; one alone is a one-sided limit. magnitude limits |value|. With
    `relative` the three are fractions of |nominal|, relative to the nominal: magnitude = 0.01 is ±1
    % of it. The decision rule is that of the file unless the limit has its own.
    """

    item: str
    unit: str
    lower: Signed | None = None
    upper: Signed | None = None
    magnitude: Positive | None = None
    relative: bool = False
    nominal: Signed | None = Field(default=None, description="in the unit; only if relative")
    elements: tuple[str, ...] | None = None
    applied_to: Quantity = "value"
    rule: Rule | None = None
    guard_band_factor: Factor | None = Field(default=None, description=FACTOR)
    min_capability: Positive | None = Field(default=None, description=MIN_CAPABILITY)
    U_max: Positive | None = Field(
        default=None,
        description="largest U, in the unit, at which the limit is decided on; a one-sided "
        "limit with neither this nor a guard band is decided on only where it is clear",
    )
    prior: ProductionPrior | None = Field(
        default=None, description="for the risks of the production"
    )

    @model_validator(mode="after")
    def _limits_something(self) -> Self:
        if self.magnitude is not None and (self.lower is not None or self.upper is not None):
            raise ValueError(f"the limit on {self.item} has magnitude beside lower or upper")
        if self.magnitude is None and self.lower is None and self.upper is None:
            raise ValueError(f"the limit on {self.item} has no lower, upper or magnitude")
        if self.lower is not None and self.upper is not None and self.lower >= self.upper:
            raise ValueError(f"the limit on {self.item} has lower ≥ upper")
        return self

    @model_validator(mode="after")
    def _relative_to_something(self) -> Self:
        if self.relative and not self.nominal:
            raise ValueError(f"the relative limit on {self.item} needs a nominal other than 0")
        if not self.relative and self.nominal is not None:
            raise ValueError(f"the limit on {self.item} has a nominal but is not relative")
        return self

    @property
    def bounds(self) -> tuple[float | None, float | None]:
        """Lower and upper limit, signed, in the limit's unit; None for a side without a limit."""
        if self.magnitude is not None:
            return self._from_nominal(-self.magnitude), self._from_nominal(self.magnitude)
        return self._from_nominal(self.lower), self._from_nominal(self.upper)

    def _from_nominal(self, given: float | None) -> float | None:
        """12 digits: 1.05 × 3.2 is 3.3600000000000003 in binary and stays 3.36."""
        if given is None or self.nominal is None:
            return given
        return float(f"{self.nominal + given * abs(self.nominal):.12g}")


class Tolerance(Frozen):
    """The limits of one product model (a TOML or JSON file, format `mimu-tolerance/1`).

    `rule`, `guard_band_factor` and `min_capability` hold for every limit that does not say
    otherwise.
    """

    format: Literal["mimu-tolerance/1"] = "mimu-tolerance/1"
    manufacturer: str
    model: str
    document: str = Field(description="where the limits come from, for the certificate")
    rule: Rule = "simple_acceptance"
    guard_band_factor: Factor | None = Field(default=None, description=FACTOR)
    min_capability: Positive | None = Field(default=None, description=MIN_CAPABILITY)
    limits: tuple[Limit, ...] = Field(min_length=1)

    @model_validator(mode="after")
    def _rules_are_complete(self) -> Self:
        """A factor needs a guard band; a shared risk needs its agreed bound on U."""
        if self.guard_band_factor is not None and not any(
            self.rule_of(limit) == "guard_band" for limit in self.limits
        ):
            raise ValueError("guard_band_factor is given, but no limit has the rule guard_band")
        for limit in self.limits:
            rule = self.rule_of(limit)
            if rule != "guard_band" and limit.guard_band_factor is not None:
                raise ValueError(
                    f"the limit on {limit.item} has a guard_band_factor but the rule {rule}"
                )
            if rule == "shared_risk" and limit.U_max is None and not self._has_capability(limit):
                raise ValueError(
                    f"the limit on {limit.item} shares the risk but no bound on U is agreed: give "
                    "U_max, or min_capability where it has two sides"
                )
        return self

    def _has_capability(self, limit: Limit) -> bool:
        agreed = limit.min_capability or self.min_capability
        return agreed is not None and None not in limit.bounds

    def rule_of(self, limit: Limit) -> Rule:
        """The decision rule of a limit: its own, else that of the file."""
        return limit.rule or self.rule
