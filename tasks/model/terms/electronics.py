"""What the unit's electronics do to all channels: a low-pass."""

from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.ndimage import minimum_filter1d

from schemas.recording import Recording
from tasks.model.term import Parameter, Term
from tasks.motion.samples import bridged
from tasks.motion.whole import Motion

SETTLED = 20.0  # time constants after which the filter has forgotten
REACH, FADED = 3, 5.0  # rows and time constants from what is not known: nothing is known there


@dataclass(frozen=True)
class Bandwidth(Term):
    """A Butterworth low-pass of second order on all channels, at rest before each take.

    In its time constant 1/(2π·corner) it is smooth through zero: a negative one looks ahead.
    """

    def passed(self, motion: Motion, readings: np.ndarray, values: np.ndarray) -> np.ndarray:
        if not values[0]:
            return readings
        constant = values[0] / motion.interval
        return np.concatenate([_low_passed(readings[take], constant) for take in motion.takes])


def _low_passed(readings: np.ndarray, constant: float) -> np.ndarray:
    """Readings (n, k) of one take behind the filter; constant: time constant in rows."""
    known = np.isfinite(readings)
    filled = bridged(readings)
    # Both ends go on as they are; by then a ring of this length has forgotten the other end.
    more = int(np.ceil(SETTLED * abs(constant))) + 1
    count = next_fast_len(len(filled) + 2 * more, real=True)
    padded = np.pad(filled, ((more, count - len(filled) - more), (0, 0)), mode="edge")
    s = 1j * _slope(2.0 * np.pi * rfftfreq(count))[:, None] * constant
    passed = irfft(rfft(padded, axis=0) / (1.0 + np.sqrt(2.0) * s + s**2), count, axis=0)
    reach = REACH + int(np.ceil(FADED * abs(constant)))
    clear = known.all() or minimum_filter1d(known, 2 * reach + 1, axis=0, mode="nearest")
    return np.where(clear, passed[more : more + len(filled)], np.nan)


def _slope(x: np.ndarray) -> np.ndarray:
    """What differentiating makes of a wave of x rad a row: x, by differences of sixth order.

    Unlike x itself it has no jump at the highest frequency, which would ring about every corner
    of a ramp.
    """
    return (45.0 * np.sin(x) - 9.0 * np.sin(2.0 * x) + np.sin(3.0 * x)) / 30.0


BANDWIDTH = Bandwidth(
    "bandwidth", "electronics", "signal", "Y = X/(1 + √2·s + s²), s = j·2πf·T, corner = 1/(2πT)",
    "S. Butterworth, On the theory of filter amplifiers, 1930; IEEE Std 1293",
    (Parameter("time_constant", "T", "s", 1.0, (0.0, 0.05)),),
    confused_with=("time_offset", "gyro_angular_acceleration"),
)  # fmt: skip


def corner(time_constant: float) -> float:
    """Corner frequency, Hz, of a time constant in s."""
    return 1.0 / (2.0 * np.pi * time_constant)


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """The low-pass, which any motion may show."""
    return (BANDWIDTH,) if len(motion.t) > 1 else ()
