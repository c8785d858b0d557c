"""Timing: a delay, a clock rate, axes sampled one after another."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline

from schemas.recording import Recording
from tasks.model.term import ACCEL_FIRST, Term, single
from tasks.motion.whole import Motion

NODES = range(-4, 6)  # rows about the one asked for that an interpolated reading rests on


def read_earlier(readings: np.ndarray, late: float | np.ndarray) -> np.ndarray:
    """Readings (n, k) of `late` rows before, a number or (n,), by Lagrange's ninth degree.

    Before the first and after the last row they stay as there; what is constant stays exactly so.
    NaN near rows that are NaN.
    """
    whole = np.floor(-np.asarray(late, dtype=float))
    weights = _lagrange(-np.asarray(late) - whole)
    whole = whole.astype(int)
    if whole.ndim:
        row = np.arange(len(readings)) + whole
        own = readings.take(row, axis=0, mode="clip")
        near = (readings.take(row + node, axis=0, mode="clip") for node in NODES)
        return own + sum(w[:, None] * (at - own) for w, at in zip(weights, near, strict=True))
    reach = np.arange(NODES[0], len(readings) + NODES[-1])
    about = readings.take(reach + whole, axis=0, mode="clip")
    before = -NODES[0]
    own = about[before:][: len(readings)]
    # As sums of the steps between neighbours, which are zero where nothing changes.
    steps = np.diff(about, axis=0)
    shares = np.append(-np.cumsum(weights)[:before], np.cumsum(weights[::-1])[::-1][before + 1 :])
    filtered = [np.convolve(channel, shares[::-1], mode="valid") for channel in steps.T]
    return own + np.column_stack(filtered)


def _lagrange(part: np.ndarray) -> np.ndarray:
    """Weights (nodes, …) of the nodes' readings for a place `part` (…) of a row after node 0."""
    weights = np.ones((len(NODES), *part.shape))
    for k, node in enumerate(NODES):
        for other in NODES:
            if other != node:
                weights[k] *= (part - other) / (node - other)
    return weights


def shifted_within(motion: Motion, readings: np.ndarray, late: float | np.ndarray) -> np.ndarray:
    """Readings (n, k) of `late` seconds before, a number or (n,), in each take by itself: nothing
    is read across a re-fixing.

    Stamps that come in batches, or scatter, are no equal rows apart: between them by a spline.
    """
    shifted = np.empty_like(readings)
    for take in motion.takes:
        part = late[take] if isinstance(late, np.ndarray) else late
        if motion.evenly_timed:
            shifted[take] = read_earlier(readings[take], part / motion.interval)
        else:
            shifted[take] = _between_stamps(motion.t[take], readings[take], part)
    return shifted


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
    single("seconds", "τ", ("s", "s", 0.1)), late=lambda motion, seconds: seconds,
    confused_with=("bandwidth", "gyro_angular_acceleration", "clock_skew"),
)  # fmt: skip


# The unit's clock runs fast: what it stamps t happened at t/(1 + share).
CLOCK_SKEW = LateReadings(
    "clock_skew", "time", "signal", "y′(t) = y(t/(1 + ε))",
    "definition of a time stamp; IEEE Std 1139",
    single("share", "ε", ("1", "1", 1e-3)),
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
    "sequential sampling; IEEE Std 1293", single("step", "δ", ("s", "s", 0.01)),
    confused_with=("size_effect", "time_offset"),
)  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """Shifts of the clocks, which any motion may show."""
    return (TIME_OFFSET, CLOCK_SKEW, ACCEL_AXIS_SKEW) if len(motion.t) > 1 else ()
