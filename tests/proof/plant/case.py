"""What determines a simulated recording, to the last bit."""

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

Grade = Literal["consumer", "industrial", "tactical"]
Procedure = Literal[
    "three_axis", "single_axis", "six_orientations", "one_axis", "rests", "ahrs", "given"
]  # fmt: skip
Order = Literal["rising", "alternating", "shuffled"]
Climate = Literal["room", "cycling"]


class Data(BaseModel):
    """A model that does not change and refuses fields it does not know."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class EffectCall(Data):
    """One piece of hidden physics.

    strength: multiplies the typical size (1). parameters: replace drawn ones before that, in SI.
    """

    name: str
    strength: float = Field(default=1.0, ge=0, allow_inf_nan=False)
    parameters: Mapping[str, Any] = {}


class Case(Data):
    """Unit, station, procedure and hidden physics of one recording.

    rate_hz: samples per second of unit and table. rates_deg_s: magnitudes, each turned both ways.
    gravity_m_s2, latitude_deg, heading_deg: what the manifest tells; they are true unless an
    effect says otherwise. temperature_recorded: whether the unit gives its own temperature.
    site_known: whether the manifest tells latitude and heading. unit_seed: which unit, where it is
    not a new one in each run.
    """

    seed: int = Field(ge=0)
    unit_seed: int | None = Field(default=None, ge=0)
    grade: Grade = "industrial"
    procedure: Procedure = "three_axis"
    rate_hz: int = Field(default=100, ge=10, le=2000)
    rates_deg_s: tuple[float, ...] = (10.0, 50.0, 100.0, 200.0, 300.0)
    dwell_s: float = Field(default=30.0, ge=5.0)
    order: Order = "rising"
    climate: Climate = "room"
    latitude_deg: float = Field(default=39.9, ge=-90, le=90)
    heading_deg: float = 0.0
    gravity_m_s2: float = Field(default=9.8015, gt=9.7, lt=9.9)
    temperature_recorded: bool = True
    site_known: bool = True
    effects: tuple[EffectCall, ...] = ()
    given: Mapping[str, Any] | None = None

    def only(self, *names: str) -> "Case":
        """The same case with these effects alone."""
        kept = tuple(effect for effect in self.effects if effect.name in names)
        return self.model_copy(update={"effects": kept})

    def without(self, name: str) -> "Case":
        """The same case with one effect taken out."""
        return self.only(*(effect.name for effect in self.effects if effect.name != name))

    def with_strength(self, name: str, strength: float) -> "Case":
        """The same case with one effect at another strength."""
        changed = tuple(
            effect.model_copy(update={"strength": strength}) if effect.name == name else effect
            for effect in self.effects
        )
        return self.model_copy(update={"effects": changed})
