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
        title=(
            f"scale factor that depends on the rate, order {order}",
            f"陀螺标度因数非线性（{order}次）",
        ),
        confused_with=("gyro_scale_asymmetry", "gyro_saturation", "structural_compliance"),
        separated_by=(
            "at least five rates of each sign on each axis, up to the full range and down to a "
            "hundredth of it",
            "每轴正反向各不少于5个速率点，覆盖满量程至其百分之一",
        ),
    )  # fmt: skip


@dataclass(frozen=True)
class ScaleAsymmetry(Term):
    """Half the difference of the scale factors for the two signs of the rate."""

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        return own(GYRO_FIRST, np.abs(inputs.rate))


GYRO_SCALE_ASYMMETRY = ScaleAsymmetry(
    "gyro_scale_asymmetry", "gyro", "sensor", "ω′ᵢ = hᵢ·|ωᵢ|", "IEEE Std 1431; IEEE Std 952",
    each_axis("half_difference", "h", ("1", 1.0, 0.02)),
    title=("scale factor that differs by the sign of the rate", "陀螺标度因数不对称性"),
    confused_with=("gyro_scale_nonlinearity", "hysteresis"),
    separated_by=(
        "small and large rates of both signs: the step of the slope at zero is the asymmetry's",
        "正反向的小速率与大速率点：零速率处斜率突变即为不对称性",
    ),
)  # fmt: skip


@dataclass(frozen=True)
class G2Sensitivity(Term):
    """A bias that follows the squares of the specific force."""

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        return crossed(GYRO_FIRST, inputs.force**2)


GYRO_G2_SENSITIVITY = G2Sensitivity(
    "gyro_g2_sensitivity", "gyro", "sensor", "ω′ᵢ = Σⱼ M_ij·fⱼ²", "IEEE Std 952; IEEE Std 1431",
    each_pair("M", ("(deg/s)/g2", G2, 0.1 / G2)),
    title=("bias that follows acceleration squared", "陀螺加速度平方灵敏度（g²项）"),
    confused_with=("gyro_scale_g_dependence", "magnetic_sensitivity", "earth_rotation"),
    separated_by=(
        "rests with each axis up, down and at 45 deg, at two headings; or a centrifuge",
        "各轴朝上、朝下及45°的静止位置并取两个航向，或离心机试验",
    ),
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
    title=("scale factor that depends on acceleration", "陀螺标度因数的加速度敏感性"),
    confused_with=("gyro_g2_sensitivity", "gyro_scale_asymmetry"),
    separated_by=(
        "the same rates with the turned axis up, down and level",
        "被测轴分别朝上、朝下与水平时重复同样的速率点",
    ),
)  # fmt: skip


@dataclass(frozen=True)
class AngularAcceleration(Term):
    """An output that follows the angular acceleration."""

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        return crossed(GYRO_FIRST, motion.acceleration)


GYRO_ANGULAR_ACCELERATION = AngularAcceleration(
    "gyro_angular_acceleration", "gyro", "sensor", "ω′ᵢ = Σⱼ A_ij·ω̇ⱼ", "IEEE Std 952",
    each_pair("A", ("s", 1.0, 0.05)),
    title=("output that follows angular acceleration", "陀螺角加速度灵敏度"),
    confused_with=("time_offset", "bandwidth"),
    separated_by=(
        "ramps about each axis with a common trigger for both clocks: a delay is alike on all "
        "axes, and the accelerometers share it",
        "两套时钟共用触发信号，绕各轴做角加速试验：时延对各轴相同且加速度计同样存在",
    ),
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
