"""The lattice of codes that a channel's readings lie on."""

from dataclasses import dataclass

import numpy as np

OFF_CODE = 0.05  # of a step: how far a reading may lie off its code, for the rounding of a file
MIN_ON_CODE = 0.98  # share of the values that must lie on the codes; a limit need not


@dataclass(frozen=True)
class Quantiser:
    """Readings are offset + step·k with whole k; step: rad/s or m/s²."""

    step: float
    offset: float

    @property
    def through_zero(self) -> bool:
        """Whether zero is a code, so that the numbers that the unit sent are known."""
        return abs(self.offset) < OFF_CODE * self.step

    def codes(self, readings: np.ndarray) -> np.ndarray:
        """The number (n,) of each reading, whole as a float; NaN stays."""
        return np.asarray(np.rint((readings - self.offset) / self.step))


def quantiser_of(readings: np.ndarray) -> Quantiser | None:
    """The codes of one channel (n,), by the common divisor of the differences of its readings.

    None for a dead channel and for readings without a step.
    """
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
        if codes.any():
            slope, start = np.polyfit(codes, near, 1)
            step, origin = float(slope), float(start)
    off = np.abs(values - origin - step * np.round((values - origin) / step))
    if not (off <= OFF_CODE * step).mean() >= MIN_ON_CODE:
        return None
    return Quantiser(step, origin - step * round(origin / step))
