"""The limits of a product model, and the decision rule for each."""

from collections.abc import Sequence
from itertools import combinations
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from schemas.base import Finite, Frozen
from schemas.text import Messages

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


# The verdict on a unit: each value against its limit, and the risk of the decision.

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


# A laboratory's calibration and measurement capabilities (CMC).

Range = tuple[Finite, Finite]


class Capability(Frozen):
    """The smallest expanded uncertainty (k = 2) of an item within a range (ILAC-P14:09/2020, 4).

    item: by its key, as gyro_scale_factor. unit: of U and values, that of the item; of a relative U
    it is that of values alone. rates_deg_s: lowest and highest held rate of the run, without a
    sign; none: at any rates, or at none. values: lowest and highest measured value; none: any.
    """

    item: str = Field(min_length=1)
    unit: str
    U: Annotated[float, Field(gt=0, allow_inf_nan=False)]
    relative: bool = False
    rates_deg_s: Range | None = None
    values: Range | None = None

    @model_validator(mode="after")
    def _ranges_rise(self) -> Self:
        for name in ("rates_deg_s", "values"):
            low_high = getattr(self, name)
            if low_high and not low_high[0] < low_high[1]:
                raise ValueError(
                    f"{name} = {list(low_high)} needs the lowest first, the highest second"
                )
        if self.rates_deg_s and self.rates_deg_s[0] < 0.0:
            raise ValueError(f"rates_deg_s = {list(self.rates_deg_s)}: rates are without a sign")
        return self


def check_apart(capabilities: Sequence[Capability]) -> None:
    """Raises ValueError for two capabilities of one item whose ranges overlap."""
    for (n, one), (m, other) in combinations(enumerate(capabilities, start=1), 2):
        if one.item == other.item and all(
            _overlap(getattr(one, name), getattr(other, name)) for name in ("rates_deg_s", "values")
        ):
            raise ValueError(
                f"capabilities {n} and {m} are both of {one.item} and their ranges overlap: give "
                "each rates_deg_s or values of its own"
            )


def _overlap(one: Range | None, other: Range | None) -> bool:
    return one is None or other is None or (one[0] < other[1] and other[0] < one[1])
