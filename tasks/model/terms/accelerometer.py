"""Accelerometer effects that model (2) does not contain."""

import numpy as np
from numpy.polynomial import Chebyshev

from schemas.recording import Recording
from tasks.model.term import (
    ACCEL_FIRST,
    G,
    Parameter,
    SensorTerm,
    Term,
    each_axis,
    own,
    same,
    turned,
)
from tasks.motion.whole import Motion

ORDERS = (2, 3)
WAVES = (4, 5, 6, 7)  # of the errors that a converter makes along its range
EXPONENTS = (1.0, 2.0)  # of the speed: power of the vibration
MAX_POWER_RATIO = 1e5  # times the observed vibration power: what lies above the unit's band


def accel_nonlinearity(order: int) -> SensorTerm:
    """A share of g, as the second or third power of the specific force."""
    return SensorTerm(
        "accel_nonlinearity", "accelerometer", "sensor", f"a′ᵢ = cᵢ·fᵢ^{order}/g^{order - 1}",
        "IEEE Std 1293", each_axis("coefficient", "c", ("1", "1", 0.02)),
        (Parameter("order", "n", "1", "1", (2.0, 3.0)),), (float(order),),
        reads=lambda motion, inputs, at: own(
            ACCEL_FIRST, inputs.force ** int(at[0]) / motion.gravity ** (int(at[0]) - 1)
        ),
        confused_with=("accel_saturation", "vibration_rectification", "structural_compliance"),
    )  # fmt: skip


def converter_nonlinearity(order: int) -> SensorTerm:
    """An error that goes up and down along the range, as a converter's integral one does."""

    def waves(force: np.ndarray) -> np.ndarray:
        top = np.maximum(np.abs(np.nan_to_num(force)).max(axis=0, initial=0.0), 1e-9)
        return np.asarray(Chebyshev.basis(order)(force / top))

    return SensorTerm(
        "accel_nonlinearity", "accelerometer", "sensor", f"a′ᵢ = cᵢ·g·T{order}(fᵢ/f_top)",
        "IEEE Std 1241 (integral non-linearity), in Chebyshev's polynomials",
        each_axis("coefficient", "c", ("1", "1", 0.02)),
        (Parameter("order", "n", "1", "1", (4.0, 7.0)),), (float(order),),
        reads=lambda motion, inputs, at: own(ACCEL_FIRST, waves(inputs.force) * motion.gravity),
        confused_with=("accel_saturation", "structural_compliance"),
    )  # fmt: skip


# A bias that follows the power of the vibration. What rectifies lies mostly above the unit's band;
# known is only the part that reaches the readings as noise. So the coefficient is that of the
# observed power, and may be thousands of times the sensor's own.
VIBRATION_RECTIFICATION = SensorTerm(
    "vibration_rectification", "accelerometer", "sensor", "a′ᵢ = cᵢ·⟨a_vib²⟩", "IEEE Std 1293",
    each_axis("in_band_coefficient", "c", ("g/g2", "(m/s2)/(m/s2)2", MAX_POWER_RATIO * 0.1 / G)),
    reads=lambda motion, inputs, at: same(motion.recorded["vibration"], (3, 4, 5)),
    confused_with=("lever_arm", "structural_compliance", "accel_nonlinearity"),
)  # fmt: skip


def rectification_of_speed(of_all: bool, exponent: float) -> SensorTerm:
    """A bias that follows the vibration of a bearing or a drive which no reading shows.

    Its power follows the speed of turning: of the whole rate, or of that about the own axis.
    """

    def share(motion: Motion) -> np.ndarray:
        speeds = np.abs(motion.rate)
        if of_all:
            speeds = np.repeat(np.linalg.norm(motion.rate, axis=1)[:, None], 3, axis=1)
        return speeds / max(float(np.nanmax(np.abs(motion.rate))), 1e-9)

    speed = "|ω|" if of_all else "|ωᵢ|"
    return SensorTerm(
        "vibration_rectification", "accelerometer", "sensor",
        f"a′ᵢ = bᵢ·({speed}/ω_top)ⁿ, ⟨a_vib²⟩ ∝ {speed}ⁿ",
        "IEEE Std 1293; ISO 20816-1 (vibration of rotating machines by speed)",
        each_axis("at_top_rate", "b", ("m/s2", "m/s2", 0.1)),
        (Parameter("exponent", "n", "of the speed", "of the speed", (0.5, 4.0)),), (exponent,),
        reads=lambda motion, inputs, at: own(ACCEL_FIRST, share(motion) ** at[0]),
        confused_with=("lever_arm", "structural_compliance", "accel_nonlinearity"),
    )  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """Nonlinearity always, rectification where vibration was observed or something turned."""
    observed = (VIBRATION_RECTIFICATION,) if "vibration" in motion.recorded else ()
    unobserved = (
        *(rectification_of_speed(True, exponent) for exponent in EXPONENTS),
        rectification_of_speed(False, EXPONENTS[-1]),
    )
    return (
        *(accel_nonlinearity(order) for order in ORDERS),
        *(converter_nonlinearity(order) for order in WAVES),
        *observed,
        *(unobserved if turned(motion) else ()),
    )
