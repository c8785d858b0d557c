"""A procedure: the sequence of a specification as data.

All angles are in deg, table axes outer first (the outermost is 0).
"""

from math import pi
from typing import Literal, Self

from pydantic import Field, model_validator

from schemas.base import Finite, Frozen
from schemas.recording import Axis, Mount, Standard, Up


class Position(Frozen):
    """A rest at table angles. axis: the axis of the unit for which it is measured, if any.

    chamber_degc: the chamber's set-point from the beginning of the rest until a later step changes
    it; nothing waits for the air or the unit to reach it.
    """

    kind: Literal["position"] = "position"
    name: str
    item: str
    up: Up
    axis: Axis | None = None
    turn_deg: Finite | None = None
    chamber_degc: Finite | None = None
    angles_deg: tuple[Finite, ...]
    dwell_s: Finite = Field(gt=0)


class Sweep(Frozen):
    """Rests for one axis of the unit: a vertical table axis at each of its stops."""

    kind: Literal["sweep"] = "sweep"
    name: str
    item: str
    up: Up
    axis: Axis
    table_axis: int = Field(ge=0)
    angles_deg: tuple[Finite, ...]
    stops_deg: tuple[Finite, ...] = Field(min_length=1)
    dwell_s: Finite = Field(gt=0)


class RateRun(Frozen):
    """Rates about one table axis, with the others held at given angles.

    axis, up: of the unit, which turns about it and has it up; both null where it is held at an
    oblique angle.
    """

    kind: Literal["rate_run"] = "rate_run"
    name: str
    item: str
    axis: Axis | None = None
    up: Up | None = None
    spin_axis: int = Field(ge=0)
    angles_deg: tuple[Finite, ...]
    rates_deg_s: tuple[Finite, ...] = Field(min_length=1)
    dwell_s: Finite = Field(gt=0)

    @model_validator(mode="after")
    def _has_both_or_neither(self) -> Self:
        if (self.axis is None) != (self.up is None):
            raise ValueError(
                f"rate_run {self.name} has {'up' if self.axis is None else 'axis'} alone; "
                "give axis and up, or neither for a unit that is held aslant"
            )
        return self


class Turns(Frozen):
    """Whole turns of one table axis from rest to rest, forward and then back."""

    kind: Literal["turns"] = "turns"
    name: str
    item: str
    axis: Axis
    up: Up
    spin_axis: int = Field(ge=0)
    angles_deg: tuple[Finite, ...]
    turns: int = Field(gt=0)
    rate_deg_s: Finite = Field(gt=0)


class Oscillation(Frozen):
    """Whole periods of a sinusoid of one table axis, from rest to rest at given angles.

    The recording labels it as a transition: nothing is measured in its mean. Only a table with the
    command `oscillate` can do it.
    """

    kind: Literal["oscillation"] = "oscillation"
    name: str
    item: str
    axis: Axis | None = None
    up: Up | None = None
    spin_axis: int = Field(ge=0)
    angles_deg: tuple[Finite, ...]
    amplitude_deg: Finite = Field(gt=0)
    frequency_hz: Finite = Field(gt=0)
    cycles: int = Field(gt=0)

    @property
    def seconds(self) -> float:
        """How long the motion takes, s."""
        return self.cycles / self.frequency_hz

    @property
    def rate_deg_s(self) -> float:
        """The largest."""
        return 2.0 * pi * self.frequency_hz * self.amplitude_deg

    @property
    def acceleration_deg_s2(self) -> float:
        """The largest."""
        return 2.0 * pi * self.frequency_hz * self.rate_deg_s


class Refix(Frozen):
    """The unit is remounted in its fixture; mount: its attitude from then on.

    With power_off the unit's supply is switched off meanwhile, and the unit warms up again.
    """

    kind: Literal["refix"] = "refix"
    name: str
    mount: Mount
    instruction: str
    instruction_zh: str
    power_off: bool = False


class EnvironmentLimits(Frozen):
    """Clause 6: the limits of the room."""

    temperature_degc: tuple[Finite, Finite]
    humidity_percent: tuple[Finite, Finite]


class Procedure(Frozen):
    """The steps of a run and the limits it keeps to."""

    format: Literal["mimu-procedure/1"] = "mimu-procedure/1"
    name: str
    title: str
    title_zh: str
    standard: Standard
    environment: EnvironmentLimits
    warm_up_s: Finite = Field(ge=0)
    settle_s: Finite = Field(ge=0)
    move_rate_deg_s: Finite = Field(gt=0)
    acceleration_deg_s2: Finite = Field(gt=0)
    steps: tuple[Position | Sweep | RateRun | Turns | Oscillation | Refix, ...] = Field(
        min_length=1
    )

    @model_validator(mode="after")
    def _measures_after_every_refix(self) -> Self:
        following = (*self.steps[1:], None)
        for step, after in zip(self.steps, following, strict=True):
            if isinstance(step, Refix) and (after is None or isinstance(after, Refix)):
                raise ValueError(f"nothing is measured after refix {step.name}")
        return self
