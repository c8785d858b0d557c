"""What a unit remembers: its last motion, a jump of its bias, a bias that wanders."""

import numpy as np

from schemas.recording import Recording
from tasks.model.parameters import (
    ACCEL_FIRST,
    DEG,
    GYRO_FIRST,
    STILL,
    each_axis,
    each_channel,
    own,
    same,
    turned,
)
from tasks.model.term import Column, Inputs, Parameter, SensorTerm, Term
from tasks.motion.whole import Motion

ANGLES = (0.03, 0.1, 0.3)  # rad
WANDER = 12.0  # chi-squared that a wander, whose strength few slow waves tell, makes of a jump
TIME = Parameter("time", "t₀", "s", 1.0, (0.0, 1e5))


def _last_turns(motion: Motion, inputs: Inputs, at: tuple[float, ...]) -> tuple[Column, ...]:
    step = np.diff(motion.t, prepend=motion.t[:1])
    states = [last_turn(rate, step, at[0]) for rate in np.nan_to_num(motion.rate).T]
    return own(GYRO_FIRST, np.column_stack(states))


def last_turn(rate: np.ndarray, step: np.ndarray, angle: float) -> np.ndarray:
    """State (n,) between −1 and 1 that goes to the sign of the rate within an angle of turning.

    rate: (n,) rad/s; step: (n,) s since the row before. While it stands still the state stays; it
    starts at 0. Within a turn of one sign s = sign − (sign − s₀)·e^(−ψ/angle), ψ since its start.
    """
    sign = np.where(np.abs(rate) > STILL, np.sign(rate), 0.0)
    turned = np.cumsum(np.where(sign != 0.0, np.abs(rate) * step, 0.0))
    starts = np.flatnonzero(np.diff(sign, prepend=np.nan) != 0)
    ends = np.append(starts[1:], len(sign)) - 1
    before = np.where(starts > 0, turned[starts - 1], 0.0)
    kept = np.exp(-(turned[ends] - before) / angle)
    state, first = 0.0, np.zeros(len(starts))
    for n, (toward, stays) in enumerate(zip(sign[starts], kept, strict=True)):
        first[n] = state
        state = toward + (state - toward) * stays if toward else state
    length = ends - starts + 1
    began, since = np.repeat(first, length), turned - np.repeat(before, length)
    return np.where(sign != 0.0, sign + (began - sign) * np.exp(-since / angle), began)


def hysteresis(angle: float) -> SensorTerm:
    """A bias with the sign of the last turn about the axis; an angle (rad) of turning sets it."""
    return SensorTerm(
        "hysteresis", "memory", "sensor", "ω′ᵢ = hᵢ·sᵢ, dsᵢ/dψ = (sign ωᵢ − sᵢ)/ψ₀, ψ = ∫|ωᵢ|dt",
        "IEEE Std 528", each_axis("amplitude", "h", ("deg/s", DEG, 0.02)),
        (Parameter("angle", "ψ₀", "rad", 1.0, (0.01, 1.0)),), (angle,), reads=_last_turns,
        confused_with=("gyro_scale_asymmetry", "bias_step", "bias_random_walk"),
    )  # fmt: skip


def bias_step(first: int, time: float) -> SensorTerm:
    """The biases of the triad that starts at channel `first` jump once, at a time in s."""
    channels = tuple(range(first, first + 3))
    both = each_channel("Δb", ("deg/s", DEG, 0.05), ("m/s2", 1.0, 0.5))
    return SensorTerm(
        "bias_step", "memory", "sensor", "bᵢ(t) = Δbᵢ for t ≥ t₀", "IEEE Std 528",
        both[first : first + 3], (TIME,), (time,),
        reads=lambda motion, inputs, at: same((motion.t >= at[0]).astype(float), channels),
        rarity=WANDER, time_course="jump",
        confused_with=("bias_random_walk", "thermal_transient", "remount_misalignment"),
    )  # fmt: skip


BIAS_RANDOM_WALK = Term(
    "bias_random_walk", "memory", "sensor", "db = q·dW, variance q²·t", "IEEE Std 952", (),
    confused_with=("thermal_transient", "bias_step", "temperature_bias"),
    time_course="random walk",
)  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """A memory where it turned; one jump of each triad, half-way: when is searched elsewhere."""
    remembers = tuple(hysteresis(angle) for angle in ANGLES) if turned(motion) else ()
    half = 0.5 * float(motion.t[0] + motion.t[-1])
    steps = (bias_step(GYRO_FIRST, half), bias_step(ACCEL_FIRST, half))
    return (*remembers, *steps, BIAS_RANDOM_WALK)
