"""What determines a rough recording, to the last bit."""

from typing import Literal

from pydantic import Field

from tests.proof.plant.case import Case, Data, EffectCall

Run = Literal["table", "shaft", "hand"]
Vector = tuple[float, float, float]


class Encoder(Data):
    """How the table is read. step, noise: rad. jitter: s, of its stamps about the true instants.

    speeds: whether it reports rates, too, each over the interval
    around its reading.
    """

    rate_hz: float = Field(gt=0)
    step: float = Field(gt=0)
    noise: float = Field(ge=0)
    jitter: float = Field(default=0.0, ge=0)
    speeds: bool = False


class Tracking(Data):
    """How the poses of a tracked body are measured.

    position_noise: m, each axis. attitude_noise: rad, each axis. turn: rotation vector in rad
    that carries the unit's axes into the tracked body's. tilt: rotation vector in rad of the
    room's axes against the true ones. arm: m from the tracked origin to the accelerometers, along
    the unit's axes. delay: s by which poses come late: what is stamped t happened at t − delay.
    interpolated: given at the unit's rows, in straight lines between the frames.
    gaps: (start, end) s in which nothing was seen.
    """

    rate_hz: float = Field(gt=0)
    position_noise: float = Field(ge=0)
    attitude_noise: float = Field(ge=0)
    turn: Vector = (0.0, 0.0, 0.0)
    tilt: Vector = (0.0, 0.0, 0.0)
    arm: Vector = (0.0, 0.0, 0.0)
    delay: float = 0.0
    interpolated: bool = False
    gaps: tuple[tuple[float, float], ...] = ()


class RoughCase(Data):
    """A case with its reference.

    run: the case's procedure on a table; a motor shaft to and fro; a body moved by hand.
    duration_s: of the latter two. top_rate: rad/s at the most, of the latter two.
    stamp_jitter: s, of the unit's stamps. axis: direction of the shaft in n.
    """

    case: Case
    run: Run
    duration_s: float = Field(default=90.0, gt=10.0)
    top_rate: float = Field(default=4.0, gt=0)
    stamp_jitter: float = Field(default=0.0, ge=0)
    axis: Vector = (0.0, 0.0, 1.0)
    encoder: Encoder | None = None
    tracking: Tracking | None = None

    def with_effects(self, effects: tuple[EffectCall, ...]) -> "RoughCase":
        """The same with other hidden physics."""
        case = self.case.model_copy(update={"effects": effects})
        return self.model_copy(update={"case": case})

    def without(self, *names: str) -> "RoughCase":
        """The same with some effects taken out."""
        return self.with_effects(tuple(e for e in self.case.effects if e.name not in names))

    def with_strength(self, name: str, strength: float) -> "RoughCase":
        """The same with one effect at another strength."""
        return self.model_copy(update={"case": self.case.with_strength(name, strength)})
