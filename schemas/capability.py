"""A laboratory's calibration and measurement capabilities (CMC)."""

from collections.abc import Sequence
from itertools import combinations
from typing import Annotated, Self

from pydantic import Field, model_validator

from schemas.base import Finite, Frozen

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
