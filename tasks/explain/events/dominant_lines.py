"""Spectral lines so strong that they would shape every fit: removed before a search."""

import numpy as np

from tasks.explain.events.event import AddedSignal
from tasks.explain.events.lines import (
    MAX_LINES,
    FittedLine,
    events_of_lines,
    is_steady,
    strongest_line,
)
from tasks.explain.events.residual import LEVEL_BINS, Residual
from tasks.model.parameters import ACCEL_FIRST

DOMINANT = 0.05  # of a channel's residual variance that a line must be
LEVER = 0.3  # m: how far from the axis accelerometers may be
BEYOND_MOTION = 2.0  # times the motion's own amplitude: more than any delay or filter of it makes


def find_dominant_lines(residual: Residual, predicted: np.ndarray) -> tuple[AddedSignal, ...]:
    """Steady lines that would shape every fit: most of a channel's residual, and not the motion's.

    predicted: (n, 6) readings, whose amplitude at a frequency bounds what a wrong delay, filter or
    scale factor leaves there. A periodic motion has its own lines, which are left to the fit.
    """
    if len(residual.t) < 4 * LEVEL_BINS:
        return ()
    cleaned, passed, lines = residual, list[float](), list[FittedLine]()
    while len(passed) < MAX_LINES and cleaned.white.any():
        line = strongest_line(cleaned, passed)
        if line is None or not _dominates(cleaned, line):
            break
        passed.append(line.frequency)
        if _beyond_motion(residual, line, predicted) and is_steady(cleaned, line):
            lines.append(line)
            cleaned = cleaned.minus(line.signal(residual.t))
    return events_of_lines(lines, 1 / residual.interval)


def _dominates(residual: Residual, line: FittedLine) -> bool:
    """Whether a line is a large part of a channel's residual variance."""
    known = (residual.weight > 0).sum(axis=0)
    variance = (residual.values**2).sum(axis=0) / np.maximum(known, 1)
    return bool((0.5 * np.abs(line.amplitudes) ** 2 > DOMINANT * variance)[known > 0].any())


def _beyond_motion(residual: Residual, line: FittedLine, predicted: np.ndarray) -> bool:
    """Whether, in its strongest channel, a line is larger than the motion can have made it."""
    channel = int((np.abs(line.amplitudes) / line.u).argmax())
    made = _amplitude(residual.t, predicted[:, channel], line.frequency)
    if channel >= ACCEL_FIRST:
        motion = residual.motion
        squares = [motion.rate[:, i] * motion.rate[:, j] for i in range(3) for j in range(i, 3)]
        felt = [*motion.acceleration.T, *squares]
        made += LEVER * sum(_amplitude(residual.t, each, line.frequency) for each in felt)
    return abs(line.amplitudes[channel]) > BEYOND_MOTION * made


def _amplitude(t: np.ndarray, signal: np.ndarray, frequency: float) -> float:
    """The amplitude that a signal (n,), NaN where unknown, has at a frequency (Hz)."""
    known = np.isfinite(signal)
    if not known.any():
        return 0.0
    wave = np.exp(-2j * np.pi * frequency * t[known])
    return float(2.0 * abs(wave @ (signal[known] - signal[known].mean())) / known.sum())
