"""What an accelerometer does that model (2) has no place for."""

from schemas.recording import Recording
from tasks.model.parameters import ACCEL_FIRST, G, each_axis, own, same
from tasks.model.term import Parameter, SensorTerm, Term
from tasks.motion.whole import Motion

ORDERS = (2, 3)
MAX_POWER_RATIO = 1e5  # times the observed vibration power: what lies above the unit's band


def accel_nonlinearity(order: int) -> SensorTerm:
    """A share of g, as the second or third power of the specific force."""
    return SensorTerm(
        "accel_nonlinearity", "accelerometer", "sensor", f"a′ᵢ = cᵢ·fᵢ^{order}/g^{order - 1}",
        "IEEE Std 1293", each_axis("coefficient", "c", ("1", 1.0, 0.02)),
        (Parameter("order", "n", "1", 1.0, (2.0, 3.0)),), (float(order),),
        reads=lambda motion, inputs, at: own(
            ACCEL_FIRST, inputs.force ** int(at[0]) / motion.gravity ** (int(at[0]) - 1)
        ),
        confused_with=("accel_saturation", "vibration_rectification", "structural_compliance"),
    )  # fmt: skip


# A bias that follows the power of the vibration. What rectifies lies mostly above the unit's band;
# known is only the part that reaches the readings as noise. So the coefficient is that of the
# observed power, and may be thousands of times the sensor's own.
VIBRATION_RECTIFICATION = SensorTerm(
    "vibration_rectification", "accelerometer", "sensor", "a′ᵢ = cᵢ·⟨a_vib²⟩", "IEEE Std 1293",
    each_axis("in_band_coefficient", "c", ("g/g2", G, MAX_POWER_RATIO * 0.1 / G)),
    reads=lambda motion, inputs, at: same(motion.recorded["vibration"], (3, 4, 5)),
    confused_with=("lever_arm", "structural_compliance", "accel_nonlinearity"),
)  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """Nonlinearity always, rectification where vibration was observed."""
    shaken = (VIBRATION_RECTIFICATION,) if "vibration" in motion.recorded else ()
    return (*(accel_nonlinearity(order) for order in ORDERS), *shaken)
