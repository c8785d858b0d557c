"""The limits of a table, of the fixture on it and of the chamber around both."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from schemas.base import Finite, Frozen

Positive = Annotated[Finite, Field(gt=0)]


class MotionLimits(Frozen):
    """The most rate and acceleration, and the lowest and highest angle; null: no limit."""

    rate_deg_s: Positive | None = None
    acceleration_deg_s2: Positive | None = None
    angle_deg: tuple[Finite, Finite] | None = None

    @model_validator(mode="after")
    def _low_before_high(self) -> Self:
        if self.angle_deg is not None and self.angle_deg[0] >= self.angle_deg[1]:
            raise ValueError("angle_deg needs the lowest angle first, then the highest")
        return self


class ChamberLimits(Frozen):
    """Between which temperatures a chamber may be set, and how fast its air changes, K/min."""

    temperature_degc: tuple[Finite, Finite]
    rate_k_min: Positive

    @model_validator(mode="after")
    def _low_before_high(self) -> Self:
        if self.temperature_degc[0] >= self.temperature_degc[1]:
            raise ValueError("temperature_degc needs the lowest temperature first")
        return self


class Limits(Frozen):
    """axes: of a table axis, by its name. fixture: of fixture, unit and cable, on every axis.

    chamber: null: its temperature cannot be set.
    """

    axes: dict[str, MotionLimits] = Field(default_factory=dict)
    fixture: MotionLimits = MotionLimits()
    chamber: ChamberLimits | None = None

    def of(self, axis: str) -> tuple[tuple[str, MotionLimits], ...]:
        """Everything that limits an axis, with the name of what is limited."""
        return (f"axis {axis}", self.axes.get(axis, MotionLimits())), ("the fixture", self.fixture)

    def is_endless(self, axis: str) -> bool:
        """Whether an axis may turn on and on."""
        return all(limits.angle_deg is None for _, limits in self.of(axis))
