"""Electronics of the unit, common to all channels: a low-pass."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.ndimage import minimum_filter1d

from schemas.recording import Recording
from tasks.model.term import Parameter, Term
from tasks.motion.samples import bridged
from tasks.motion.whole import Motion

EVERY = np.arange(6)  # channels: gyro x, y, z, accelerometer x, y, z
SETTLED = 20.0  # time constants after which the filter has forgotten
REACH, FADED = 5, 5.0  # rows and time constants from what is not known: nothing is known there


@dataclass(frozen=True)
class Bandwidth(Term):
    """A Butterworth low-pass of first or second order, at rest before each take: one corner for
    all channels, or one for each triad.

    In its time constant 1/(2π·corner) it is smooth through zero: a negative one looks ahead.
    """

    order: int = 2

    def passed(self, motion: Motion, readings: np.ndarray, values: np.ndarray) -> np.ndarray:
        if not values.any():
            return readings
        constants = values / motion.interval
        behind = readings.copy()
        for channels, constant in zip(np.array_split(EVERY, len(values)), constants, strict=True):
            for take in motion.takes if constant else ():
                behind[take, channels] = _low_passed(readings[take, channels], constant, self.order)
        return behind


def _low_passed(readings: np.ndarray, constant: float, order: int) -> np.ndarray:
    """Readings (n, k) of one take behind the filter; constant: time constant in rows."""
    known = np.isfinite(readings)
    filled = bridged(readings)
    # Both ends go on as they are; by then a ring of this length has forgotten the other end.
    more = int(np.ceil(SETTLED * abs(constant))) + 1
    count = next_fast_len(len(filled) + 2 * more, real=True)
    padded = np.pad(filled, ((more, count - len(filled) - more), (0, 0)), mode="edge")
    s = 1j * _slope(count) * constant
    response = 1.0 / (1.0 + s if order == 1 else 1.0 + np.sqrt(2.0) * s + s**2)
    passed = irfft(rfft(padded, axis=0) * response[:, None], count, axis=0)
    reach = REACH + int(np.ceil(FADED * abs(constant)))
    clear = known.all() or minimum_filter1d(known, 2 * reach + 1, axis=0, mode="nearest")
    return np.where(clear, passed[more : more + len(filled)], np.nan)


@lru_cache(maxsize=4)  # the same lengths again and again, at two rates
def _slope(count: int) -> np.ndarray:
    """Differentiation of each wave of x rad per row in the transform of `count` rows: x, by
    differences of tenth order.

    Unlike x itself it has no jump at the highest frequency, which would ring at every corner of a
    ramp.
    """
    x = 2.0 * np.pi * rfftfreq(count)
    shares = (2100.0, -600.0, 150.0, -25.0, 2.0)
    return np.asarray(sum(c * np.sin(k * x) for k, c in enumerate(shares, start=1)) / 1260.0)


def _bandwidth(order: int, *names: str) -> Bandwidth:
    denominator = "1 + s" if order == 1 else "1 + √2·s + s²"
    return Bandwidth(
        "bandwidth", "electronics", "signal",
        f"Y = X/({denominator}), s = j·2πf·T, corner = 1/(2πT)",
        "S. Butterworth, On the theory of filter amplifiers, 1930; IEEE Std 1293",
        tuple(Parameter(name, "T", "s", "s", (0.0, 0.05)) for name in names),
        confused_with=("time_offset", "gyro_angular_acceleration", "accel_axis_skew"),
        order=order,
    )  # fmt: skip


BANDWIDTH = _bandwidth(2, "time_constant")
BANDWIDTH_BY_TRIAD = _bandwidth(2, "gyro_time_constant", "accel_time_constant")
FIRST_ORDER = _bandwidth(1, "lag")
FIRST_ORDER_BY_TRIAD = _bandwidth(1, "gyro_lag", "accel_lag")


def corner(time_constant: float) -> float:
    """Corner frequency, Hz, of a time constant in s."""
    return 1.0 / (2.0 * np.pi * time_constant)


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """The low-pass, which any motion may show: of one corner, and of one for each triad."""
    forms = BANDWIDTH, BANDWIDTH_BY_TRIAD, FIRST_ORDER, FIRST_ORDER_BY_TRIAD
    return forms if len(motion.t) > 1 else ()
