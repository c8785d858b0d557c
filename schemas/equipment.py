"""Measuring equipment of a laboratory: standards, their certificates and their error limits."""

from datetime import date
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from schemas.base import Frozen

MAX_HALF_WIDTH = 1.0  # relative, rad or m/s²: equipment that may be further off calibrates nothing
LimitShape = Literal["normal", "rectangular", "triangular", "arcsine"]
LimitName = Literal[
    "rate",
    "ripple",
    "time_base",
    "level",
    "position",
    "repeatability",
    "axes",
    "fixture",
    "mounting",
    "gravity",
    "latitude",
    "heading",
]


class ErrorBound(Frozen):
    """How far one property of the equipment may be off.

    half_width: relative for rate, ripple and time_base (of the clock that stamps the readings);
    rad for angles, latitude and heading; m/s² for gravity. mounting: of the unit's base in the
    fixture, by the flatness of the surface over the length of the base; without it the results
    hold for the axes of the fixture. level: of the vertical of the table's outermost axis.
    For `normal` it is an expanded uncertainty with k = 2.
    """

    half_width: Annotated[float, Field(gt=0, le=MAX_HALF_WIDTH, allow_inf_nan=False, strict=True)]
    distribution: LimitShape


class EquipmentLimit(ErrorBound):
    """A bound, and which paper states it."""

    source: str = Field(min_length=1)


class MeasurementStandard(Frozen):
    """A measurement standard, as clause 8 h) wants it on the certificate.

    limits: what its certificate says it may be off by, which goes into the budgets and is printed
    in the place of `accuracy`. It may be used from `calibrated_on` to `valid_until`.
    traceable: whether its certificate shows an unbroken chain of calibrations to the SI.
    """

    name: str
    name_zh: str
    serial: str
    accuracy: str
    accuracy_zh: str = ""
    certificate: str
    traceable: bool = True
    calibrated_on: date | None = None
    valid_until: date | None = None
    limits: dict[LimitName, ErrorBound] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _due_after_it_was_calibrated(self) -> Self:
        if self.calibrated_on and self.valid_until and self.valid_until < self.calibrated_on:
            raise ValueError(
                f"{self.name} ({self.serial}) has valid_until = {self.valid_until} before "
                f"calibrated_on = {self.calibrated_on}"
            )
        return self


class EquipmentFile(Frozen):
    """Measurement standards for the register of the laboratory."""

    format: Literal["mimu-equipment/1"] = "mimu-equipment/1"
    equipment: tuple[MeasurementStandard, ...] = Field(min_length=1)
