"""Gyro effects that model (1) does not contain."""

from dataclasses import replace

import numpy as np

from schemas.recording import Recording
from tasks.model.term import (
    DEG,
    GYRO_FIRST,
    MATRIX,
    STILL,
    G,
    Parameter,
    SensorTerm,
    Term,
    crossed,
    each_axis,
    each_pair,
    own,
)
from tasks.motion.whole import Motion
from tasks.words import message

ORDERS = (2, 3)
DEAD_BAND = 0.05  # rad/s
# Of full scale: linearity ±5 % up to ±300 deg/s by the data sheet of the Murata Gyrostar ENC-03R.
LARGEST_BEND = 0.05
THRESHOLD = Parameter("threshold", "r", "deg/s", "rad/s", (1e-3, 0.5))
# Friction takes off; it adds nothing, and takes no more than there is.
_TAKEN_OFF = tuple(
    replace(one, plausible=(-1.0, 0.0)) for one in each_axis("coefficient", "c", ("1", "1", 1.0))
)
ORDER = Parameter("order", "n", "1", "1", (2.0, 3.0))


def gyro_scale_nonlinearity(order: int, top: float) -> SensorTerm:
    """A share of the reading at the run's top rate, as the second or third power of the rate.

    top: the run's largest rate, rad/s.
    """
    return SensorTerm(
        "gyro_scale_nonlinearity", "gyro", "sensor",
        f"ω′ᵢ = cᵢ·ωᵢ^{order}/ω_top^{order - 1}, ω_top = {DEG * top:.0f} deg/s",
        "IEEE Std 1431; IEEE Std 952",
        each_axis("coefficient", "c", ("1", "1", LARGEST_BEND)), (ORDER,), (float(order),),
        reads=lambda motion, inputs, at: own(
            GYRO_FIRST, inputs.rate ** int(at[0]) / top ** (int(at[0]) - 1)
        ),
        confused_with=("gyro_scale_asymmetry", "gyro_saturation", "structural_compliance"),
    )  # fmt: skip


def gyro_odd_quadratic(top: float) -> SensorTerm:
    """A share of the reading at the run's top rate (rad/s), as the square with the rate's sign."""
    return SensorTerm(
        "gyro_scale_nonlinearity", "gyro", "sensor",
        f"ω′ᵢ = cᵢ·ωᵢ·|ωᵢ|/ω_top, ω_top = {DEG * top:.0f} deg/s",
        "IEEE Std 1293 (odd quadratic), of a gyro as of an accelerometer",
        each_axis("coefficient", "c", ("1", "1", LARGEST_BEND)),
        reads=lambda motion, inputs, at: own(
            GYRO_FIRST, inputs.rate * np.abs(inputs.rate) / top
        ),
        own_title=message("effect-gyro-scale-nonlinearity.odd-quadratic"),
        confused_with=("gyro_scale_asymmetry", "gyro_saturation", "structural_compliance"),
    )  # fmt: skip


def gyro_dead_band(threshold: float) -> SensorTerm:
    """Friction that a rate must overcome: beyond a threshold (rad/s) that much less is read."""
    return SensorTerm(
        "gyro_scale_nonlinearity", "gyro", "sensor", "ω′ᵢ = cᵢ·max(−r, min(r, ωᵢ))",
        "IEEE Std 528 (threshold, dead zone)", _TAKEN_OFF,
        (THRESHOLD,), (threshold,),
        reads=lambda motion, inputs, at: own(GYRO_FIRST, np.clip(inputs.rate, -at[0], at[0])),
        own_title=message("effect-gyro-scale-nonlinearity.dead-band"),
        confused_with=("hysteresis", "gyro_scale_asymmetry"),
    )  # fmt: skip


# Half the difference of the scale factors for the two signs of the rate.
GYRO_SCALE_ASYMMETRY = SensorTerm(
    "gyro_scale_asymmetry", "gyro", "sensor", "ω′ᵢ = hᵢ·|ωᵢ|", "IEEE Std 1431; IEEE Std 952",
    each_axis("half_difference", "h", ("1", "1", 0.02)),
    reads=lambda motion, inputs, at: own(GYRO_FIRST, np.abs(inputs.rate)),
    confused_with=("gyro_scale_nonlinearity", "hysteresis"),
)  # fmt: skip


# A bias that follows the squares of the specific force.
GYRO_G2_SENSITIVITY = SensorTerm(
    "gyro_g2_sensitivity", "gyro", "sensor", "ω′ᵢ = Σⱼ M_ij·fⱼ²", "IEEE Std 952; IEEE Std 1431",
    each_pair("M", ("(deg/s)/g2", "(rad/s)/(m/s2)2", 0.1 / (DEG * G**2))),
    reads=lambda motion, inputs, at: crossed(GYRO_FIRST, inputs.force**2),
    confused_with=("gyro_scale_g_dependence", "magnetic_sensitivity", "earth_rotation"),
)  # fmt: skip


# A scale factor that follows the specific force.
GYRO_SCALE_G_DEPENDENCE = SensorTerm(
    "gyro_scale_g_dependence", "gyro", "sensor", "ω′ᵢ = ωᵢ·Σⱼ S_ij·fⱼ", "IEEE Std 1431",
    each_pair("S", ("1/g", "1/(m/s2)", 0.02 / G)),
    reads=lambda motion, inputs, at: tuple(
        {GYRO_FIRST + i: inputs.rate[:, i] * inputs.force[:, j]} for i, j in MATRIX
    ),
    confused_with=("gyro_g2_sensitivity", "gyro_scale_asymmetry"),
)  # fmt: skip


# An output that follows the angular acceleration.
GYRO_ANGULAR_ACCELERATION = SensorTerm(
    "gyro_angular_acceleration", "gyro", "sensor", "ω′ᵢ = Σⱼ A_ij·ω̇ⱼ", "IEEE Std 952",
    each_pair("A", ("s", "s", 0.05)),
    reads=lambda motion, inputs, at: crossed(GYRO_FIRST, motion.acceleration),
    confused_with=("time_offset", "bandwidth"),
)  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """What rests show, and where it turned what turning shows."""
    top = top_rate(motion)
    if top == 0.0:
        return (GYRO_G2_SENSITIVITY,)
    return (
        *(gyro_scale_nonlinearity(order, top) for order in ORDERS), gyro_odd_quadratic(top),
        gyro_dead_band(DEAD_BAND),
        GYRO_SCALE_ASYMMETRY,
        GYRO_G2_SENSITIVITY, GYRO_SCALE_G_DEPENDENCE, GYRO_ANGULAR_ACCELERATION,
    )  # fmt: skip


def top_rate(motion: Motion) -> float:
    """The run's largest rate about any axis, rad/s, rounded to two digits in deg/s; 0: none."""
    top = float(np.abs(np.nan_to_num(motion.rate)).max(initial=0.0))
    return float(f"{DEG * top:.1e}") / DEG if top > STILL else 0.0
