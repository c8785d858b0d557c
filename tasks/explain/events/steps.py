"""The step of readings that were counted: the common divisor of their differences."""

from dataclasses import dataclass

import numpy as np

FUZZ = 0.05  # of a step: how far a reading may lie off its code, for the rounding of a file
MOST = 0.98  # share of the values that must lie on the codes; a limit need not


@dataclass(frozen=True)
class Codes:
    """Readings are offset + step·k with whole k; step: rad/s or m/s²."""

    step: float
    offset: float


def codes_of(readings: np.ndarray) -> Codes | None:
    """The codes of one channel (n,); None for a dead channel and for readings without a step."""
    values = np.unique(readings[np.isfinite(readings)])
    if len(values) < 3:
        return None
    apart = np.diff(values)
    apart = apart[apart > 1e-9 * np.abs(values).max()]
    if len(apart) < 2:
        return None
    step, origin = float(apart.min()), float(values[np.abs(values).argmin()])
    for span in (30.0, 1e3, 1e5, np.inf):  # outwards, for a rough step miscounts what is far
        near = values[np.abs(values - origin) <= span * step]
        codes = np.round((near - origin) / step)
        if (codes**2).sum() > 0:
            slope, start = np.polyfit(codes, near, 1)
            step, origin = float(slope), float(start)
    off = np.abs(values - origin - step * np.round((values - origin) / step))
    if not (off <= FUZZ * step).mean() >= MOST:
        return None
    return Codes(step, origin - step * round(origin / step))
