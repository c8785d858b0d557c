"""Timing: a delay, a clock rate, axes sampled one after another."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline

from schemas.recording import Recording
from tasks.model.parameters import ACCEL_FIRST, single
from tasks.model.term import Term
from tasks.motion.whole import Motion

UNEVEN = 0.02  # of the interval by which a step between stamps differs
MOSTLY = 0.9  # of the steps: rows are even but for gaps
NODES = range(-4, 6)  # rows about the one asked for that an interpolated reading rests on


def read_earlier(readings: np.ndarray, late: float | np.ndarray) -> np.ndarray:
    """Readings (n, k) of `late` rows before, a number or (n,), by Lagrange's ninth degree.

    Before the first and after the last row they stay as there. NaN near rows that are NaN.
    """
    whole = np.floor(-np.asarray(late, dtype=float))
    part = -np.asarray(late) - whole
    near = _rows_about(readings, whole.astype(int))
    own = near(0)
    shifted = own.copy()  # and what differs from it: what is constant stays so exactly
    for node in NODES:
        if node == 0:
            continue
        weight = np.ones_like(part)
        for other in NODES:
            if other != node:
                weight = weight * (part - other) / (node - other)
        shifted += weight[..., None] * (near(node) - own)
    return shifted


def _rows_about(readings: np.ndarray, whole: np.ndarray) -> Callable[[int], np.ndarray]:
    """Readings (n, k) of `whole` rows, (n,) or a number for all, and a node's number later."""
    rows = np.arange(len(readings))
    if whole.ndim:
        return lambda node: readings.take(rows + whole + node, axis=0, mode="clip")
    reach = np.arange(NODES[0], len(readings) + NODES[-1])
    near = readings.take(reach + whole, axis=0, mode="clip")
    return lambda node: near[node - NODES[0] :][: len(readings)]


def shifted_within(motion: Motion, readings: np.ndarray, late: float | np.ndarray) -> np.ndarray:
    """Readings (n, k) of `late` seconds before, a number or (n,), in each take by itself: nothing
    is read across a re-fixing.

    Stamps that come in batches, or scatter, are no equal rows apart: between them by a spline.
    """
    shifted, even = np.empty_like(readings), _even(motion)
    for take in motion.takes:
        part = late[take] if isinstance(late, np.ndarray) else late
        if even:
            shifted[take] = read_earlier(readings[take], part / motion.interval)
        else:
            shifted[take] = _between_stamps(motion.t[take], readings[take], part)
    return shifted


def _even(motion: Motion) -> bool:
    """Whether rows are equal times apart, but for gaps."""
    steps = np.diff(motion.t)
    usual = np.abs(steps - motion.interval) < UNEVEN * motion.interval
    return bool(usual.mean() > MOSTLY) if len(steps) else True


def _between_stamps(t: np.ndarray, readings: np.ndarray, late: float | np.ndarray) -> np.ndarray:
    known = np.isfinite(readings).all(axis=1)
    if known.sum() < len(NODES):
        return readings
    earlier = np.clip(t - late, t[known][0], t[known][-1])
    shifted = CubicSpline(t[known], readings[known])(earlier)
    shifted[~known] = np.nan
    return np.asarray(shifted)


@dataclass(frozen=True)
class LateReadings(Term):
    """At t the unit says what happened `late` seconds before, by the term's one parameter."""

    late: Callable[[Motion, float], float | np.ndarray] = field(kw_only=True)

    def passed(self, motion: Motion, readings: np.ndarray, values: np.ndarray) -> np.ndarray:
        if not values[0]:
            return readings
        return shifted_within(motion, readings, self.late(motion, values[0]))


TIME_OFFSET = LateReadings(
    "time_offset", "time", "signal", "y′(t) = y(t − τ)",
    "definition of a time stamp; IEEE Std 1554",
    single("seconds", "τ", ("s", 1.0, 0.1)), late=lambda motion, seconds: seconds,
    confused_with=("bandwidth", "gyro_angular_acceleration", "clock_skew"),
)  # fmt: skip


# The unit's clock runs fast: what it stamps t happened at t/(1 + share).
CLOCK_SKEW = LateReadings(
    "clock_skew", "time", "signal", "y′(t) = y(t/(1 + ε))",
    "definition of a time stamp; IEEE Std 1139",
    single("share", "ε", ("1", 1.0, 1e-3)),
    late=lambda motion, share: motion.t * share / (1.0 + share),
    confused_with=("time_offset", "dropped_samples", "table_scale"),
)  # fmt: skip


@dataclass(frozen=True)
class AccelAxisSkew(Term):
    """The accelerometers are read one after another: y one step after x, z two."""

    def passed(self, motion: Motion, readings: np.ndarray, values: np.ndarray) -> np.ndarray:
        if not values[0]:
            return readings
        skewed = readings.copy()
        for axis in (1, 2):
            channel = slice(ACCEL_FIRST + axis, ACCEL_FIRST + axis + 1)
            read = readings[:, channel]
            skewed[:, channel] = shifted_within(motion, read, -axis * values[0])
        return skewed


ACCEL_AXIS_SKEW = AccelAxisSkew(
    "accel_axis_skew", "time", "signal", "a′_y(t) = a_y(t + δ), a′_z(t) = a_z(t + 2δ)",
    "sequential sampling; IEEE Std 1293", single("step", "δ", ("s", 1.0, 0.01)),
    confused_with=("size_effect", "time_offset"),
)  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """Shifts of the clocks, which any motion may show."""
    return (TIME_OFFSET, CLOCK_SKEW, ACCEL_AXIS_SKEW) if len(motion.t) > 1 else ()
