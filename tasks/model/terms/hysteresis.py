"""Hysteresis: a bias that remembers the last motion, in its published forms.

A state between −1 and 1 follows a drive x: the rate of a gyro's own axis, the specific force of
an accelerometer's. The readings are an amplitude times the state. What a state has in common with
its drive goes to the standard's scale factor, what it always is to its bias.
"""

from collections.abc import Callable
from functools import lru_cache, partial

import numpy as np

from schemas.recording import Recording
from tasks.model.term import (
    ACCEL_FIRST,
    GYRO_FIRST,
    STILL,
    Column,
    Inputs,
    Parameter,
    SensorTerm,
    Term,
    each_axis,
    turned,
)
from tasks.motion.samples import first_order_lag
from tasks.motion.whole import Motion

# States that remember the course of an input (rate, angle or specific force), row by row.
#
# drive: (n,); NaN counts as no motion. Each state lies between −1 and 1, starts at 0 and keeps
# its value while the drive stands still.


def signs(speed: np.ndarray, still: float) -> np.ndarray:
    """(n,) −1, 0 or 1: which way it moves; 0 where it is no faster than `still`."""
    known = np.nan_to_num(speed)
    return np.where(np.abs(known) > still, np.sign(known), 0.0)


def relaxed(speed: np.ndarray, step: np.ndarray, travel: float, still: float) -> np.ndarray:
    """The state goes to the sign of the motion within a travel (Dahl's friction).

    speed: (n,) of the drive; step: (n,) s since the row before. Within a motion of one sign
    s = sign − (sign − s₀)·e^(−ψ/travel), ψ travelled since its start.
    """
    sign = signs(speed, still)
    moved = np.cumsum(np.where(sign != 0.0, np.abs(np.nan_to_num(speed)) * step, 0.0))
    starts = np.flatnonzero(np.diff(sign, prepend=np.nan) != 0)
    ends = np.append(starts[1:], len(sign)) - 1
    before = np.where(starts > 0, moved[starts - 1], 0.0)
    kept = np.exp(-(moved[ends] - before) / travel)
    state, first = 0.0, np.zeros(len(starts))
    for n, (toward, stays) in enumerate(zip(sign[starts], kept, strict=True)):
        first[n] = state
        state = toward + (state - toward) * stays if toward else state
    length = ends - starts + 1
    began, since = np.repeat(first, length), moved - np.repeat(before, length)
    return np.where(sign != 0.0, sign + (began - sign) * np.exp(-since / travel), began)


def last_sign(speed: np.ndarray, still: float) -> np.ndarray:
    """The sign of the present or the last motion: a relay about zero."""
    sign = signs(speed, still)
    return _kept(sign, sign != 0.0)


def faded(speed: np.ndarray, t: np.ndarray, seconds: float, still: float) -> np.ndarray:
    """The sign of the last motion, forgotten in time while the drive stands still."""
    return last_sign(speed, still) * _forgotten(signs(speed, still) != 0.0, t, seconds)


def late_sign(speed: np.ndarray, t: np.ndarray, seconds: float, still: float) -> np.ndarray:
    """The sign of the motion through a lag of first order: learnt and forgotten in time."""
    return first_order_lag(signs(speed, still), float(np.median(np.diff(t))), seconds)


def last_peak(speed: np.ndarray, still: float) -> np.ndarray:
    """The fastest of the present or the last motion so far, with its sign, of the fastest of all.

    Preisach's relays, all of one threshold up and the same down, remember the same.
    """
    sign = signs(speed, still)
    size = np.abs(np.nan_to_num(speed)) * np.abs(sign)
    largest = float(size.max(initial=0.0))
    if not largest:
        return sign
    starts = np.flatnonzero(np.diff(sign, prepend=np.nan) != 0)
    peak = np.concatenate([np.maximum.accumulate(part) for part in np.split(size, starts[1:])])
    return _kept(sign * peak / largest, sign != 0.0)


def stopped(drive: np.ndarray, radius: float) -> np.ndarray:
    """The drive less its play of width 2·radius, over the radius (Prandtl's stop operator)."""
    return _stopped(np.ascontiguousarray(drive, float).tobytes(), radius)


@lru_cache(maxsize=64)  # a fit asks for the same drives and radii at each of its steps
def _stopped(drive_bytes: bytes, radius: float) -> np.ndarray:
    """(n,), not to be written to."""
    drive = np.frombuffer(drive_bytes)
    rows = np.flatnonzero(np.isfinite(drive))
    found = np.zeros(len(drive))
    change = np.diff(drive[rows], prepend=drive[rows[:1]])
    found[rows] = _clipped_sums(change, radius) / radius
    found.flags.writeable = False
    return found


def _clipped_sums(changes: np.ndarray, limit: float) -> np.ndarray:
    """(n,) sₖ = clip(sₖ₋₁ + changesₖ, ±limit) from s = 0.

    Clips of shifted sums, one after another, are again such a clip: so 2, 4, 8 … rows at once.
    """
    shift, low, high = changes.copy(), np.full(len(changes), -limit), np.full(len(changes), limit)
    reach = 1
    while reach < len(changes):
        late = shift[reach:].copy()
        shift[reach:] += shift[:-reach].copy()
        below, above = low[reach:].copy(), high[reach:].copy()
        low[reach:] = np.clip(low[:-reach] + late, below, above)
        high[reach:] = np.clip(high[:-reach] + late, below, above)
        reach *= 2
    return np.clip(shift, low, high)


def _kept(values: np.ndarray, new: np.ndarray) -> np.ndarray:
    """(n,) the last value of a row that is new; 0 before any."""
    last = np.maximum.accumulate(np.where(new, np.arange(len(values)), -1))
    return np.where(last >= 0, values[np.maximum(last, 0)], 0.0)


def _forgotten(moving: np.ndarray, t: np.ndarray, seconds: float) -> np.ndarray:
    """(n,) e^(−time since the last row that moves/seconds)."""
    return np.exp(-(t - _kept(t, moving)) / seconds)


ANGLES = (0.03, 0.1, 0.3)  # rad
RADII = (0.1, 0.4)
LADDER = (0.05, 0.2, 0.5, 0.8)  # radii of plays that together make any loop
STEADY = 1e-3  # of the largest drive in a second: what changes less stands still
ANGLE = Parameter("angle", "ψ₀", "rad", "rad", (0.01, 6.0))
SECONDS = Parameter("time_constant", "τ", "s", "s", (1.0, 300.0))
SHARE = Parameter("share", "r", "of the largest", "of the largest", (0.01, 0.95))
DAHL = "P. R. Dahl, A solid friction model, 1968; IEEE Std 528"
RELAY = "F. Preisach, Über die magnetische Nachwirkung, 1935; IEEE Std 528"
AFTER_EFFECT = "C. Zener, Elasticity and Anelasticity of Metals, 1948; IEEE Std 528"
PLAY = "M. A. Krasnosel'skii and A. V. Pokrovskii, Systems with Hysteresis, 1989"
PLAYS = "A. Visintin, Differential Models of Hysteresis, 1994: Prandtl and Ishlinskii"

CONFUSED_WITH = ("gyro_scale_asymmetry", "bias_step", "bias_random_walk")
_OF_TRIAD = {
    GYRO_FIRST: ("ω′ᵢ", ("deg/s", "rad/s", 0.02)),
    ACCEL_FIRST: ("a′ᵢ", ("m/s2", "m/s2", 0.2)),
}

State = Callable[[np.ndarray, np.ndarray, float], np.ndarray]  # drive, t, shape -> state, (n,) each


def _columns(
    first: int, state: State, motion: Motion, inputs: Inputs, at: tuple[float, ...]
) -> tuple[Column, ...]:
    """A column for each shape (0 where it has none) and axis."""
    drives = motion.rate if first == GYRO_FIRST else motion.force
    return tuple(
        {first + i: state(drives[:, i], motion.t, shape)}
        for shape in at or (0.0,)
        for i in range(3)
    )


def _memory(
    first: int,
    state: State,
    equation: str,
    source: str,
    shape: Parameter | None = None,
    at: float = 0.0,
) -> SensorTerm:
    """One state for each axis of the triad that starts at channel `first`."""
    reading, printed = _OF_TRIAD[first]
    return SensorTerm(
        "hysteresis", "memory", "sensor", f"{reading} = hᵢ·sᵢ, {equation}", source,
        each_axis("amplitude", "h", printed),
        (shape,) if shape else (), (at,) if shape else (),
        reads=partial(_columns, first, state), confused_with=CONFUSED_WITH,
    )  # fmt: skip


def _sum_of_plays(first: int, drive: str) -> SensorTerm:
    """Plays of several widths: any loop that looks the same wherever it begins."""
    reading, printed = _OF_TRIAD[first]

    def reads(motion: Motion, inputs: Inputs, at: tuple[float, ...]) -> tuple[Column, ...]:
        return _columns(first, _stop, motion, inputs, LADDER)

    return SensorTerm(
        "hysteresis", "memory", "sensor",
        f"{reading} = Σᵣ hᵢᵣ·({drive} − play of {drive} with 2r)/r", PLAYS,
        tuple(p for r in LADDER for p in each_axis(f"amplitude_{r:g}", f"h_{r:g}", printed)),
        reads=reads, confused_with=CONFUSED_WITH,
    )  # fmt: skip


def _stop(drive: np.ndarray, t: np.ndarray, share: float) -> np.ndarray:
    """Of a radius that is a share of the largest drive."""
    return stopped(drive, share * _largest(drive))


def _wound_up(rate: np.ndarray, t: np.ndarray, radius: float) -> np.ndarray:
    """Of the angle turned; radius in rad."""
    return stopped(np.cumsum(np.nan_to_num(rate) * _steps(t)), radius)


def _within_an_angle(rate: np.ndarray, t: np.ndarray, angle: float) -> np.ndarray:
    return relaxed(rate, _steps(t), angle, STILL)


def _within_a_share(drive: np.ndarray, t: np.ndarray, share: float) -> np.ndarray:
    """Goes to the sign of the drive's change within a share of the largest drive."""
    return relaxed(_change(drive, t), _steps(t), share * _largest(drive), _still(drive))


def _last_change(drive: np.ndarray, t: np.ndarray, _: float) -> np.ndarray:
    return last_sign(_change(drive, t), _still(drive))


def _last_change_faded(drive: np.ndarray, t: np.ndarray, seconds: float) -> np.ndarray:
    return faded(_change(drive, t), t, seconds, _still(drive))


def _steps(t: np.ndarray) -> np.ndarray:
    return np.diff(t, prepend=t[:1])


def _change(drive: np.ndarray, t: np.ndarray) -> np.ndarray:
    return np.asarray(np.gradient(drive, t))


def _largest(drive: np.ndarray) -> float:
    return max(float(np.abs(np.nan_to_num(drive)).max(initial=0.0)), STILL)


def _still(drive: np.ndarray) -> float:
    return STEADY * _largest(drive)


def hysteresis(angle: float) -> SensorTerm:
    """A bias with the sign of the last turn about the axis; an angle (rad) of turning sets it."""
    equation = "dsᵢ/dψ = (sign ωᵢ − sᵢ)/ψ₀, ψ = ∫|ωᵢ|dt"
    return _memory(GYRO_FIRST, _within_an_angle, equation, DAHL, ANGLE, angle)


_OF_GYROS = (
    *(hysteresis(angle) for angle in ANGLES),
    _memory(
        GYRO_FIRST, lambda rate, t, _: last_sign(rate, STILL),
        "sᵢ: sign of the last turn", RELAY,
    ),
    _memory(
        GYRO_FIRST, lambda rate, t, seconds: faded(rate, t, seconds, STILL),
        "sᵢ: sign of the last turn·e^(−t/τ), t since its end", AFTER_EFFECT, SECONDS, 15.0,
    ),
    _memory(
        GYRO_FIRST, lambda rate, t, seconds: late_sign(rate, t, seconds, STILL),
        "τ·dsᵢ/dt = sign ωᵢ − sᵢ", AFTER_EFFECT, SECONDS, 8.0,
    ),
    _memory(
        GYRO_FIRST, lambda rate, t, _: last_peak(rate, STILL),
        "sᵢ: the last turn's fastest rate/ω_top", RELAY,
    ),
    _memory(GYRO_FIRST, _wound_up, "sᵢ = (θᵢ − play of θᵢ with 2ψ₀)/ψ₀", PLAY, ANGLE, 0.3),
    *(
        _memory(GYRO_FIRST, _stop, "sᵢ = (ωᵢ − play of ωᵢ with 2R)/R, R = r·ω_top", PLAY, SHARE, r)
        for r in RADII
    ),
    _memory(
        GYRO_FIRST, _within_a_share,
        "dsᵢ/dψ = (sign ω̇ᵢ − sᵢ)/R, ψ = ∫|dωᵢ|, R = r·ω_top", DAHL, SHARE, 0.3,
    ),
    _sum_of_plays(GYRO_FIRST, "ωᵢ"),
)  # fmt: skip
_OF_ACCELEROMETERS = (
    _memory(ACCEL_FIRST, _last_change, "sᵢ: sign of the last change of fᵢ", RELAY),
    _memory(
        ACCEL_FIRST, _last_change_faded,
        "sᵢ: sign of the last change of fᵢ·e^(−t/τ), t since its end", AFTER_EFFECT, SECONDS, 15.0,
    ),
    _memory(
        ACCEL_FIRST, _within_a_share, "dsᵢ/dψ = (sign ḟᵢ − sᵢ)/R, ψ = ∫|dfᵢ|, R = r·f_top", DAHL,
        SHARE, 0.3,
    ),
    _memory(
        ACCEL_FIRST, _stop, "sᵢ = (fᵢ − play of fᵢ with 2R)/R, R = r·f_top", PLAY, SHARE, 0.4,
    ),
    _sum_of_plays(ACCEL_FIRST, "fᵢ"),
)  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """Where it turned, about any axis."""
    return (*_OF_GYROS, *_OF_ACCELEROMETERS) if turned(motion) else ()
