"""Biases that change by themselves: a step, a random walk."""

from schemas.recording import Recording
from tasks.model.term import (
    ACCEL_FIRST,
    GYRO_FIRST,
    Parameter,
    SensorTerm,
    Term,
    each_channel,
    same,
)
from tasks.motion.whole import Motion

WANDER = 12.0  # chi-squared that a wander, whose strength few slow waves tell, makes of a jump
TIME = Parameter("time", "t₀", "s", "s", (0.0, 1e5))


def bias_step(first: int, time: float, count: int = 3) -> SensorTerm:
    """The biases of some channels from `first` on, of a triad or all, jump once, at a time in s."""
    channels = tuple(range(first, first + count))
    both = each_channel("Δb", ("deg/s", "rad/s", 0.05), ("m/s2", "m/s2", 0.5))
    return SensorTerm(
        "bias_step", "memory", "sensor", "bᵢ(t) = Δbᵢ for t ≥ t₀", "IEEE Std 528",
        both[first : first + count], (TIME,), (time,),
        reads=lambda motion, inputs, at: same((motion.t >= at[0]).astype(float), channels),
        rarity=WANDER, time_course="jump",
        confused_with=("bias_random_walk", "thermal_transient", "remount_misalignment"),
    )  # fmt: skip


# q of working units: Allan deviations of MEMS units rise by 1e-6 to 1e-4 rad/s and by 1e-5 to
# 1e-3 m/s² per √s; five times the largest.
WALK_RATE = each_channel(
    "q", ("(deg/s)/sqrt(s)", "(rad/s)/sqrt(s)", 5e-4), ("(m/s2)/sqrt(s)", "(m/s2)/sqrt(s)", 5e-3)
)
BIAS_RANDOM_WALK = Term(
    "bias_random_walk", "memory", "sensor", "db = q·dW, variance q²·t", "IEEE Std 952", (),
    confused_with=("thermal_transient", "bias_step", "temperature_bias"),
    time_course="random walk",
)  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """A jump of each triad and one of all channels, half-way: when is searched elsewhere."""
    middle_s = 0.5 * float(motion.t[0] + motion.t[-1])
    steps = (
        bias_step(GYRO_FIRST, middle_s), bias_step(ACCEL_FIRST, middle_s),
        bias_step(GYRO_FIRST, middle_s, 6),
    )  # fmt: skip
    return (*steps, BIAS_RANDOM_WALK)
