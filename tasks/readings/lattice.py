"""The lattice of codes that a channel's readings lie on."""

from dataclasses import dataclass

import numpy as np

OFF_CODE = 0.05  # of a step: how far a reading may lie off its code, for the rounding of a file
MIN_ON_CODE = 0.98  # share of the values that must lie on the codes; a limit need not
MOST_OFF = 0.1  # of those near by: no lattice
NEAREST = 30  # differences of which the divisor is sought: of words of 24 bits few are next
MIN_PART = 1e-3  # of the least difference: less is no step


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
    found = _through(values, float(apart.min()))
    return found or _through(values, _common_divisor(np.sort(apart)[:NEAREST].tolist()))


def _common_divisor(apart: list[float]) -> float:
    """The largest number that differences, smallest first, are whole multiples of, after Euclid."""
    step = apart[0]
    for one in apart:
        left = abs(one - step * round(one / step))
        while left > OFF_CODE * step > MIN_PART * apart[0]:
            step, left = left, abs(step - left * round(step / left))
    return step


def _through(values: np.ndarray, step: float) -> Quantiser | None:
    """The lattice through different values (n,) with about this step, if they lie on it."""
    origin = float(values[np.abs(values).argmin()])
    for span in (30.0, 1e3, 1e5, np.inf):  # outwards, for a rough step miscounts what is far
        near = values[np.abs(values - origin) <= span * step]
        codes = np.round((near - origin) / step)
        if codes.any():
            slope, start = np.polyfit(codes, near, 1)
            step, origin = float(slope), float(start)
            if (np.abs(near - origin - step * codes) > OFF_CODE * step).mean() > MOST_OFF:
                return None
    off = np.abs(values - origin - step * np.round((values - origin) / step))
    if not (off <= OFF_CODE * step).mean() >= MIN_ON_CODE:
        return None
    return Quantiser(step, origin - step * round(origin / step))
