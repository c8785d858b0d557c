"""What a gyro does that model (1) has no place for."""

from dataclasses import dataclass, field

import numpy as np

from schemas.recording import Recording
from tasks.model.parameters import DEG, STILL, G, crossed, each_axis, each_pair, own
from tasks.model.term import Column, Inputs, Parameter, Term
from tasks.model.terms.standard import GYRO_FIRST, MATRIX
from tasks.motion.whole import Motion

ORDERS = (2, 3)
G2 = DEG * G**2
ORDER = Parameter("order", "n", "1", 1.0, (2.0, 3.0))


@dataclass(frozen=True)
class ScaleNonlinearity(Term):
    """A share of the reading at the run's top rate, as a power of the rate.

    shapes: the power. top: rad/s.
    """

    top: float = field(kw_only=True)

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        n = int(self.at[0])
        return own(GYRO_FIRST, inputs.rate**n / self.top ** (n - 1))


def gyro_scale_nonlinearity(order: int, top: float) -> ScaleNonlinearity:
    """Of second or third order; top: the run's largest rate, rad/s."""
    return ScaleNonlinearity(
        "gyro_scale_nonlinearity", "gyro", "sensor",
        f"ω′ᵢ = cᵢ·ωᵢ^{order}/ω_top^{order - 1}, ω_top = {DEG * top:.0f} deg/s",
        "IEEE Std 1431; IEEE Std 952",
        each_axis("coefficient", "c", ("1", 1.0, 0.02)), (ORDER,), (float(order),), top=top,
        confused_with=("gyro_scale_asymmetry", "gyro_saturation", "structural_compliance"),
    )  # fmt: skip


@dataclass(frozen=True)
class ScaleAsymmetry(Term):
    """Half the difference of the scale factors for the two signs of the rate."""

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        return own(GYRO_FIRST, np.abs(inputs.rate))


GYRO_SCALE_ASYMMETRY = ScaleAsymmetry(
    "gyro_scale_asymmetry", "gyro", "sensor", "ω′ᵢ = hᵢ·|ωᵢ|", "IEEE Std 1431; IEEE Std 952",
    each_axis("half_difference", "h", ("1", 1.0, 0.02)),
    confused_with=("gyro_scale_nonlinearity", "hysteresis"),
)  # fmt: skip


@dataclass(frozen=True)
class G2Sensitivity(Term):
    """A bias that follows the squares of the specific force."""

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        return crossed(GYRO_FIRST, inputs.force**2)


GYRO_G2_SENSITIVITY = G2Sensitivity(
    "gyro_g2_sensitivity", "gyro", "sensor", "ω′ᵢ = Σⱼ M_ij·fⱼ²", "IEEE Std 952; IEEE Std 1431",
    each_pair("M", ("(deg/s)/g2", G2, 0.1 / G2)),
    confused_with=("gyro_scale_g_dependence", "magnetic_sensitivity", "earth_rotation"),
)  # fmt: skip


@dataclass(frozen=True)
class ScaleGDependence(Term):
    """A scale factor that follows the specific force."""

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        rate, force = inputs.rate.T, inputs.force.T
        return tuple({GYRO_FIRST + i: rate[i] * force[j]} for i, j in MATRIX)


GYRO_SCALE_G_DEPENDENCE = ScaleGDependence(
    "gyro_scale_g_dependence", "gyro", "sensor", "ω′ᵢ = ωᵢ·Σⱼ S_ij·fⱼ", "IEEE Std 1431",
    each_pair("S", ("1/g", G, 0.02 / G)),
    confused_with=("gyro_g2_sensitivity", "gyro_scale_asymmetry"),
)  # fmt: skip


@dataclass(frozen=True)
class AngularAcceleration(Term):
    """An output that follows the angular acceleration."""

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        return crossed(GYRO_FIRST, motion.acceleration)


GYRO_ANGULAR_ACCELERATION = AngularAcceleration(
    "gyro_angular_acceleration", "gyro", "sensor", "ω′ᵢ = Σⱼ A_ij·ω̇ⱼ", "IEEE Std 952",
    each_pair("A", ("s", 1.0, 0.05)),
    confused_with=("time_offset", "bandwidth"),
)  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """What rests show, and where it turned what turning shows."""
    top = top_rate(motion)
    if top == 0.0:
        return (GYRO_G2_SENSITIVITY,)
    return (
        *(gyro_scale_nonlinearity(order, top) for order in ORDERS), GYRO_SCALE_ASYMMETRY,
        GYRO_G2_SENSITIVITY, GYRO_SCALE_G_DEPENDENCE, GYRO_ANGULAR_ACCELERATION,
    )  # fmt: skip


def top_rate(motion: Motion) -> float:
    """The run's largest rate about any axis, rad/s, rounded to two digits in deg/s; 0: none."""
    top = float(np.abs(np.nan_to_num(motion.rate)).max(initial=0.0))
    return float(f"{DEG * top:.1e}") / DEG if top > STILL else 0.0
