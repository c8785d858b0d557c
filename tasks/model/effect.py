"""The record of an effect, whether it is a term of a model or an event in the samples."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from tasks.words import Sayable, known, message

Stage = Literal["motion", "input", "sensor", "signal", "event"]
TimeCourse = Literal["drift", "jump", "random walk"]


@dataclass(frozen=True)
class Effect:
    """A piece of physics that readings may show and the standard's model leaves out.

    stage: where it acts; an event is found by looking at the samples and is no term of a model.
    confused_with: names of effects that look much the same. rarity: chi-squared that it must gain
    beyond a more usual effect that looks the same. time_course: how a bias changes, if that is
    what it is. since_power_on: whether it follows the time since then alone, whatever happens to
    the unit. own_title: its title where the catalogue of words has no entry of its name.
    """

    name: str
    family: str
    stage: Stage
    equation: str
    source: str
    confused_with: tuple[str, ...] = field(default=(), kw_only=True)
    rarity: float = field(default=0.0, kw_only=True)
    time_course: TimeCourse | None = field(default=None, kw_only=True)
    since_power_on: bool = field(default=False, kw_only=True)
    own_title: Sayable | None = field(default=None, kw_only=True)

    @property
    def title(self) -> Sayable:
        """What an engineer calls it, with the order or axis of its variant."""
        if self.own_title is not None:
            return self.own_title
        return _attribute(self.name, "title", **self.word_arguments) or _spelled(self.name)

    @property
    def behaviour(self) -> Sayable:
        """What readings that show it follow, without its name; what has none is called by that.

        A form with a title of its own need not behave like the effect's usual one.
        """
        usual = _attribute(self.name, "behaviour", **self.word_arguments)
        if self.own_title is not None and usual is None:
            return self.own_title
        return usual if usual and self.own_title is None else message(f"behaviour-{self.stage}")

    @property
    def separated_by(self) -> Sayable | None:
        """The recording that would separate it from the effects it is confused with."""
        return separating_recording(self.name)

    @property
    def word_arguments(self) -> dict[str, int]:
        """What distinguishes the variants of one name, as arguments of their words."""
        return {}


def effect_name(name: str) -> Sayable:
    """What an effect is called within a sentence; its name spelled out where it has no entry."""
    id_ = _message_id(name)
    return message(id_) if known(id_) else _spelled(name)


def separating_recording(name: str) -> Sayable | None:
    """The recording that would separate an effect from those it is confused with."""
    return _attribute(name, "separated-by")


def next_step(name: str) -> Sayable | None:
    """What an engineer does about an effect that was found."""
    return _attribute(name, "next")


def _attribute(name: str, attribute: str, **arguments: int) -> Sayable | None:
    id_ = f"{_message_id(name)}.{attribute}"
    return message(id_, **arguments) if known(id_) else None


def _message_id(name: str) -> str:
    return "effect-" + name.replace("_", "-")


def _spelled(name: str) -> str:
    return name.replace("_", " ")


LOGGER = "logger and firmware"

# Effects that are no term of a model: they are found by looking at samples.
_EVENTS = (
    Effect(
        "gyro_saturation", "gyro", "event", "ω′ᵢ = max(−L, min(L, ω′ᵢ))",
        "IEEE Std 528; IEEE Std 1431", confused_with=("gyro_scale_nonlinearity",),
    ),
    Effect(
        "accel_saturation", "accelerometer", "event", "a′ᵢ = max(−L, min(L, a′ᵢ))",
        "IEEE Std 528; IEEE Std 1293", confused_with=("accel_nonlinearity",),
    ),
    Effect(
        "dropped_samples", "time", "event", "y′ₖ = y(tₖ + n·Δt) after n lost samples",
        "definition of a time stamp; IEEE Std 1554", confused_with=("clock_skew", "time_offset"),
    ),
    Effect(
        "coarse_quantisation", "electronics", "event",
        "y′ᵢ = q·round(yᵢ/q), white noise q²/12 where the noise is large", "IEEE Std 1241",
        confused_with=("bias_random_walk",),
    ),
    Effect(
        "mains_pickup", "electronics", "event",
        "bᵢ(t) = Aᵢ·cos(2πf·t + φᵢ), f = |n·fs − 50 Hz| or |n·fs − 60 Hz|", "IEEE Std 952",
        confused_with=("rate_ripple",),
    ),
    Effect(
        "range_setting", LOGGER, "event", "y′ = c·y on a whole triad: c = 2ⁿ, 180/π, g, 1000 …",
        "IEEE Std 1431, scale factor; register maps of digital inertial sensors",
        confused_with=("table_scale", "gyro_saturation"),
    ),
    Effect(
        "axis_mapping", LOGGER, "event", "y′ = P·y, P a signed permutation of the axes",
        "IEEE Std 1431, input axis; sensor frames of digital inertial sensors",
        confused_with=("range_setting",),
    ),
    Effect(
        "gravity_removed", LOGGER, "event", "y′ = a − g·up, as the driver estimates up",
        "linear acceleration of drivers of digital inertial sensors",
        confused_with=("range_setting",),
    ),
    Effect(
        "dead_zone", LOGGER, "event", "y′ = 0 for |y| < d; or at rest y′ = y − mean of y",
        "IEEE Std 1431, dead band; IEEE Std 528", confused_with=("coarse_quantisation",),
    ),
    Effect(
        "code_fault", LOGGER, "event", "y′ = y + n·2ᵇ·q, n a whole number by the code of y",
        "IEEE Std 1241, missing codes and bit errors", confused_with=("bias_step",),
    ),
    Effect(
        "repeated_samples", LOGGER, "event",
        "y′ₖ = y′ₖ₋₁, or on the straight line from y′ₖ₋₁ to y′ₖ₊₁",
        "IEEE Std 1241, sample and hold; R. E. Crochiere, L. R. Rabiner, Multirate Digital Signal "
        "Processing, 1983",
        confused_with=("time_offset", "dropped_samples"),
    ),
    Effect(
        "timestamp_jitter", LOGGER, "event", "t′ₖ = tₖ + jₖ, so that y′(t′ₖ) = y(t′ₖ − jₖ)",
        "IEEE Std 1241, aperture uncertainty; IEEE Std 1139",
        confused_with=("time_offset", "dropped_samples"),
    ),
)  # fmt: skip

EVENTS: Mapping[str, Effect] = {event.name: event for event in _EVENTS}
