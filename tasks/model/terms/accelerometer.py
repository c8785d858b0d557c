"""What an accelerometer does that model (2) has no place for."""

from dataclasses import dataclass

from schemas.recording import Recording
from tasks.model.parameters import G, each_axis, own, same
from tasks.model.term import Column, Inputs, Parameter, Term
from tasks.model.terms.standard import ACCEL_FIRST
from tasks.motion.whole import Motion

ORDERS = (2, 3)
MAX_POWER_RATIO = 1e5  # times the observed vibration power: what lies above the unit's band


@dataclass(frozen=True)
class Nonlinearity(Term):
    """A share of g, as a power of the specific force; shapes: the power."""

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        n = int(self.at[0])
        return own(ACCEL_FIRST, inputs.force**n / motion.gravity ** (n - 1))


def accel_nonlinearity(order: int) -> Nonlinearity:
    """Of second or third order."""
    return Nonlinearity(
        "accel_nonlinearity", "accelerometer", "sensor", f"a′ᵢ = cᵢ·fᵢ^{order}/g^{order - 1}",
        "IEEE Std 1293", each_axis("coefficient", "c", ("1", 1.0, 0.02)),
        (Parameter("order", "n", "1", 1.0, (2.0, 3.0)),), (float(order),),
        confused_with=("accel_saturation", "vibration_rectification", "structural_compliance"),
    )  # fmt: skip


@dataclass(frozen=True)
class VibrationRectification(Term):
    """A bias that follows the power of the vibration.

    What rectifies lies mostly above the unit's band; known is only the part that reaches the
    readings as noise. So the coefficient is that of the observed power, and may be thousands of
    times the sensor's own.
    """

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        return same(motion.recorded["vibration"], (3, 4, 5))


VIBRATION_RECTIFICATION = VibrationRectification(
    "vibration_rectification", "accelerometer", "sensor", "a′ᵢ = cᵢ·⟨a_vib²⟩", "IEEE Std 1293",
    each_axis("in_band_coefficient", "c", ("g/g2", G, MAX_POWER_RATIO * 0.1 / G)),
    confused_with=("lever_arm", "structural_compliance", "accel_nonlinearity"),
)  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """Nonlinearity always, rectification where vibration was observed."""
    shaken = (VIBRATION_RECTIFICATION,) if "vibration" in motion.recorded else ()
    return (*(accel_nonlinearity(order) for order in ORDERS), *shaken)
