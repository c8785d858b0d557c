"""A procedure: the sequence of a specification as data."""

from typing import Literal

from pydantic import Field

from schemas.base import Finite, Frozen
from schemas.recording import Axis, Standard, Up


class Position(Frozen):
    """A rest at table angles (deg, outer axis first)."""

    kind: Literal["position"] = "position"
    name: str
    item: str
    up: Up
    turn_deg: Finite | None = None
    angles_deg: tuple[Finite, ...]
    dwell_s: Finite = Field(gt=0)


class RateRun(Frozen):
    """Rates about one table axis (the outermost is 0), the others held at angles (deg)."""

    kind: Literal["rate_run"] = "rate_run"
    name: str
    item: str
    axis: Axis
    up: Up
    spin_axis: int = Field(ge=0)
    angles_deg: tuple[Finite, ...]
    rates_deg_s: tuple[Finite, ...] = Field(min_length=1)
    dwell_s: Finite = Field(gt=0)


class EnvironmentLimits(Frozen):
    """Clause 6: what the room must keep to."""

    temperature_degc: tuple[Finite, Finite]
    humidity_percent: tuple[Finite, Finite]


class Procedure(Frozen):
    """What a run does, step by step, with the limits it keeps."""

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
    steps: tuple[Position | RateRun, ...] = Field(min_length=1)
